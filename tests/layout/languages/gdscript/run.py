"""Runs `blocks.gd` as Python; `fill` sets a member by its functions."""

import itertools, re, struct, sys

class PackedByteArray(bytearray):
    def resize(self, n):
        self[:] = b"\xaa" * n
    def fill(self, value):
        self[:] = bytes([value]) * len(self)

FORMATS = {"s8": "b", "u8": "B", "s16": "h", "u16": "H", "s32": "i", "u32": "I", "s64": "q", "u64": "Q",
           "half": "e", "float": "f", "double": "d"}
for name, form in FORMATS.items():
    def encode(self, at, value, form="<" + form):
        struct.pack_into(form, self, at, value)
    def decode(self, at, form="<" + form):
        return struct.unpack_from(form, self, at)[0]
    setattr(PackedByteArray, "encode_" + name, encode)
    setattr(PackedByteArray, "decode_" + name, decode)

class Value:
    def __init__(self, *parts):
        for name, part in zip("xyzw", parts):
            setattr(self, name, part)
    def __eq__(self, other):
        return self.__dict__ == other.__dict__

Vector2 = Vector3 = Vector4 = Vector2i = Vector3i = Vector4i = Basis = Projection = Value
PackedFloat64Array = PackedInt64Array = list
maxi = max

def translated(text):
    """The script as Python; the class of each member that is a structure, and the type of each other."""
    lines, structures, types, name = [], {}, {}, ""
    for line in text.splitlines():
        begin = re.match(r"class (\w+):", line)
        function = re.match(r"\tstatic func (\w+)\((.*)\) -> ([\w]+):", line)
        of = re.match(r"\t## Where a `(\w+)` begins", line)
        constant = re.match(r"(\t?)const (\w+) := (\d+)$", line)
        if begin:
            name = begin[1]
            lines.append(line)
        elif of:
            structure = of[1]
        elif line.strip().startswith("#") or not line:
            continue
        elif constant:
            lines.append(f"{constant[1]}{constant[2]} = {constant[3]}")
        elif function:
            if function[1].startswith("at_"):
                structures[name, function[1][3:]] = structure
            elif function[1].startswith("get_"):
                types[name, function[1][4:]] = function[3]
            parameters = re.sub(r": \w+", "", function[2])
            lines += ["\t@staticmethod", f"\tdef {function[1]}({parameters}):"]
        else:
            line = re.sub(r"\bvar (\w+) := ", r"\1 = ", line).replace(" / ", " // ")
            lines.append(re.sub(r"(?<![\w.])(SIZE|size_for)\b", name + r".\1", line))
    return "\n".join(lines), structures, types

code, structures, types = translated(open("blocks.gd").read())
scope = dict(globals())
exec(code, scope)

def number(k, width, is_float, is_signed, is_bool):
    if is_bool:
        return int(k % 3 == 0)
    if width > 2:
        return k + 1
    form = {1: "B", 2: "H"}[width]
    bits = struct.pack("<" + form, k % (251 if width == 1 else 65521) + 1)
    return struct.unpack("<" + ("e" if is_float else form.lower() if is_signed else form), bits)[0]

def fill(buffer, k, root, path, counts, columns, rows, *kind):
    for index in itertools.product(*(range(count) for count in counts)):
        index, at, owner = list(index), 0, root
        for name, dims in path[:-1]:
            at = getattr(scope[owner], "at_" + name)(at, *(index.pop(0) for _ in range(dims)))
            owner = structures[owner, name]
        name, ty = path[-1][0], types[owner, path[-1][0]]
        parts = [number(k + i, *kind) for i in range(columns * rows)]
        k += len(parts)
        if ty in ("Basis", "Projection"):
            value = Value(*(Value(*parts[c * rows:(c + 1) * rows]) for c in range(columns)))
        elif ty in ("bool", "int", "float"):
            value = parts[0]
        else:
            value = parts if ty.endswith("Array") else Value(*parts)
        getattr(scope[owner], "set_" + name)(buffer, at, *index, value)
        assert getattr(scope[owner], "get_" + name)(buffer, at, *index) == value, (owner, name)
    return k

