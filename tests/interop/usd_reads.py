#!/usr/bin/env python3
"""Files of USD that the program writes, read and validated by OpenUSD: sequences frame by frame through the layer that
plays them, and single files. Files that OpenUSD writes, read by the program.

usage: usd_reads.py PROGRAM VENV
       VENV: a virtual environment, into which usd-core is installed if it is not there; TinyUSDZ goes beside it
exit:  0 all agree, 1 some differ, 77 skipped (usd-core cannot be installed)
"""

import json
import os
import struct
import subprocess
import sys
import tempfile

from houdini_geometry import read_ply
from virtual_environment import npm_package, run_with

FRAMES = [-2, 1, 2, 3, 5, 12345]  # 4 is missing; 3 has no particles


def bits(rows):
    """Rows of floats as tuples, with -0 told apart from 0."""
    return [tuple((x, str(x)[0] == "-") for x in map(float, row)) for row in rows]


def check(what, good):
    print("%-70s %s" % (what, "right" if good else "WRONG"))
    return 0 if good else 1


def particles(frame):
    """Positions in two lumps whose number of vertices changes, and a value of every attribute."""
    if frame == 3:
        return []
    count = 6 + frame % 3
    return [(0.1 * x + 0.013 * ((x * y + z) % 3), 0.1 * y + 0.001 * (frame % 50), 0.1 * z + (0.5 if x > 3 else 0))
            for x in range(count) for y in range(4) for z in range(3)]


def write_points(path, frame, rows):
    """A file of USD with particles below a transform that moves them by (1, 0, 0)."""
    from pxr import Gf, Sdf, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(path)
    stage.SetStartTimeCode(frame)
    stage.SetEndTimeCode(frame)
    root = UsdGeom.Xform.Define(stage, "/sim")
    root.AddTranslateOp().Set(Gf.Vec3d(1, 0, 0))
    points = UsdGeom.Points.Define(stage, "/sim/liquid")
    n = len(rows)
    points.CreatePointsAttr().Set([Gf.Vec3f(*row) for row in rows], frame)
    points.CreateVelocitiesAttr().Set([Gf.Vec3f(i, -3, 0.1 * i) for i in range(n)], frame)
    points.CreateIdsAttr().Set([7 * i + 1 for i in range(n)], frame)
    primvars = UsdGeom.PrimvarsAPI(points)
    types = Sdf.ValueTypeNames

    def primvar(name, type_name, value, size=1):
        made = primvars.CreatePrimvar(name, type_name, UsdGeom.Tokens.vertex, size)
        made.Set(value, frame)

    primvar("temperature", types.FloatArray, [300 + 0.37 * i for i in range(n)])
    primvar("flags", types.IntArray, [i % 3 - 1 for i in range(n)])
    primvar("displayColor", types.Color3fArray, [Gf.Vec3f(0.3, i / (n + 1), 1) for i in range(n)])
    primvar("tensor", types.FloatArray, [0.5 * i for i in range(6 * n)], 6)
    primvar("accel", types.Vector3fArray, [Gf.Vec3f(0, -9.81, i) for i in range(n)])
    stage.Save()


def errors_in(stage):
    from pxr import UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    return [error.GetErrorAsString() for error in UsdValidation.ValidationContext(validators).Validate(stage)]


def ply_properties(path):
    """All properties of the vertices of the program's own .ply: name -> numbers."""
    with open(path, "rb") as file:
        lines = []
        while not lines or lines[-1] != "end_header":
            lines.append(file.readline().decode().strip())
        data = file.read()
    words = [line.split() for line in lines[: lines.index("end_header")]]
    elements = [i for i, w in enumerate(words) if w[0] == "element"] + [len(words)]
    count = int(words[elements[0]][2])
    properties = [w[1:] for w in words[elements[0] : elements[1]] if w[0] == "property"]
    row = struct.Struct("<" + "".join({"float": "f", "int": "i", "uint": "I"}[kind] for kind, _ in properties))
    rows = [row.unpack_from(data, i * row.size) for i in range(count)]
    return {name: [r[k] for r in rows] for k, (_, name) in enumerate(properties)}


def columns_of(properties, names):
    """Rows of several properties, as bits() gives them; none for a file that lacks them."""
    return bits(zip(*[properties.get(name, []) for name in names]))


def check_sequence(path):
    """Every frame of m.usda against the .ply of the same job."""
    from pxr import Usd, UsdGeom

    failures = 0
    stage = Usd.Stage.Open(path("m.usda"))
    failures += check("m.usda: is valid", not errors_in(stage))
    failures += check("m.usda: units, axis and time", UsdGeom.GetStageMetersPerUnit(stage) == 0.01 and
                      UsdGeom.GetStageUpAxis(stage) == "Y" and stage.GetTimeCodesPerSecond() == 25 and
                      (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (FRAMES[0], FRAMES[-1]))
    failures += check("m.usda: the default prim has a mesh that no other file refines",
                      [p.GetTypeName() for p in Usd.PrimRange(stage.GetDefaultPrim())] == ["Xform", "Mesh"] and
                      UsdGeom.Mesh(stage.GetPrimAtPath("/geometry/mesh")).GetSubdivisionSchemeAttr().Get() == "none")
    mesh = UsdGeom.Mesh(stage.GetPrimAtPath("/geometry/mesh"))
    primvars = UsdGeom.PrimvarsAPI(mesh)
    for frame in FRAMES:
        name = "m.%04d" % frame
        columns, faces = read_ply(path(name + ".ply"))
        others = ply_properties(path(name + ".ply"))

        def rows(attribute):
            return [tuple(row) for row in attribute.Get(frame) or []]

        points, velocities, normals = rows(mesh.GetPointsAttr()), rows(mesh.GetVelocitiesAttr()), rows(
            mesh.GetNormalsAttr())
        single = Usd.Stage.Open(path(name + ".usda"))
        same = UsdGeom.Mesh(single.GetPrimAtPath("/geometry/mesh"))
        good = [
            bits(points) == bits(columns["P"]),
            bits(velocities) == bits(columns["v"]),
            list(mesh.GetFaceVertexIndicesAttr().Get(frame)) == [corner for face in faces for corner in face],
            list(mesh.GetFaceVertexCountsAttr().Get(frame)) == [3] * len(faces),
            len(normals) == len(points) and all(abs(sum(x * x for x in n) - 1) < 1e-5 for n in normals),
            bits(rows(mesh.GetAccelerationsAttr())) == columns_of(others, ["accel_x", "accel_y", "accel_z"]),
            bits(rows(same.GetPointsAttr())) == bits(points),
            not errors_in(single),
        ]
        if frame != 3:
            low, high = mesh.GetExtentAttr().Get(frame)
            good.append(all(low[k] == min(p[k] for p in points) and high[k] == max(p[k] for p in points)
                            for k in range(3)))
            blurred = mesh.ComputePointsAtTime(frame + 0.25, frame)  # what renderers do for a shutter
            accelerations = rows(mesh.GetAccelerationsAttr())
            t = 0.25 / 25
            good.append(all(abs(b[k] - p[k] - v[k] * t - a[k] * t * t / 2) < 1e-5 for b, p, v, a in
                            zip(blurred, points, velocities, accelerations) for k in range(3)))
            temperature = primvars.GetPrimvar("temperature").Get(frame)
            tensor = primvars.GetPrimvar("tensor").Get(frame)
            good.append(bits(zip(temperature)) == columns_of(others, ["temperature"]))
            good.append(list(primvars.GetPrimvar("flags").Get(frame)) == others["flags"])
            good.append(bits(zip(*[tensor[k::6] for k in range(6)])) ==
                        columns_of(others, ["tensor_%d" % k for k in range(6)]) and
                        primvars.GetPrimvar("tensor").GetElementSize() == 6)
            good.append(bits(primvars.GetPrimvar("displayColor").Get(frame)) ==
                        columns_of(others, ["Cd_x", "Cd_y", "Cd_z"]))
            good.append(len(primvars.GetPrimvar("component").Get(frame)) == len(faces) and
                        primvars.GetPrimvar("component").GetInterpolation() == "uniform")
        failures += check("frame %d: %d points, %d triangles: %s" %
                          (frame, len(points), len(faces), "".join("01"[bool(g)] for g in good)), all(good))
    between = [(1.5, 1), (2.75, 2), (4, 3), (4.5, 3), (100, 5)]
    failures += check("m.usda: between frames the earlier one holds",
                      all(len(mesh.GetPointsAttr().Get(t)) == len(mesh.GetPointsAttr().Get(f)) and
                          mesh.GetFaceVertexIndicesAttr().Get(t) == mesh.GetFaceVertexIndicesAttr().Get(f) and
                          all(max(map(abs, p - q)) < 1e-5 for p, q in
                              zip(mesh.GetPointsAttr().Get(t), mesh.GetPointsAttr().Get(f))) for t, f in between))
    stage.Flatten().Export(path("flat.usdc"))
    flat_stage = Usd.Stage.Open(path("flat.usdc"))
    flat = UsdGeom.Mesh(flat_stage.GetPrimAtPath("/geometry/mesh"))
    failures += check("flat.usdc: the flattened sequence has the same points at every frame",
                      all(flat.GetPointsAttr().Get(f) == mesh.GetPointsAttr().Get(f) for f in FRAMES))
    return failures


def check_particles(run, path):
    """Particles and spheres as UsdGeomPoints, and reading them back."""
    from pxr import Gf, Usd, UsdGeom

    failures = 0
    run("sample", "dambreak", "p.ply", "--particles", "3000", "--frames", "6")
    run("convert", "p.ply", "p.usda")
    columns, _ = read_ply(path("p.ply"))
    stage = Usd.Stage.Open(path("p.usda"))
    points = UsdGeom.Points(stage.GetPrimAtPath("/geometry/points"))
    failures += check("p.usda: is valid", not errors_in(stage))
    failures += check("p.usda: positions, velocities and ids",
                      bits(points.GetPointsAttr().Get(6)) == bits(columns["P"]) and
                      bits(points.GetVelocitiesAttr().Get(6)) == bits(columns["v"]) and
                      [(i,) for i in points.GetIdsAttr().Get(6)] == columns["id"])
    stage.Export(path("q.usda"))
    run("convert", "q.usda", "q.ply")
    with open(path("p.ply"), "rb") as one, open(path("q.ply"), "rb") as other:
        failures += check("q.usda: what OpenUSD writes again gives the same particles", one.read() == other.read())
    with open(path("far.csv"), "w") as file:
        file.write("x,y,z,vx,vy,vz,id\n0,0,0,1,2,3,4\n9,0,0,4,5,6,7\n")
    run("mesh", "far.csv", "far.0001.usda", "--radius", "0.5", "--spacing", "0.3", "--droplets", "points",
        "--output-up-axis", "z")
    stage = Usd.Stage.Open(path("far.0001.spheres.usda"))
    spheres = UsdGeom.Points(stage.GetPrimAtPath("/geometry/points"))
    failures += check("far.spheres.usda: two spheres with widths, z up",
                      not errors_in(stage) and UsdGeom.GetStageUpAxis(stage) == "Z" and
                      sorted(map(tuple, spheres.GetVelocitiesAttr().Get(1))) == [(1, -3, 2), (4, -6, 5)] and
                      len(spheres.GetWidthsAttr().Get(1)) == 2 and min(spheres.GetWidthsAttr().Get(1)) > 0.1)
    stage = Usd.Stage.CreateNew(path("two.usda"))
    for name, x in (("water", 1), ("foam", 2)):
        made = UsdGeom.Points.Define(stage, "/sim/" + name)
        made.CreatePointsAttr().Set([Gf.Vec3f(x, 0, 0)] * 2)
        made.AddScaleOp().Set(Gf.Vec3f(3, 3, 3))
    stage.Save()
    run("convert", "two.usda", "two.csv")
    with open(path("two.csv")) as file:
        failures += check("two.usda: both prims are read",
                          file.read().split() == ["x,y,z", *["3.0,0.0,0.0"] * 2, *["6.0,0.0,0.0"] * 2])
    said = subprocess.run([sys.argv[1], "mesh", "two.usda", "two.ply", "--radius", "1", "--spacing", "0.6"],
                          cwd=path("."), capture_output=True, text=True).stderr
    failures += check("two.usda: meshing them together is named", "2 prims are meshed together" in said)
    said = subprocess.run([sys.argv[1], "mesh", "two.usda", "one.ply", "--radius", "1", "--spacing", "0.6", "--grid",
                           "foam", "--json"], cwd=path("."), capture_output=True, text=True).stdout
    failures += check("two.usda: --grid chooses a prim", '"particles":2,' in said)
    return failures


def check_tinyusdz(path, folder):
    """A mesh as TinyUSDZ reads it, whose parser is not that of OpenUSD. Left out without node and npm."""
    package, reason = npm_package(folder, "tinyusdz")
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tinyusdz_points.mjs")
    try:
        if package is None:
            raise OSError(reason)
        read = subprocess.run(["node", script, package, path("m.0002.usda")], capture_output=True, text=True,
                              timeout=120)
    except OSError as error:
        print("m.0002.usda: TinyUSDZ is left out: %s" % error)
        return 0
    if read.returncode != 0:
        return check("m.0002.usda: TinyUSDZ reads it: " + read.stderr[-200:], False)
    mesh, (columns, faces) = json.loads(read.stdout), read_ply(path("m.0002.ply"))
    return check("m.0002.usda: TinyUSDZ reads the same points and triangles",
                 bits(zip(*[mesh["points"][k::3] for k in range(3)])) == bits(columns["P"]) and
                 mesh["faceVertexIndices"] == [corner for face in faces for corner in face] and
                 len(mesh["normals"]) == len(mesh["points"]))


def main():
    sys.argv[1] = program = os.path.abspath(sys.argv[1])
    run_with(sys.argv[2], {"pxr": "usd-core"})
    failures = 0
    with tempfile.TemporaryDirectory() as folder:

        def run(*words):
            subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)

        def path(name):
            return os.path.join(folder, name)

        for frame in FRAMES:
            write_points(path("s.%04d.usda" % frame), frame, particles(frame))
        options = ["--radius", "0.15", "--spacing", "0.1", "--components", "--attributes",
                   "temperature,flags,Cd,tensor"]
        for ending in (".ply", ".usda"):
            run("mesh", "s.####.usda", "m.####" + ending, "--output-fps", "25", "--meters-per-unit", "0.01", *options)
        failures += check_sequence(path)
        failures += check_particles(run, path)
        failures += check_tinyusdz(path, os.path.join(os.path.dirname(os.path.abspath(sys.argv[2])), "node"))
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
