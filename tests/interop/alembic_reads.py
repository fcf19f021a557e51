#!/usr/bin/env python3
"""Files of Alembic that the program writes, read by Alembic's own library, and files of that library, read by the
program.

usage: alembic_reads.py PROGRAM VENV
       VENV: a virtual environment, into which alembic3d is installed if it is not there
exit:  0 all agree, 1 some differ, 77 skipped (alembic3d cannot be installed)
"""

import json
import os
import struct
import subprocess
import sys
import tempfile

from houdini_geometry import read_ply
from virtual_environment import run_with


def bits(rows):
    """Rows of floats as tuples, with -0 told apart from 0."""
    return [tuple((x, str(x)[0] == "-") for x in map(float, row)) for row in rows]


def numbers_of(path, name):
    """A property of the vertices of the program's own .ply."""
    with open(path, "rb") as file:
        lines = []
        while not lines or lines[-1] != "end_header":
            lines.append(file.readline().decode().strip())
        data = file.read()
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    before_faces = lines[: [line.startswith("element face") for line in lines + ["element face"]].index(True)]
    properties = [line.split()[1:] for line in before_faces if line.startswith("property")]
    row = struct.Struct("<" + "".join({"float": "f", "int": "i", "uint": "I"}[kind] for kind, _ in properties))
    column = [n for _, n in properties].index(name)
    return [row.unpack_from(data, i * row.size)[column] for i in range(count)]


def check(what, good):
    print("%-70s %s" % (what, "right" if good else "WRONG"))
    return 0 if good else 1


def vectors(rows):
    import imath

    array = imath.V3fArray(len(rows))
    for i, row in enumerate(rows):
        array[i] = imath.V3f(*row)
    return array


def integers(numbers):
    import imath

    array = imath.IntArray(len(numbers))
    for i, number in enumerate(numbers):
        array[i] = number
    return array


def write_foreign_mesh(path, samples=1, extra_object=False):
    """A cube of quads below a transform that moves it by (10, 0, 0) and doubles it."""
    import imath
    from alembic3d import Abc, AbcCoreAbstract, AbcGeom

    archive = Abc.OArchive(path)
    times = archive.addTimeSampling(AbcCoreAbstract.TimeSampling(1 / 24, 1))
    xform = AbcGeom.OXform(archive.getTop(), "move", times)
    sample = AbcGeom.XformSample()
    sample.setTranslation(imath.V3d(10, 0, 0))
    sample.setScale(imath.V3d(2, 2, 2))
    xform.getSchema().set(sample)
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    # Clockwise seen from outside, as Alembic's faces are.
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh = AbcGeom.OPolyMesh(xform, "cube", times)
    schema = mesh.getSchema()
    for i in range(samples):
        points = vectors([(x, y + i, z) for x, y, z in corners])
        sample = AbcGeom.OPolyMeshSchemaSample(points, integers([c for q in quads for c in q]), integers([4] * 6))
        sample.setVelocities(vectors([(1, 2, 3)] * 8))
        schema.set(sample)
    heat = AbcGeom.OFloatGeomParam(schema.getArbGeomParams(), "heat", False, AbcGeom.GeometryScope.kVertexScope, 1,
                                   times)
    values = imath.FloatArray(8)
    for i in range(8):
        values[i] = i / 4
    heat.set(AbcGeom.OFloatGeomParamSample(values, AbcGeom.GeometryScope.kVertexScope))
    if extra_object:
        other = AbcGeom.OPolyMesh(archive.getTop(), "other", times)
        other.getSchema().set(AbcGeom.OPolyMeshSchemaSample(vectors(corners), integers([0, 1, 2]), integers([3])))


def write_foreign_points(path, n):
    import imath
    from alembic3d import Abc, AbcCoreAbstract, AbcGeom

    archive = Abc.OArchive(path)
    times = archive.addTimeSampling(AbcCoreAbstract.TimeSampling(1 / 24, 1))
    points = AbcGeom.OPoints(archive.getTop(), "drops", times)
    widths = imath.FloatArray(n)
    for i in range(n):
        widths[i] = 0.25
    rows = vectors([(i / 8, i % 7, -i) for i in range(n)])
    points.getSchema().set(AbcGeom.OPointsSchemaSample(
        rows, integers(range(100, 100 + n)), rows,
        AbcGeom.OFloatGeomParamSample(widths, AbcGeom.GeometryScope.kVertexScope)))


def main():
    program, venv = os.path.abspath(sys.argv[1]), sys.argv[2]
    run_with(venv, {"alembic3d": "alembic3d"})
    from alembic3d import Abc, AbcGeom

    failures = 0
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            return subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE).stdout

        def error_of(*words):
            ended = subprocess.run([program, *words], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
            return ended.stderr.decode() if ended.returncode else ""

        def path(name):
            return os.path.join(folder, name)

        run("sample", "drop", "p.####.ply", "--particles", "3000", "--frames", "9", "--seed", "7")
        run("convert", "p.####.ply", "p.####.abc")
        columns, _ = read_ply(path("p.0009.ply"))
        archive = Abc.IArchive(path("p.0009.abc"))
        points = AbcGeom.IPoints(archive.getTop(), "points").getSchema()
        sample = points.getValue()
        failures += check("points: positions", bits(sample.getPositions()) == bits(columns["P"]))
        failures += check("points: velocities", bits(sample.getVelocities()) == bits(columns["v"]))
        failures += check("points: ids", [(i,) for i in sample.getIds()] == columns["id"])
        failures += check("points: time", points.getTimeSampling().getSampleTime(0) == 9 / 24)

        for ending in (".ply", ".abc"):
            run("mesh", "p.####.ply", "m.####" + ending, "--components", "--output-fps", "30", "-j", "1")
        columns, faces = read_ply(path("m.0009.ply"))
        archive = Abc.IArchive(path("m.0009.abc"))
        mesh = AbcGeom.IPolyMesh(archive.getTop(), "mesh").getSchema()
        sample = mesh.getValue()
        failures += check("mesh: positions", bits(sample.getPositions()) == bits(columns["P"]))
        failures += check("mesh: velocities", bits(sample.getVelocities()) == bits(columns["v"]))
        failures += check("mesh: some velocities are not 0", any(x for row in sample.getVelocities() for x in row))
        failures += check("mesh: triangles", set(sample.getFaceCounts()) == {3} and
                          list(sample.getFaceIndices()) == [i for f in faces for i in (f[0], f[2], f[1])])
        failures += check("mesh: one sample, at the time of the frame",
                          mesh.getNumSamples() == 1 and mesh.getTimeSampling().getSampleTime(0) == 9 * (1 / 30))
        bounds = sample.getSelfBounds()
        low, high = ([f(row[k] for row in columns["P"]) for k in range(3)] for f in (min, max))
        failures += check("mesh: bounds", list(bounds.min()) == low and list(bounds.max()) == high)
        parameter = mesh.getNormalsParam()
        normals = [tuple(n) for n in parameter.getValueProperty().getValue()]
        failures += check("mesh: a unit normal for each vertex",
                          parameter.getScope() == AbcGeom.GeometryScope.kVertexScope and len(normals) == len(columns["P"])
                          and all(abs(sum(x * x for x in n) - 1) < 1e-5 for n in normals))
        outward = 0
        for f in faces:
            a, b, c = (columns["P"][i] for i in f)
            u, v = ([q[k] - a[k] for k in range(3)] for q in (b, c))
            normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            outward += all(sum(x * y for x, y in zip(normal, normals[i])) > 0 for i in f)
        failures += check("mesh: normals point outward", outward > 0.99 * len(faces))
        component = AbcGeom.IInt32GeomParam(mesh.getArbGeomParams(), "component")
        values = list(component.getValueProperty().getValue())
        failures += check("mesh: a component for each face",
                          component.getScope() == AbcGeom.GeometryScope.kUniformScope and len(values) == len(faces))
        first = open(path("m.0009.abc"), "rb").read()
        run("mesh", "p.####.ply", "m.####.abc", "--components", "--output-fps", "30", "-j", "4", "--overwrite")
        failures += check("mesh: the same bytes again", open(path("m.0009.abc"), "rb").read() == first)
        run("convert", "m.0009.abc", "back.ply")
        again, faces_again = read_ply(path("back.ply"))
        failures += check("mesh: read back by the program",
                          all(bits(again[c]) == bits(columns[c]) for c in ("P", "v")) and faces_again == faces)
        with open(path("empty.csv"), "w") as file:
            file.write("x,y,z\n")
        run("mesh", "empty.csv", "empty.abc", "--radius", "0.1")
        empty = AbcGeom.IPolyMesh(Abc.IArchive(path("empty.abc")).getTop(), "mesh").getSchema().getValue()
        failures += check("an empty frame", len(empty.getPositions()) == 0 and len(empty.getFaceCounts()) == 0)

        write_foreign_mesh(path("cube.abc"))
        info = json.loads(run("info", "--json", "cube.abc"))
        failures += check("cube of the library: 8 points, 12 triangles, moved and doubled",
                          (info["points"], info["triangles"], info["lower"], info["upper"]) ==
                          (8, 12, [10, 0, 0], [12, 2, 2]))
        run("check", "cube.abc")
        run("convert", "cube.abc", "cube.ply")
        columns, faces = read_ply(path("cube.ply"))
        volume = 0
        for f in faces:
            a, b, c = (columns["P"][i] for i in f)
            volume += sum(a[i] * (b[j] * c[k] - b[k] * c[j]) for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1))) / 6
        failures += check("cube of the library: faces outward", abs(volume - 8) < 1e-4)
        failures += check("cube of the library: velocities turn into the world", columns["v"] == [(2, 4, 6)] * 8)
        failures += check("cube of the library: attribute", numbers_of(path("cube.ply"), "heat") == [i / 4 for i in range(8)])
        write_foreign_mesh(path("cubes.abc"), samples=5)
        ended = subprocess.run([program, "convert", "cubes.abc", "cubes.ply"], cwd=folder, capture_output=True, text=True)
        failures += check("of several samples one file gets the first, with a warning",
                          ended.returncode == 0 and "only frame 24 of 24-28 is read" in ended.stderr and
                          read_ply(path("cubes.ply"))[0]["P"] == columns["P"])
        run("convert", "cubes.abc", "cubes.####.ply")
        failures += check("of several samples a sequence gets all",
                          all(read_ply(path("cubes.00%d.ply" % (24 + i)))[0]["P"] ==
                              [(x, y + 2 * i, z) for x, y, z in columns["P"]] for i in range(5)))
        write_foreign_mesh(path("two.abc"), extra_object=True)
        failures += check("several meshes are an error",
                          "'/move/cube', '/other'" in error_of("convert", "two.abc", "c.ply"))
        run("convert", "two.abc", "other.ply", "--grid", "other")
        failures += check("--grid chooses a mesh", len(read_ply(path("other.ply"))[1]) == 1)
        write_foreign_points(path("drops.abc"), 20)
        run("convert", "drops.abc", "drops.ply")
        columns, _ = read_ply(path("drops.ply"))
        failures += check("points of the library",
                          columns["P"] == [(i / 8, i % 7, -i) for i in range(20)] and columns["v"] == columns["P"] and
                          columns["id"] == [(100 + i,) for i in range(20)])
        failures += check("points of the library: widths become a radius",
                          numbers_of(path("drops.ply"), "pscale") == [0.125] * 20)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
