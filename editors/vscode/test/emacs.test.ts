// Emacs with the lines that the book gives shows findings and hovers. EMACS_PROGRAM names the program.

import assert from "node:assert/strict";
import * as path from "node:path";
import { test } from "node:test";
import { editorSession } from "./client";

const emacs = process.env.EMACS_PROGRAM;

/** What is typed and asked: a member more in bytes that were padding. No grammar is installed here. */
const typed = `
(define-derived-mode glsl-mode prog-mode "GLSL")
(define-derived-mode wgsl-mode prog-mode "WGSL")
(add-to-list 'auto-mode-alist '("\\\\.frag\\\\'" . glsl-mode))
(package-initialize)
(require 'eglot)
(require 'json)
(setq eglot-sync-connect 30)
(load (expand-file-name "../init.el"))
(defun wait-until (what holds)
  (let ((end (+ (float-time) 60)) found)
    (while (not (setq found (funcall holds)))
      (when (> (float-time) end) (error "%s does not come" what))
      (accept-process-output nil 0.05))
    found))
(find-file "point_lights_450.frag")
(run-hooks 'post-command-hook)
(wait-until "the server" #'eglot-current-server)
(search-forward "vec3 pos")
(end-of-line)
(insert "\\n    float radius;")
(eglot--signal-textDocument/didChange)
(let* ((found (car (wait-until "a finding" (lambda () (flymake-start) (flymake-diagnostics)))))
       (line (progn (goto-char (flymake-diagnostic-beg found)) (thing-at-point 'line)))
       (hover (progn
                (goto-char (point-min))
                (search-forward "radius")
                (backward-char)
                (jsonrpc-request (eglot-current-server) :textDocument/hover
                                 (eglot--TextDocumentPositionParams)))))
  (princ (json-encode
          (list (cons "finding" (flymake-diagnostic-text found))
                (cons "line" line)
                (cons "hover" (plist-get (plist-get hover :contents) :value))))))
(set-buffer-modified-p nil)
(eglot-shutdown (eglot-current-server))
`;

test("Emacs shows a finding and hovers with what the book gives", () => {
  assert(emacs !== undefined, "EMACS_PROGRAM names Emacs with eglot, such as Debian's emacs-nox and elpa-eglot");
  const found = editorSession("elisp", { init: "init.el", typed: "typed.el" }, typed, (place) => ({
    command: emacs,
    args: ["--batch", "--load", path.join(place, "typed.el")],
    env: { HOME: place },
  }));
  assert.match(found.finding ?? "", /layout-drift/);
  assert.match(found.line ?? "", /PointLightBlock/);
  // std140: pos is 12 bytes, so a float fits at 12.
  assert.match(found.hover ?? "", /offset \*\*12\*\*/);
});
