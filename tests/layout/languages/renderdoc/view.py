"""Runs in RenderDoc: views the captured buffer by each format of a directory, and writes what it shows.

Lines of `shown`: the format's file, a path, the byte, and the value; of a runtime-sized tail the file, a
column, and the values of the first two elements. `failed` has what went wrong.
"""

import glob
import os
import re
import time
import traceback

import qrenderdoc
import renderdoc
from PySide2 import QtCore, QtWidgets

HERE = os.environ["LANDFALL_VIEW"]
WRAPPER = re.compile(r"_(row|element|vector)_*$")
context = pyrenderdoc  # noqa: F821, RenderDoc defines it
window = context.Extensions().GetMiniQtHelper()


def on_window_thread(function):
    """What a function returns on the thread of the windows: this script has its own."""
    results = []

    def call():
        try:
            results.append((function(), None))
        except Exception:
            results.append((None, traceback.format_exc()))

    window.InvokeOntoUIThread(call)
    wait(lambda: results)
    value, error = results[0]
    if error:
        raise RuntimeError(error)
    return value


def wait(condition):
    """Whether a condition comes true within 30 seconds."""
    end = time.monotonic() + 30
    while not condition():
        if time.monotonic() > end:
            raise RuntimeError("nothing for 30 seconds")
        time.sleep(0.005)


def rows(model, parent, within, kind):
    """The rows of a tree with paths; structures that pad an element are left out of these."""
    for row in range(model.rowCount(parent)):
        index = model.index(row, 0, parent)
        name, value, byte, ty = (str(model.data(model.index(row, c, parent))) for c in range(4))
        element = re.fullmatch(r".*(\[\d+\])", name)
        if element:
            path = within + element[1]
        elif name in ("value", "elements") and WRAPPER.search(kind):
            path = within
        else:
            path = within + "." + name if within else name
        ty = re.sub(r"\[\d+\]$", "", ty)
        if value and byte:
            yield path, byte, value.replace("\n", " ")
        else:
            yield from rows(model, index, path, ty)


def trees():
    everything = QtWidgets.QApplication.instance().allWidgets()
    return [widget for widget in everything if widget.objectName() == "fixedVars"]


def view(buffer, text):
    """What RenderDoc shows of a buffer by a format."""
    before = on_window_thread(lambda: {int(widget.winId()) for widget in trees()})

    def open_viewer():
        viewer = context.ViewBuffer(0, buffer.length, buffer.resourceId, text)
        context.AddDockWindow(viewer.Widget(), qrenderdoc.DockReference.MainToolArea, None)
        return [widget for widget in trees() if int(widget.winId()) not in before][0]

    tree = on_window_thread(open_viewer)

    def shown():
        host = tree
        while host.objectName() != "BufferViewer":
            host = host.parentWidget()
        lines = ["\t".join(row) for row in rows(tree.model(), QtCore.QModelIndex(), "", "")]
        for table in host.findChildren(QtWidgets.QTableView):
            model = table.model()
            if model is None or model.rowCount() < 2:
                continue
            for column in range(1, model.columnCount()):
                head = model.headerData(column, QtCore.Qt.Horizontal)
                values = [str(model.data(model.index(row, column))).strip() for row in (0, 1)]
                lines.append("\t".join([str(head), *values]))
        return host, lines

    # It reads the buffer on another thread.
    last, same = None, 0
    while same < 3:
        time.sleep(0.1)
        host, lines = on_window_thread(shown)
        same = same + 1 if lines and lines == last else 0
        last = lines
    on_window_thread(host.close)
    return last


try:
    capture = os.path.join(HERE, "frame_capture.rdc")
    context.LoadCapture(capture, renderdoc.ReplayOptions(), capture, False, True)
    wait(lambda: context.IsCaptureLoaded() and not context.IsCaptureLoading())
    end = context.GetLastAction().eventId
    context.SetEventID([], end, end)
    captured = context.GetBuffers()[0]
    with open(os.path.join(HERE, "shown"), "w") as out:
        for path in sorted(glob.glob(os.path.join(HERE, "*.format"))):
            with open(path) as file:
                text = file.read()
            for line in view(captured, text):
                out.write(f"{os.path.basename(path)}\t{line}\n")
except Exception:
    with open(os.path.join(HERE, "failed"), "w") as out:
        out.write(traceback.format_exc())
# Without questions about what to save.
os._exit(0)
