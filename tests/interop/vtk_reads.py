#!/usr/bin/env python3
"""Files that the program writes, read by VTK (.vtp, .ply, .obj, .stl) and by modules of Python (.csv,
.svg).

usage: vtk_reads.py PROGRAM VENV
       VENV: a virtual environment, into which vtk is installed if it is not there
exit:  0 all agree, 1 some differ, 77 skipped (vtk cannot be installed)
"""

import csv
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

from houdini_geometry import read_ply
from virtual_environment import run_with


def bits(rows):
    """Rows of floats as tuples, with -0 told apart from 0."""
    return [tuple((x, str(x)[0] == "-") for x in map(float, row)) for row in rows]


def vtk_points(data):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    points, found = data.GetPointData(), {"P": vtk_to_numpy(data.GetPoints().GetData())}
    for i in range(points.GetNumberOfArrays()):
        found[points.GetArrayName(i)] = vtk_to_numpy(points.GetArray(i))
    return found


def vtk_triangles(data):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return [tuple(row) for row in vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3).tolist()]


def read(reader, path):
    reader = reader()
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput()


def check(what, good):
    print("%-60s %s" % (what, "equal" if good else "DIFFERENT"))
    return 0 if good else 1


def main():
    program, venv = os.path.abspath(sys.argv[1]), sys.argv[2]
    run_with(venv, {"vtkmodules": "vtk", "numpy": "numpy"})
    from vtkmodules.vtkIOGeometry import vtkOBJReader, vtkSTLReader
    from vtkmodules.vtkIOPLY import vtkPLYReader
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    failures = 0
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)

        def path(name):
            return os.path.join(folder, name)

        run("sample", "drop", "p.ply", "--particles", "3000", "--frames", "1", "--seed", "7")
        for ending in (".vtp", ".csv"):
            run("convert", "p.ply", "p" + ending)
        columns, _ = read_ply(path("p.ply"))
        found = vtk_points(read(vtkXMLPolyDataReader, path("p.vtp")))
        failures += check("p.vtp: positions", bits(found["P"]) == bits(columns["P"]))
        failures += check("p.vtp: velocities", bits(found["velocity"]) == bits(columns["v"]))
        failures += check("p.vtp: ids", [(i,) for i in found["id"].tolist()] == columns["id"])
        with open(path("p.csv"), newline="") as file:
            table = list(csv.DictReader(file))
        import numpy

        rows = numpy.array([[row[c] for c in ("x", "y", "z", "vx", "vy", "vz")] for row in table]).astype("float32")
        failures += check("p.csv: positions", bits(rows[:, :3]) == bits(columns["P"]))
        failures += check("p.csv: velocities", bits(rows[:, 3:]) == bits(columns["v"]))
        failures += check("p.csv: ids", [(int(row["id"]),) for row in table] == columns["id"])

        for ending in (".ply", ".vtp", ".obj", ".stl"):
            run("mesh", "p.ply", "m" + ending, "--radius", "1.5dx")
        columns, faces = read_ply(path("m.ply"))
        mesh = read(vtkXMLPolyDataReader, path("m.vtp"))
        found = vtk_points(mesh)
        failures += check("m.vtp: positions", bits(found["P"]) == bits(columns["P"]))
        failures += check("m.vtp: velocities", bits(found["velocity"]) == bits(columns["v"]))
        failures += check("m.vtp: triangles", vtk_triangles(mesh) == faces)
        normals = numpy.array(found["Normals"])
        failures += check("m.vtp: the active normals are unit vectors", mesh.GetPointData().GetNormals() is not None and
                          bool((abs((normals**2).sum(1) - 1) < 1e-5).all()))
        corners = numpy.array(columns["P"])[numpy.array(faces)]
        flat = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        outward = sum((flat * normals[numpy.array(faces)[:, k]]).sum(1) > 0 for k in range(3))
        failures += check("m.vtp: normals point the way of the triangles", (outward == 3).mean() > 0.99)
        mesh = read(vtkPLYReader, path("m.ply"))
        failures += check("m.ply: positions", bits(vtk_points(mesh)["P"]) == bits(columns["P"]))
        failures += check("m.ply: triangles", vtk_triangles(mesh) == faces)
        mesh = read(vtkOBJReader, path("m.obj"))
        found = vtk_points(mesh)
        failures += check("m.obj: positions", bits(found["P"].astype("float32")) == bits(columns["P"]))
        failures += check("m.obj: triangles", vtk_triangles(mesh) == faces)
        failures += check("m.obj: normals", bool((abs(found["Normals"] - normals) < 1e-6).all()))
        reader = vtkSTLReader()
        reader.MergingOff()
        reader.SetFileName(path("m.stl"))
        reader.Update()
        mesh = reader.GetOutput()
        points = vtk_points(mesh)["P"][numpy.array(vtk_triangles(mesh)).ravel()]
        failures += check("m.stl: corners of triangles", bits(points) == bits(columns["P"][i] for f in faces for i in f))

        with open(path("plane.csv"), "w") as file:
            file.write("x,y,z\n" + "".join("%d,%d,0\n" % (i % 7, i // 7) for i in range(49)))
        run("mesh", "plane.csv", "plane.svg", "--dimension", "2", "--radius", "1", "--spacing", "1")
        drawing = xml.etree.ElementTree.parse(path("plane.svg")).getroot()
        names = {element.tag.rsplit("}")[-1] for element in drawing.iter()}
        failures += check("plane.svg: is XML with the shapes of SVG", {"svg", "path"} <= names)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
