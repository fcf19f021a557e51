#!/usr/bin/env python3
"""The readers of the Blender add-on, without Blender: meshes that the program writes as .ply, .bgeo and .vtp are the
same, and so are .vtp files that VTK writes in other encodings. Damaged files are errors.

usage: blender_readers.py PROGRAM VENV ADDON
       VENV: a virtual environment for NumPy and VTK. ADDON: the folder of the add-on
exit:  0 all is right, 1 something is wrong, 77 skipped (there is no NumPy)
"""

import importlib
import os
import subprocess
import sys
import tempfile
import types

from virtual_environment import missing, run_with

failures = 0


def check(what, good):
    global failures
    failures += not good
    print("%-90s %s" % (what, "right" if good else "WRONG"))


def readers(addon):
    """The modules of the add-on that do not need Blender."""
    package = types.ModuleType("addon")
    package.__path__ = [addon]
    sys.modules["addon"] = package
    return [importlib.import_module("addon." + name) for name in ("geometry", "ply", "houdini", "vtp")]


def main():
    program, venv, addon = map(os.path.abspath, sys.argv[1:4])
    run_with(venv, {"numpy": "numpy"})
    lacks_vtk = run_with(venv, {"numpy": "numpy", "vtkmodules": "vtk"}, may_lack=True)
    geometry, ply, houdini, vtp = readers(addon)
    with tempfile.TemporaryDirectory() as folder:
        examine(program, folder, geometry, {".ply": ply.read_ply, ".bgeo": houdini.read_bgeo,
                                            ".bgeo.gz": houdini.read_bgeo, ".vtp": vtp.read_vtp})
        if lacks_vtk or missing(["vtkmodules"]):
            print("not compared with files of VTK: %s" % lacks_vtk)
        else:
            encodings_of_vtk(folder, vtp.read_vtp)
    return 1 if failures else 0


def same(numpy, found, expected):
    def equal(a, b):
        return (a is None) == (b is None) and (a is None or a.shape == b.shape and bool((a == b).all()))

    def attributes(a, b):
        return a.keys() == b.keys() and all(equal(a[name], b[name]) for name in a)

    return (equal(found.positions, expected.positions) and equal(found.velocities, expected.velocities) and
            equal(found.corners, expected.corners) and equal(found.face_starts, expected.face_starts) and
            attributes(found.point_attributes, expected.point_attributes) and
            attributes(found.face_attributes, expected.face_attributes))


def examine(program, folder, geometry, read):
    import numpy

    def path(name):
        return os.path.join(folder, name)

    def run(*words):
        subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)

    with open(path("p.csv"), "w") as file:
        file.write("x,y,z,vx,vy,vz,heat,Cd.x,Cd.y,Cd.z,kind\n")
        for i in range(1000):
            x, y, z = i % 10, i // 10 % 10, i // 100
            file.write("%g,%g,%g,1,%g,0,%g,0.25,%g,0.5,%d\n" % (x, y, z, y, 300.5 + x, 0.1 * z, i % 3))
    with open(path("empty.csv"), "w") as file:
        file.write("x,y,z\n")
    for ending in read:
        options = ("--spacing", "1", "--attributes", "heat,Cd,kind", "--components")
        run("mesh", "p.csv", "m" + ending, *options)
        run("mesh", "empty.csv", "empty" + ending, "--spacing", "1")
    expected = read[".ply"](path("m.ply"))
    check("the mesh has %d vertices and %d faces" % (len(expected.positions), len(expected.face_starts)),
          len(expected.face_starts) > 1000 and set(expected.point_attributes) == {"heat", "Cd", "kind"} and
          set(expected.face_attributes) == {"component"})
    for ending, reader in read.items():
        check("%s is the same mesh as .ply" % ending, same(numpy, reader(path("m" + ending)), expected))
        nothing = reader(path("empty" + ending))
        check("%s without particles has no points" % ending, len(nothing.positions) + len(nothing.corners) == 0)
        with open(path("m" + ending), "rb") as file:
            data = file.read()
        wrong = []
        for cut in [0, 3, *range(5, len(data) - 40, max(1, len(data) // 60))]:
            with open(path("cut" + ending), "wb") as file:
                file.write(data[:cut])
            try:
                reader(path("cut" + ending))
                wrong.append(cut)
            except geometry.FileError as error:
                if not str(error).startswith(path("cut" + ending)):
                    wrong.append(error)
        check("a %s file that is cut off is an error that names it" % ending, not wrong)
    normals = read[".vtp"](path("m.vtp")).normals
    check(".vtp has normals of length 1", abs((normals**2).sum(axis=1) - 1).max() < 1e-5)
    run("mesh", "p.csv", "old.bhclassic", "--spacing", "1")
    os.rename(path("old.bhclassic"), path("old.bgeo"))
    try:
        read[".bgeo"](path("old.bgeo"))
        check("the older .bgeo is refused", False)
    except geometry.FileError as error:
        check("the older .bgeo is refused: %s" % str(error).split(": ", 1)[1][:40], ".bhclassic" in str(error))


def encodings_of_vtk(folder, read_vtp):
    import numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader, vtkXMLPolyDataWriter

    reader = vtkXMLPolyDataReader()
    reader.SetFileName(os.path.join(folder, "m.vtp"))
    reader.Update()
    expected = read_vtp(os.path.join(folder, "m.vtp"))
    file = os.path.join(folder, "vtk.vtp")
    for mode in ("Ascii", "Binary", "Appended"):
        for compressor in ("None", "ZLib"):
            for raw in (False, True) if mode == "Appended" else (False,):
                for big in (False, True):
                    for bits in (32, 64):
                        writer = vtkXMLPolyDataWriter()
                        writer.SetFileName(file)
                        writer.SetInputData(reader.GetOutput())
                        getattr(writer, "SetDataModeTo" + mode)()
                        getattr(writer, "SetCompressorTypeTo" + compressor)()
                        writer.SetEncodeAppendedData(not raw)
                        writer.SetByteOrder(0 if big else 1)
                        getattr(writer, "SetHeaderTypeToUInt%d" % bits)()
                        writer.SetBlockSize(4096)
                        writer.Write()
                        check("VTK, %s, %s, %s, %s, %d bits" % (mode, compressor, "raw" if raw else "base64",
                                                                "big-endian" if big else "little-endian", bits),
                              same(numpy, read_vtp(file), expected))


if __name__ == "__main__":
    sys.exit(main())
