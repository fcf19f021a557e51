#!/usr/bin/env python3
"""Files of other programs, read by the program and by readers of their own: VTK's, and those below for Houdini's
geometry, PRT and the classic format. All point attributes must agree as 32-bit floats or as integers.

usage: foreign_files.py PROGRAM FOLDER VENV
       FOLDER: the files; VENV: a virtual environment, into which vtk and usd-core are installed if they are not there
exit:  0 all agree, 1 some differ, 77 skipped (there are no files)
"""

import csv
import gzip
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import zlib

from houdini_geometry import Json, pairs, unpacked
from virtual_environment import run_with

# Files that hold no points that can be read, and what the program must say.
REFUSED = {
    "laika__packed_points_simple_16_5.bgeo": ["PackedGeometry", "Unpack"],
    "partio__test.geo": ["classic", "text"],
}


def float32(number):
    return struct.unpack("<f", struct.pack("<f", number))[0]


# Houdini.


def paged(values, rows):
    """The rows of an attribute stored in pages."""
    size, page_rows, raw = values["size"], values["pagesize"], values["rawpagedata"]
    packing = values.get("packing") or [size]
    constant = values.get("constantpageflags") or [[] for _ in packing]
    result, at = [[] for _ in range(rows)], 0
    for first in range(0, rows, page_rows):
        page = range(first, min(rows, first + page_rows))
        for part, width in enumerate(packing):
            is_constant = bool(constant[part]) and constant[part][first // page_rows]
            for row in page:
                result[row] += raw[at : at + width]
                at += 0 if is_constant else width
            at += width if is_constant else 0
    return [tuple(row) for row in result]


def read_houdini(path):
    with open(path, "rb") as file:
        data = file.read()
    if data[:2] == b"\x1f\x8b":
        data = gzip.decompress(data)
    if data[:5] == b"BgeoV":
        return read_classic(data)
    if data[:4] == b"scf1":
        data = unpacked(data)
    root = pairs(json.loads(data) if data[:1] == b"[" else Json(data).value())
    columns = {}
    for definition, body in pairs(root["attributes"]).get("pointattributes", []):
        definition, body = pairs(definition), pairs(body)
        if definition["type"] != "numeric":
            continue
        values = pairs(body["values"])
        if "tuples" in values:
            rows = [tuple(row) for row in values["tuples"]]
        elif "arrays" in values:
            rows = list(zip(*values["arrays"]))
        else:
            rows = paged(values, root["pointcount"])
        columns[definition["name"]] = rows
    columns["P"] = [row[:3] for row in columns["P"]]
    return columns, pairs(root["info"]).get("bounds") if root["pointcount"] else None


def read_classic(data):
    points, *_, attributes = struct.unpack_from(">5i", data, 9)[:1] + struct.unpack_from(">i", data, 25)
    at, formats, names = 41, ">4f", []
    for _ in range(attributes):
        (length,) = struct.unpack_from(">H", data, at)
        name = data[at + 2 : at + 2 + length].decode()
        size, kind = struct.unpack_from(">Hi", data, at + 2 + length)
        at += 2 + length + 6 + 4 * size
        assert kind in (0, 1, 5), "an attribute of strings"
        names.append((name, size))
        formats += "%d%s" % (size, "i" if kind == 1 else "f")
    row, columns = struct.Struct(formats), {"P": []}
    for i in range(points):
        values = list(row.unpack_from(data, at + i * row.size))
        columns["P"].append(tuple(values[:3]))
        values = values[4:]
        for name, size in names:
            columns.setdefault(name, []).append(tuple(values[:size]))
            values = values[size:]
    return columns, None


# PRT.

PRT_TYPES = "hiqefdHIQbB"


def read_prt(path):
    with open(path, "rb") as file:
        data = file.read()
    if data[:5] == b"\xc0PRT2":
        return read_prt2(data)
    header, _, version, count = struct.unpack_from("<i32siq", data, 8)
    at = header + 4
    channels, width = struct.unpack_from("<2i", data, at)
    at += 8
    columns, definitions = {}, []
    for _ in range(channels):
        name, kind, arity, offset = struct.unpack_from("<32s3i", data, at)
        definitions.append((name.rstrip(b"\0").decode(), struct.Struct("<%d%s" % (arity, PRT_TYPES[kind])), offset))
        at += width
    rows = zlib.decompress(data[at:])
    size = len(rows) // count
    for name, format, offset in definitions:
        columns[name] = [format.unpack_from(rows, i * size + offset) for i in range(count)]
    columns["P"] = columns.pop("Position")
    return columns, None


def read_prt2(data):
    def text(at):
        return data[at + 1 : at + 1 + data[at]].decode(), at + 1 + data[at]

    at, columns, definitions = 12, {}, []
    while at < len(data):
        kind, (length,) = data[at : at + 4], struct.unpack_from("<q", data, at + 4)
        at, end = at + 12, at + 12 + length
        if kind == b"Chan":
            count, at = data[at], at + 1
            for _ in range(count):
                name, at = text(at)
                type, at = text(at)
                arity, number = type.split(" * ") if "*" in type else (1, type)
                letter = {"float32": "f", "uint32": "I", "int32": "i", "float64": "d"}[number]
                definitions.append((name, struct.Struct("<%d%s" % (int(arity), letter))))
                at += 1
        if kind == b"Part":
            _, at = text(at)
            _, at = text(at)
            _, blocks = struct.unpack_from("<qq", data, at)
            at += 16
            for _ in range(blocks):
                size, rows = struct.unpack_from("<ii", data, at)
                packed = zlib.decompress(data[at + 8 : at + 8 + size])
                at += 8 + size
                for i in range(rows):
                    row = packed[i::rows]
                    for name, format in definitions:
                        columns.setdefault(name, []).append(format.unpack(row[: format.size]))
                        row = row[format.size :]
        at = end
    columns["P"] = columns.pop("Position")
    return columns, None


# VTK.


def read_vtk(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOLegacy import vtkDataSetReader
    from vtkmodules.vtkIOXML import vtkXMLGenericDataObjectReader

    reader = vtkDataSetReader() if path.endswith(".vtk") else vtkXMLGenericDataObjectReader()
    reader.SetFileName(path)
    if path.endswith(".vtk"):
        reader.ReadAllScalarsOn()
        reader.ReadAllVectorsOn()
        reader.ReadAllFieldsOn()
    reader.Update()
    found = reader.GetOutput()
    columns = {"P": vtk_to_numpy(found.GetPoints().GetData()).tolist()}
    data = found.GetPointData()
    for i in range(data.GetNumberOfArrays()):
        rows = vtk_to_numpy(data.GetArray(i)).tolist()
        columns[data.GetArrayName(i)] = rows if rows and isinstance(rows[0], list) else [(x,) for x in rows]
    return columns, found.GetBounds()


# USD.


def read_usd(path):
    """The points of the only prim of type Points, in world coordinates at the first time sample."""
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.Open(path)
    prim = next(prim for prim in stage.Traverse() if prim.IsA(UsdGeom.Points))
    times = UsdGeom.Points(prim).GetPointsAttr().GetTimeSamples()
    time = times[0] if times else Usd.TimeCode.Default()
    matrix = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time)
    scale = math.cbrt(abs(matrix.GetDeterminant3()))
    vector = {"point3f[]": matrix.TransformAffine, "vector3f[]": matrix.TransformDir}
    own_names = {"points": "P", "velocities": "v", "ids": "id", "widths": "pscale", "primvars:displayColor": "Cd"}
    columns = {}
    for attribute in prim.GetAttributes():
        name, value = attribute.GetName(), attribute.Get(time)
        if value is None or not (name in own_names or name.startswith("primvars:")):
            continue
        if str(attribute.GetTypeName()) in vector:
            rows = [tuple(vector[str(attribute.GetTypeName())](Gf.Vec3d(row))) for row in value]
        else:
            rows = [tuple(row) if hasattr(row, "__len__") else (row,) for row in value]
        if name == "widths":
            rows = [(width / 2 * scale,) for (width,) in rows]
        columns[own_names.get(name, name.removeprefix("primvars:"))] = rows
    return columns, None


# What the program makes of a file.


def read_program(program, path, folder):
    """All point attributes, through `convert`; meshes as particles."""
    info = json.loads(subprocess.run([program, "info", "--json", path], check=True, capture_output=True).stdout)
    out = os.path.join(folder, "out" + (".csv" if info["kind"] == "particles" else ".vtp"))
    subprocess.run([program, "convert", path, out, "--overwrite", "-q"], check=True, capture_output=True)
    if out.endswith(".vtp"):
        return read_vtk(out)[0], info
    with open(out, newline="") as file:
        table = list(csv.DictReader(file))
    columns = {"P": [tuple(float(row[c]) for c in "xyz") for row in table]}
    names = [name for name in (table[0] if table else []) if name not in "xyz"]
    if "vx" in names:
        columns["velocity"] = [tuple(float(row["v" + c]) for c in "xyz") for row in table]
    for name in names:
        if name not in ("vx", "vy", "vz"):
            base = name.split(".")[0].split("[")[0]
            columns.setdefault(base, [() for _ in table])
            columns[base] = [old + (float(row[name]),) for old, row in zip(columns[base], table)]
    return columns, info


VELOCITIES = ("v", "velocity", "vel", "Velocity")


def differences(expected, found, info, bounds):
    """The names of attributes that differ."""
    wrong = []
    for name, rows in expected.items():
        key = "velocity" if name in VELOCITIES else name
        key = key if key in found or name != "N" else "Normals"
        others = found.get(key)
        if others is None or len(others) != len(rows):
            wrong.append(name if rows else "")
            continue
        for row, other in zip(rows, others):
            if [float32(x) for x in row] != [float32(x) for x in other]:
                wrong.append(name)
                break
    if info["points"] != len(expected["P"]):
        wrong.append("the number of points")
    if bounds is not None and expected["P"]:
        low, high = info["lower"], info["upper"]
        mine = [x for pair in zip(low, high) for x in pair]
        if any(abs(a - b) > 1e-5 * max(1, abs(b)) for a, b in zip(mine, bounds)):
            wrong.append("bounds")
    return [name for name in wrong if name]


def main():
    program, folder, venv = os.path.abspath(sys.argv[1]), sys.argv[2], sys.argv[3]
    if not os.path.isdir(folder):
        print("skipped: there are no files of other programs in " + folder)
        return 77
    lacks = run_with(venv, {"vtkmodules": "vtk", "pxr": "usd-core"}, may_lack=True)
    if lacks is not None:
        print("files of VTK and USD, and meshes, are left out: " + lacks)
    failures = count = 0
    with tempfile.TemporaryDirectory() as scratch:
        for name in sorted(os.listdir(folder)):
            path = os.path.join(folder, name)
            if name == "README.md":
                continue
            count += 1
            if name in REFUSED:
                said = subprocess.run([program, "convert", path, os.path.join(scratch, "refused.ply")],
                                      capture_output=True, text=True)
                good = said.returncode == 1 and all(part in said.stderr for part in REFUSED[name])
                print("%-50s %s" % (name, "refused as it should" if good else "WRONG: " + said.stderr))
                failures += not good
                continue
            read = {"vtk": read_vtk, "vtu": read_vtk, "prt": read_prt, "usda": read_usd}.get(name.rsplit(".")[-1], read_houdini)
            is_mesh = name.startswith(("gamedev", "houio", "chunleili"))
            if lacks is not None and (read in (read_vtk, read_usd) or is_mesh):
                continue
            expected, bounds = read(path)
            found, info = read_program(program, path, scratch)
            wrong = differences(expected, found, info, bounds)
            print("%-50s %6d points, %s: %s" % (name, len(expected["P"]), ", ".join(sorted(expected)),
                                              "DIFFERENT: " + ", ".join(wrong) if wrong else "equal"))
            failures += bool(wrong)
    print("%d files, %d failures" % (count, failures))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
