#!/usr/bin/env python3
"""Reads Houdini geometry that the program writes with a reader of its own, and compares it with the same data as .ply.

usage: houdini_geometry.py PROGRAM
exit:  0 all agree, 1 some differ, 77 skipped (there is no libblosc to read .bgeo.sc with)
"""

import ctypes
import ctypes.util
import os
import struct
import subprocess
import sys
import tempfile


class Json:
    """Houdini's binary JSON, little-endian. Strings may be defined once and referred to afterwards."""

    NUMBERS = {0x11: "b", 0x12: "h", 0x13: "i", 0x14: "q", 0x18: "e", 0x19: "f", 0x1A: "d", 0x21: "B", 0x22: "H"}
    CONSTANTS = {0x00: None, 0x30: False, 0x31: True}

    def __init__(self, data):
        assert data[:5] == b"\x7fNSJb", data[:5]
        self.data, self.at, self.strings = data, 5, {}

    def take(self, format):
        values = struct.unpack_from("<" + format, self.data, self.at)
        self.at += struct.calcsize("<" + format)
        return values

    def length(self):
        (first,) = self.take("B")
        return first if first < 0xF1 else self.take({0xF2: "H", 0xF4: "I", 0xF8: "q"}[first])[0]

    def text(self):
        return self.take("%ds" % self.length())[0].decode()

    def define_strings(self):
        while self.data[self.at] in (0x2B, 0x2D):
            token, key = self.take("B")[0], self.length()
            self.strings[key] = self.text() if token == 0x2B else None

    def value(self):
        self.define_strings()
        (token,) = self.take("B")
        if token in self.CONSTANTS:
            return self.CONSTANTS[token]
        if token in self.NUMBERS:
            return self.take(self.NUMBERS[token])[0]
        if token == 0x10:
            return self.take("B")[0] != 0
        if token == 0x26:
            return self.strings[self.length()]
        if token == 0x27:
            return self.text()
        if token == 0x40:
            return self.uniform_array()
        assert token in (0x5B, 0x7B), "token %#x at byte %d" % (token, self.at - 1)
        values = []
        while True:
            self.define_strings()
            if self.data[self.at] == token + 2:
                break
            values.append(self.value())
        self.at += 1
        return values if token == 0x5B else pairs(values)

    def uniform_array(self):
        (kind,), count = self.take("B"), self.length()
        if kind != 0x10:
            return list(self.take("%d%s" % (count, self.NUMBERS[kind])))
        words = self.take("%dI" % ((count + 31) // 32))
        return [bool(words[i // 32] >> i % 32 & 1) for i in range(count)]


def pairs(values):
    """The map of a list of keys and values, which may be one already."""
    return values if isinstance(values, dict) else dict(zip(values[::2], values[1::2]))


def unpacked(data):
    """The content of an .sc file: checks its table of blocks, too."""
    library = ctypes.CDLL(ctypes.util.find_library("blosc") or "libblosc.so.1")
    assert data[:4] == b"scf1" and data[-4:] == b"1fcs"
    (table_bytes,) = struct.unpack(">Q", data[-12:-4])
    end = len(data) - 12 - table_bytes
    at = start = 12 + struct.unpack(">Q", data[4:12])[0]
    content, offsets, sizes = b"", [], []
    while at < end:
        size, _, packed_size = struct.unpack("<III", data[at + 4 : at + 16])
        block = ctypes.create_string_buffer(size)
        assert library.blosc_decompress(data[at : at + packed_size], block, ctypes.c_size_t(size)) == size
        offsets.append(at - start)
        sizes.append(size)
        content += block.raw
        at += packed_size
    assert list(struct.unpack(">%dQ" % (table_bytes // 8), data[end:-12])) == offsets[1:] + [1 << 20, sizes[-1]]
    return content


def read_houdini(path):
    with open(path, "rb") as file:
        data = file.read()
    reader = Json(unpacked(data) if path.endswith(".sc") else data)
    root = pairs(reader.value())
    assert reader.at == len(reader.data)
    columns = {}
    for definition, body in pairs(root["attributes"])["pointattributes"]:
        body = pairs(body)
        values = pairs(body["values"])
        assert values["pagesize"] == 1024 and "packing" not in values
        columns[pairs(definition)["name"]] = rows_of(values["rawpagedata"], values["size"])
        assert len(values["rawpagedata"]) == values["size"] * root["pointcount"]
    points = pairs(pairs(root["topology"])["pointref"])["indices"]
    assert len(points) == root["vertexcount"]
    faces = []
    for definition, body in root["primitives"]:
        body = pairs(body)
        assert pairs(definition)["type"] == "p_r" and body["r_v"] == [3, body["n_p"]] and body["s_v"] == 0
        faces += [tuple(points[3 * i + c] for c in (0, 2, 1)) for i in range(body["n_p"])]
    assert len(faces) == root["primitivecount"]
    return columns, faces


def rows_of(numbers, size):
    return [tuple(numbers[i : i + size]) for i in range(0, len(numbers), size)]


def read_ply(path):
    """Positions, velocities, ids and faces of the program's own .ply."""
    with open(path, "rb") as file:
        lines = []
        while not lines or lines[-1] != "end_header":
            lines.append(file.readline().decode().strip())
        data = file.read()
    words = [line.split() for line in lines]
    counts = {w[1]: int(w[2]) for w in words if w[0] == "element"}
    before_faces = lines[: [line.startswith("element face") for line in lines + ["element face"]].index(True)]
    names = [line.split()[2] for line in before_faces if line.startswith("property")]
    kinds = "".join({"float": "f", "int": "i", "uint": "I"}[line.split()[1]] for line in before_faces
                    if line.startswith("property"))
    row = struct.Struct("<" + kinds)
    rows = [dict(zip(names, row.unpack_from(data, i * row.size))) for i in range(counts["vertex"])]
    faces, at = [], len(rows) * row.size
    for _ in range(counts.get("face", 0)):
        faces.append(struct.unpack_from("<3i", data, at + 1))
        at += 13 + (4 if "property int component" in lines else 0)
    columns = {"P": [(r["x"], r["y"], r["z"]) for r in rows], "v": [(r["vx"], r["vy"], r["vz"]) for r in rows]}
    if "id" in names:
        columns["id"] = [(r["id"],) for r in rows]
    return columns, faces


def main():
    program = os.path.abspath(sys.argv[1])
    try:
        ctypes.CDLL(ctypes.util.find_library("blosc") or "libblosc.so.1")
    except OSError:
        print("skipped: there is no libblosc")
        return 77
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)

        failures = 0
        for ending in (".ply", ".bgeo", ".bgeo.sc"):
            run("sample", "drop", "p" + ending, "--particles", "3000", "--frames", "1", "--seed", "7")
            run("mesh", "p.ply", "m" + ending, "--radius", "1.5dx")
        for name in ("p", "m"):
            expected = read_ply(os.path.join(folder, name + ".ply"))
            for ending in (".bgeo", ".bgeo.sc"):
                columns, faces = read_houdini(os.path.join(folder, name + ending))
                agrees = faces == expected[1] and all(columns.get(key) == rows for key, rows in expected[0].items())
                print(name + ending, len(columns["P"]), "points", len(faces), "faces", "agree" if agrees else "DIFFER")
                failures += not agrees
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
