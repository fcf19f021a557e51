#!/usr/bin/env python3
"""Sequences that the program writes, in Blender: .ply, .bgeo and .vtp through the add-on of pipelines/blender, .usda
and .abc through Blender's own importers. Cycles renders a moving drop; the length of its motion blur is measured in
the picture.

usage: blender_addon.py PROGRAM VENV ADDON
       VENV: a virtual environment whose Python may have the module bpy, Blender as a module. It is not installed by
       itself because it is a download of 350 MB.
       ADDON: the folder of the add-on
exit:  0 all is right, 1 something is wrong, 77 skipped (there is no module bpy)
"""

import math
import os
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile

from houdini_geometry import read_ply
from virtual_environment import SKIPPED, missing

FPS = 24
STEP = 0.4  # world units that the drop moves from frame to frame, along x
WIDTH, HEIGHT, PIXELS_PER_UNIT = 160, 120, 40
failures = 0


def check(what, good):
    global failures
    failures += not good
    print("%-90s %s" % (what, "right" if good else "WRONG"))


def write_particles(path, frame, velocity=True):
    """A drop whose centre is at STEP * frame. The noise of each frame makes another number of vertices."""
    noise = random.Random(frame)
    with open(path, "w") as file:
        file.write("x,y,z,vx,vy,vz,heat,Cd_x,Cd_y,Cd_z\n" if velocity else "x,y,z\n")
        for i in range(21**3):
            x, y, z = (0.1 * (c - 10) + noise.uniform(-0.02, 0.02) for c in (i % 21, i // 21 % 21, i // 441))
            if x * x + y * y + z * z < 1:
                row = [x + STEP * frame, y, z]
                row += [STEP * FPS, 0, 0, 300 + 10 * x, 0.5 + 0.5 * x, 0.25, 0.5 + 0.5 * z] if velocity else []
                file.write(",".join("%.7g" % number for number in row) + "\n")


def write_ply(path, encoding):
    """Two triangles and a quadrilateral, or without any polygon two points, with attributes of several types."""
    points = [(0.5, 0, 0), (1, 0, 0), (1, 1, -2), (0, 1, 0), (0.5, 2, 0.25)]
    header = ["ply", "format %s 1.0" % encoding, "comment made by hand", "element vertex 5"]
    header += ["property float " + name for name in "x y z vx vy vz nx ny nz heat Cd_x Cd_y Cd_z".split()]
    header += ["property double uv_x", "property double uv_y", "property uchar kind", "property char sign"]
    header += ["property int id", "property float material_index"]
    header += ["element face 3", "property list uchar int vertex_indices", "property int component"]
    faces = [[0, 1, 2, 3], [3, 2, 4], [0, 3, 4]]
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(encoding)
    with open(path, "wb") as file:
        file.write(("\n".join(header) + "\nend_header\n").encode())
        for i, (x, y, z) in enumerate(points):
            row = [x, y, z, 1, 2 + i, 3, 0, 0, 1, 300.5 + i, 0.25, 0.5, 0.125 * i]
            row += [0.1 * i, 1, 200 + i, -i, 2000000000 + i, 7]
            if order:
                file.write(struct.pack(order + "13f2dBbif", *row))
            else:
                file.write((" ".join("%.10g" % number for number in row) + "\n").encode())
        for i, face in enumerate(faces):
            row = [len(face), *face, 10 * i]
            if order:
                file.write(struct.pack("%sB%di" % (order, len(row) - 1), *row))
            else:
                file.write((" ".join(map(str, row)) + "\n").encode())
    return points, faces


def main():
    program, venv, addon = map(os.path.abspath, sys.argv[1:4])
    python = os.path.join(venv, "bin", "python")
    if missing(["bpy"]):
        if os.path.exists(python) and os.path.realpath(sys.prefix) != os.path.realpath(venv):
            sys.stdout.flush()
            os.execv(python, [python, *sys.argv])
        print("skipped: there is no module bpy, a download of 350 MB. Run python3.11 -m venv %s; "
              "%s -m pip install bpy==5.0.1" % (venv, python))
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        os.environ["BLENDER_USER_RESOURCES"] = os.path.join(folder, "blender")  # not the settings of the user
        examine(program, addon, folder)
    return 1 if failures else 0


def examine(program, addon, folder):
    import tomllib

    import bpy
    import numpy

    def path(*names):
        return os.path.join(folder, *names)

    def run(*words):
        subprocess.run([program, *words], cwd=folder, check=True, stderr=subprocess.DEVNULL)

    def numbers(data, name, size, kind="float32"):
        found = numpy.empty(len(data) * size, kind)
        data.foreach_get(name, found)
        return found.reshape(-1, size) if size > 1 else found

    def rotated(vectors):
        return numpy.array([(x, -z, y) for x, y, z in vectors], "float32").reshape(-1, 3)

    def refused(operator, *texts, **arguments):
        try:
            operator(**arguments)
        except RuntimeError as error:
            return all(text in str(error) for text in texts)
        return False

    def show(frame, subframe=0.0):
        bpy.context.scene.frame_set(frame, subframe=subframe)

    def imported(file, **options):
        result = bpy.ops.import_mesh.betamesh_sequence(filepath=file, **options)
        assert result == {"FINISHED"}, result
        return bpy.context.object

    print("Blender %s" % bpy.app.version_string)
    with open(os.path.join(addon, "blender_manifest.toml"), "rb") as file:
        version = tomllib.load(file)["version"]
    said = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout
    check("the add-on has the version of the program, %s" % version, version in said.split())
    for frame in range(1, 7):
        write_particles(path("p.%04d.csv" % frame), frame)
    write_particles(path("rest.0003.csv"), 3, velocity=False)
    os.mkdir(path("shot"))
    options = ("--spacing", "0.1", "--attributes", "heat,Cd")
    run("mesh", "p.####.csv", "shot/drop.####.ply", *options)
    run("mesh", "p.####.csv", "shot/z.####.ply", "--output-up-axis", "z", *options)
    run("mesh", "rest.####.csv", "shot/rest.####.ply", "--spacing", "0.1")
    expected = {frame: read_ply(path("shot", "drop.%04d.ply" % frame)) for frame in (1, 2, 3, 5, 6)}
    os.remove(path("shot", "drop.0004.ply"))

    bpy.ops.wm.read_homefile(use_empty=True)
    handlers_before = [len(bpy.app.handlers.frame_change_pre), len(bpy.app.handlers.load_post)]
    package = path("betamesh_sequence.zip")
    with zipfile.ZipFile(package, "w") as file:
        for name in sorted(n for n in os.listdir(addon) if n.endswith((".py", ".toml"))):
            file.write(os.path.join(addon, name), name)
    result = bpy.ops.extensions.package_install_files(filepath=package, repo="user_default", enable_on_install=True)
    check("the add-on is installed as an extension",
          result == {"FINISHED"} and hasattr(bpy.types.Mesh, "betamesh_sequence"))
    scene = bpy.context.scene
    scene.render.fps = FPS

    def shows(item, frame, rest=False):
        mesh, (columns, faces) = item.data, expected[frame]
        return (len(mesh.vertices) == len(columns["P"]) and
                (numbers(mesh.vertices, "co", 3) == rotated(columns["P"])).all() and
                (numbers(mesh.attributes["velocity"].data, "vector", 3) == rotated(columns["v"]) * (not rest)).all() and
                (numbers(mesh.loops, "vertex_index", 1, "int32") == numpy.array(faces).ravel()).all())

    def empty(item):
        return len(item.data.vertices) == 0 and len(item.data.polygons) == 0

    # Frames
    drop = imported(path("shot", "drop.0002.ply"))
    material = bpy.data.materials.new("liquid")
    drop.data.materials.append(material)
    for frame in (1, 5, 2, 6):
        show(frame)
        check("frame %d: %d vertices, positions, velocities, triangles" % (frame, len(expected[frame][0]["P"])),
              shows(drop, frame))
    check("faces are smooth, the mesh is valid, the material stays",
          all(numbers(drop.data.polygons, "use_smooth", 1, "bool")) and not drop.data.validate() and
          drop.material_slots[0].material == material)
    mesh = drop.data
    velocity = mesh.attributes["velocity"]
    check("velocity is a vector of points", (velocity.data_type, velocity.domain) == ("FLOAT_VECTOR", "POINT"))
    kinds = {name: (mesh.attributes[name].data_type, mesh.attributes[name].domain) for name in ("heat", "Cd")}
    check("attributes keep their types, Cd is a colour",
          kinds == {"heat": ("FLOAT", "POINT"), "Cd": ("FLOAT_COLOR", "POINT")} and
          mesh.color_attributes.active_color.name == "Cd")
    for ending in (".bgeo", ".vtp"):
        run("mesh", "p.####.csv", "shot/drop.####" + ending, *options)
        same = imported(path("shot", "drop.0001" + ending))
        show(5)
        check("%s: frame 5, the same mesh as .ply" % ending,
              shows(same, 5) and {"heat", "Cd"} <= set(same.data.attributes.keys()))
        bpy.data.meshes.remove(same.data)
    for frame in (0, 4, 7):
        show(frame)
        check("frame %d has no file: no mesh, no error" % frame, empty(drop) and not mesh.betamesh_sequence.error)
    drop.data.betamesh_sequence.hold = True
    show(0)
    check("frame 0 with Hold Ends: the first frame, at rest", shows(drop, 1, rest=True))
    show(100)
    check("frame 100 with Hold Ends: the last frame, at rest", shows(drop, 6, rest=True))
    show(4)
    check("frame 4 with Hold Ends: no mesh", empty(drop))
    show(6, 0.25)
    check("frame 6.25 with Hold Ends: still moves, for shutters that open on the last frame",
          abs(numbers(mesh.vertices, "co", 3) - rotated(expected[6][0]["P"]) - [0.25 * STEP, 0, 0]).max() < 1e-6 and
          (numbers(mesh.attributes["velocity"].data, "vector", 3) == rotated(expected[6][0]["v"])).all())
    show(2, 0.25)
    between = numbers(mesh.vertices, "co", 3) - rotated(expected[2][0]["P"])
    check("frame 2.25: displaced along the velocities",
          abs(between - [0.25 * STEP, 0, 0]).max() < 1e-6)
    show(1, 0.75)
    check("frame 1.75: frame 2, displaced backwards", len(mesh.vertices) == len(expected[2][0]["P"]) and
          abs(numbers(mesh.vertices, "co", 3) - rotated(expected[2][0]["P"]) - [-0.25 * STEP, 0, 0]).max() < 1e-6)

    # Several sequences, saved, moved and opened again
    show(3)
    other = imported(path("shot", "z.0001.ply"), up_axis="Z", frame_offset=100)
    twin = bpy.data.objects.new("twin", drop.data)
    bpy.context.collection.objects.link(twin)
    check("frame 3 is outside the sequence with offset 100", empty(other) and shows(drop, 3) and shows(twin, 3))
    show(105)
    check("frame 105 with offset 100: frame 5, z up in the file", shows(other, 5) and shows(drop, 6, rest=True))
    check("rendering locks the interface", scene.render.use_lock_interface)
    show(2)
    bpy.ops.wm.save_as_mainfile(filepath=path("shot", "shot.blend"))
    for item in (drop, other):
        item.data.betamesh_sequence.pattern = bpy.path.relpath(item.data.betamesh_sequence.pattern)
    bpy.ops.wm.save_mainfile()
    os.rename(path("shot"), path("moved"))
    shutil.copy(path("moved", "drop.0005.ply"), path("moved", "drop.0002.ply"))
    os.utime(path("moved", "drop.0002.ply"), ns=(1, 1))
    bpy.ops.wm.open_mainfile(filepath=path("moved", "shot.blend"))
    drop, other = bpy.data.objects["drop"], bpy.data.objects["z"]
    check("a saved file shows the meshes that are on disk when it is opened", shows(drop, 5))
    show(6)
    check("the other frames, in another folder than when it was saved", shows(drop, 6) and empty(other))
    show(101)
    check("the settings of each object", shows(other, 1) and shows(drop, 6, rest=True))
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(path("moved", "shot.blend"), link=True) as (_, into):
        into.objects = ["drop"]
    linked = into.objects[0]
    show(3)
    check("a linked mesh keeps its frame, until it is made local", shows(linked, 2))
    local = linked.data = linked.data.make_local() if linked.make_local() else None
    local.betamesh_sequence.pattern = path("moved", "drop.####.ply")
    check("then it follows the frames", shows(linked, 3))
    local.betamesh_sequence.pattern = path("nowhere", "drop.####.ply")
    check("a folder that does not exist: no mesh, and an error in the panel",
          empty(linked) and "nowhere: there is no such folder" in local.betamesh_sequence.error)

    # Encodings and errors
    bpy.ops.wm.read_homefile(use_empty=True)
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        points, faces = write_ply(path("%s.-007.ply" % encoding), encoding)
        show(-7)
        mesh = imported(path("%s.-007.ply" % encoding)).data
        attributes = mesh.attributes
        check(encoding + ": positions, faces, frame -7",
              (numbers(mesh.vertices, "co", 3) == rotated(points)).all() and
              [list(polygon.vertices) for polygon in mesh.polygons] == faces and
              mesh.betamesh_sequence.pattern.endswith("%s.###.ply" % encoding))
        check(encoding + ": attributes", attributes["velocity"].data[3].vector[:] == (1, -3, 5) and
              attributes["heat"].data[2].value == 302.5 and
              attributes["Cd"].data[2].color[:] == (0.25, 0.5, 0.25, 1) and
              abs(attributes["uv"].data[2].vector[0] - 0.2) < 1e-7 and attributes["kind"].data[4].value == 204 and
              attributes["sign"].data_type == "INT8" and attributes["sign"].data[4].value == -4 and
              attributes["id"].data[4].value == 2000000004 and attributes["material_index_"].data[0].value == 7 and
              [attributes["component"].data[i].value for i in range(3)] == [0, 10, 20])
        check(encoding + ": normals", all((corner.vector - mesh.vertices[0].co.__class__((0, -1, 0))).length < 1e-3
                                          for corner in mesh.corner_normals))
    whole = open(path("binary_big_endian.-007.ply"), "rb").read()
    damaged = {"short.1.ply": (whole[:-9], "ends inside the element 'face'"), "empty.1.ply": (b"", "not a .ply file"),
               "index.1.ply": (whole[:-8] + struct.pack(">i", 99) + whole[-4:], "refers to the vertex 99; there are 5"),
               "word.1.ply": (whole.replace(b"property double uv_x", b"property string uv_x"), "property string uv_x")}
    for name, (data, reason) in damaged.items():
        with open(path(name), "wb") as file:
            file.write(data)
        check("%s is refused, with its name and the reason" % name,
              refused(bpy.ops.import_mesh.betamesh_sequence, path(name), reason, filepath=path(name)))
    with open(path("nonumber.ply"), "wb") as file:
        file.write(whole)
    for name in ("unpadded.8", "unpadded.11", "padded.08", "padded.11", "padded.8", "hyphen-08", "hyphen-11"):
        shutil.copy(path("nonumber.ply"), path(name + ".ply"))
    for name, found in {"unpadded.11": "unpadded.#", "padded.11": "padded.##", "hyphen-11": "hyphen-##"}.items():
        settings = imported(path(name + ".ply")).data.betamesh_sequence
        check("%s.ply is of the sequence %s.ply, frames 8 to 11" % (name, found),
              settings.pattern == path(found + ".ply") and settings.first_frame == 8 and settings.last_frame == 11)
    check("a name without a frame number is refused",
          refused(bpy.ops.import_mesh.betamesh_sequence, "nonumber.ply: the name has no frame number",
                  filepath=path("nonumber.ply")))
    os.rename(path("short.1.ply"), path("bad.3.ply"))
    shutil.copy(path("moved", "drop.0001.ply"), path("bad.1.ply"))
    item = imported(path("bad.1.ply"))
    show(3)
    check("a damaged frame: no mesh, and the error in the panel",
          empty(item) and "bad.3.ply: the file ends inside" in item.data.betamesh_sequence.error)
    show(1)
    check("the frame after it", shows(item, 1) and not item.data.betamesh_sequence.error)
    shutil.copy(path("moved", "drop.0006.ply"), path("bad.6.ply"))
    show(6)
    before = empty(item)
    bpy.ops.mesh.betamesh_sequence_reload()
    check("Reload finds frames that were written after the import", before and shows(item, 6))

    # Pictures: white on nothing, seen along Blender's y
    def prepare(item):
        scene = bpy.context.scene
        item.data.materials.append(bpy.data.materials.new("white"))
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        scene.camera = camera
        camera.data.type, camera.data.ortho_scale = "ORTHO", WIDTH / PIXELS_PER_UNIT
        camera.location, camera.rotation_euler = (3 * STEP, -10, 0), (math.pi / 2, 0, 0)
        render, cycles = scene.render, scene.cycles
        render.engine, render.fps = "CYCLES", FPS
        render.threads_mode, render.threads = "FIXED", 1
        render.resolution_x, render.resolution_y, render.film_transparent = WIDTH, HEIGHT, True
        cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", 64, False, False
        settings = render.image_settings
        settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
        return scene

    def moments(file):
        """Mean and variance of the horizontal position of what covers the picture, in pixels."""
        image = bpy.data.images.load(file)
        alpha = numpy.array(image.pixels[:]).reshape(HEIGHT, WIDTH, 4)[:, :, 3].sum(0)
        bpy.data.images.remove(image)
        x = numpy.arange(WIDTH) + 0.5
        mean = (alpha * x).sum() / alpha.sum()
        return mean, (alpha * (x - mean) ** 2).sum() / alpha.sum()

    def picture(scene, shutter, position="CENTER"):
        render = scene.render
        render.use_motion_blur, render.motion_blur_shutter = shutter > 0, max(shutter, 0.01)
        render.motion_blur_position, render.filepath = position, path("picture.exr")
        bpy.ops.render.render(write_still=True)
        return moments(path("picture.exr"))

    def blur(scene, still, what, shutter, position="CENTER", length=STEP * PIXELS_PER_UNIT, shift=0):
        """A shutter that is open while something moves by s convolves the picture with a box of length s, which adds
        s² / 12 to the variance."""
        mean, variance = picture(scene, shutter, position)
        found = math.sqrt(max(0, 12 * (variance - still[1])))
        check("%s, shutter %g %s: smear %.2f of %.2f pixels, centre moved by %.2f of %.2f" %
              (what, shutter, position, found, length * shutter, mean - still[0], shift),
              abs(found - length * shutter) < 1 and abs(mean - still[0] - shift) < 0.5)

    bpy.ops.wm.read_homefile(use_empty=True)
    scene = prepare(imported(path("moved", "drop.0003.ply")))
    show(3)
    still = picture(scene, 0)
    travel = STEP * PIXELS_PER_UNIT
    blur(scene, still, "add-on", 0.5)
    blur(scene, still, "add-on", 1.0)
    blur(scene, still, "add-on", 0.5, "START", shift=travel / 4)
    blur(scene, still, "add-on", 0.5, "END", shift=-travel / 4)
    scene.render.use_motion_blur, scene.frame_start, scene.frame_end, scene.frame_step = False, 1, 3, 2
    scene.render.filepath = path("film.")
    bpy.ops.render.render(animation=True)
    step = moments(path("film.0003.exr"))[0] - moments(path("film.0001.exr"))[0]
    check("an animation shows each frame: the drop moves by %.2f of %.2f pixels" % (step, 2 * travel),
          abs(step - 2 * travel) < 0.5)
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = prepare(imported(path("moved", "rest.0003.ply")))
    show(3)
    blur(scene, picture(scene, 0), "no velocities in the file", 1.0, length=0)

    # Blender's own importers
    def in_world(item, data, name):
        turn = numpy.array(item.matrix_world.to_3x3())
        return numbers(data, name, 3) @ turn.T

    run("mesh", "p.####.csv", "u.####.usda", *options)
    run("mesh", "p.####.csv", "a.####.abc", *options)
    for name, importer, arguments in (
            ("u.usda", bpy.ops.wm.usd_import, {}),
            ("a.0001.abc", bpy.ops.wm.alembic_import, {"is_sequence": True, "as_background_job": False})):
        bpy.ops.wm.read_homefile(use_empty=True)
        importer(filepath=path(name), **arguments)
        item = next(found for found in bpy.data.objects if found.type == "MESH")
        for frame in (2, 5):
            show(frame)
            seen = item.evaluated_get(bpy.context.evaluated_depsgraph_get())
            positions, velocities = (rotated(expected[frame][0][key]) for key in ("P", "v"))
            good = len(seen.data.vertices) == len(positions)
            good = good and abs(in_world(seen, seen.data.vertices, "co") - positions).max() < 1e-6
            found = in_world(seen, seen.data.attributes["velocity"].data, "vector")
            check("%s through Blender's importer, frame %d: positions and velocities" % (name, frame),
                  good and abs(found - velocities).max() < 1e-5)
        scene = prepare(item)
        show(3)
        still = picture(scene, 0)
        blur(scene, still, name, 0.5)
        blur(scene, still, name, 1.0)

    # Removal
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.betamesh_sequence")
    handlers = [len(bpy.app.handlers.frame_change_pre), len(bpy.app.handlers.load_post)]
    check("disabling the add-on removes its handlers and settings",
          handlers == handlers_before and not hasattr(bpy.types.Mesh, "betamesh_sequence"))


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)  # some versions of bpy crash while Python ends
