"""The module makes the bytes that the program makes, for the same settings."""

import json

import numpy as np
import pytest

import betamesh

# Arguments of skin() and the options of the program that mean the same.
SETTINGS = {
    "defaults": ({}, []),
    "lengths": (dict(radius="1.8dx", skin="0.4dx"), ["--radius", "1.8dx", "--skin", "0.4dx"]),
    "world_units": (dict(radius=0.09, spacing=0.06), ["--radius", "0.09", "--spacing", "0.06"]),
    "balls": (dict(skin="none", smoothing_method="none"), ["--skin", "none", "--smoothing", "none"]),
    "passes": (
        dict(smoothing_passes=2, smoothing_width="4dx", arc_subdivisions=1),
        ["--passes", 2, "--smoothing-width", "4dx", "--arc-subdivisions", 1],
    ),
    "paper": (
        dict(tessellation="paper", smoothing_method="paper", resolve_intersections=True, bubbles="mesh"),
        ["--tessellation", "paper", "--smoothing", "paper", "--resolve-intersections", "--bubbles", "mesh"],
    ),
    "float": (
        dict(predicates="float", perturbation_retries=5, perturbation_tolerance=1e-4),
        ["--predicates", "float", "--retries", 5, "--tolerance", "1e-4"],
    ),
    "alpha": (dict(kind="alpha"), ["--surface", "alpha"]),
    "features": (
        dict(droplets="points", droplet_particles=20, tendrils="points", bubble_gap="3dx", components=True),
        "--droplets points --droplet-particles 20 --tendrils points --bubble-gap 3dx --components".split(),
    ),
    "measured": (
        dict(normals=True, surface_attributes=["thickness", "curvature", "shape"], walls=["y>0", "0.6x+0.8z<1"]),
        "--output-normals --surface-attributes thickness,curvature,shape --walls y>0,0.6x+0.8z<1".split(),
    ),
}


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("settings", SETTINGS)
@pytest.mark.parametrize("sample", ["dambreak", "drop", "rotcube"])
def test_writes_the_bytes_of_the_program(samples, program, tmp_path, sample, settings):
    arguments, options = SETTINGS[settings]
    particles = samples[sample][0]
    program("mesh", particles, tmp_path / "program.ply", *options)
    mesh = betamesh.skin(betamesh.read_particles(particles), **arguments)
    betamesh.write_mesh(tmp_path / "module.ply", mesh)
    assert (tmp_path / "module.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()

    manifest = json.loads((tmp_path / "program.ply.json").read_text())
    for name, value in mesh.report.items():
        assert manifest[name] == pytest.approx(value, rel=1e-12), name
    spheres = tmp_path / "program.spheres.ply"
    assert spheres.exists() == (len(mesh.spheres) > 0)
    if spheres.exists():
        betamesh.write_spheres(tmp_path / "module.spheres.ply", mesh.spheres)
        assert (tmp_path / "module.spheres.ply").read_bytes() == spheres.read_bytes()


@pytest.mark.parametrize("extension", ["bgeo", "obj", "vtp", "stl", "bhclassic"])
def test_writes_every_format_as_the_program_does(samples, program, tmp_path, extension):
    particles = samples["drop"][0]
    program("mesh", particles, tmp_path / ("program." + extension))
    betamesh.write_mesh(tmp_path / ("module." + extension), betamesh.skin(betamesh.read_particles(particles)))
    assert (tmp_path / ("module." + extension)).read_bytes() == (tmp_path / ("program." + extension)).read_bytes()


def test_arrays_give_what_files_give(samples, tmp_path, program):
    particles = betamesh.read_particles(samples["drop"][0])
    n = len(particles)
    heat = np.linspace(0, 1, n, dtype=np.float32)
    kind = (np.arange(n) % 3).astype(np.uint8)
    attributes = {"heat": heat, "kind": kind, "direction": np.tile(np.float32([1, 2, 3]), (n, 1))}
    given = betamesh.Particles(particles.positions, particles.velocities, ids=particles.ids, attributes=attributes)
    betamesh.write_particles(tmp_path / "in.ply", given)
    program("mesh", tmp_path / "in.ply", tmp_path / "program.ply", "--attributes", "heat,kind")
    from_file = betamesh.skin(betamesh.read_particles(tmp_path / "in.ply"), attributes=["heat", "kind"])
    from_arrays = betamesh.skin(
        particles.positions,
        particles.velocities,
        ids=particles.ids,
        attributes={"heat": heat, "kind": kind},
    )
    for name, mesh in {"file.ply": from_file, "arrays.ply": from_arrays}.items():
        betamesh.write_mesh(tmp_path / name, mesh)
        assert (tmp_path / name).read_bytes() == (tmp_path / "program.ply").read_bytes()
    assert from_arrays.attributes["heat"].shape == (len(from_arrays.vertices),)
    assert from_arrays.attributes["kind"].dtype == np.int32
    mesh = betamesh.skin(given, attributes=["direction"])
    assert mesh.attributes["direction"] == pytest.approx(np.tile([1, 2, 3], (len(mesh.vertices), 1)), rel=1e-5)


@pytest.mark.parametrize("options", [(), ("--passes", 2, "--skin", "0.4dx")])
def test_curves_are_those_of_the_program(program, tmp_path, options):
    program("sample", "puddle", tmp_path / "in.ply", "--particles", 400, "--frames", 8)
    particles = betamesh.read_particles(tmp_path / "in.ply")
    program("mesh", tmp_path / "in.ply", tmp_path / "program.ply", "--dimension", 2, *options)
    arguments = dict(smoothing_passes=2, skin="0.4dx") if options else {}
    curves = betamesh.skin_plane(particles, **arguments)
    betamesh.write_mesh(tmp_path / "module.ply", curves)
    assert (tmp_path / "module.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()
    manifest = json.loads((tmp_path / "program.ply.json").read_text())
    for name, value in curves.report.items():
        assert manifest[name] == pytest.approx(value, rel=1e-12), name
    read = betamesh.read_curves(tmp_path / "program.ply")
    assert np.array_equal(read.edges, curves.edges) and np.array_equal(read.vertices, curves.vertices)
    shown = json.loads(program("check", tmp_path / "program.ply", "--json"))
    del shown["file"]
    assert json.loads(json.dumps(betamesh.check(read))) == shown


def test_positions_in_double_precision_get_the_origin_of_the_program(program, tmp_path, block):
    far = block + [4.5e6, 0, 250]
    with open(tmp_path / "in.csv", "w", encoding="ascii") as file:
        file.write("x,y,z\n" + "".join("%r,%r,%r\n" % tuple(row) for row in far.tolist()))
    program("mesh", tmp_path / "in.csv", tmp_path / "program.ply")
    with pytest.warns(UserWarning, match="local origin"):
        mesh = betamesh.skin(far)
    betamesh.write_mesh(tmp_path / "module.ply", mesh)
    assert (tmp_path / "module.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()
    manifest = json.loads((tmp_path / "program.ply.json").read_text())
    assert list(mesh.origin) == manifest["local_origin"]
    assert betamesh.read_particles(tmp_path / "in.csv").origin == mesh.origin
    placed = mesh.vertices + np.array(mesh.origin)
    assert np.all(placed.min(0) < far.min(0)) and np.all(placed.max(0) > far.max(0))
    with pytest.warns(UserWarning, match="local origin"):
        moved = betamesh.skin(far, radius=0.15, spacing=0.1)
    given = betamesh.skin(far, radius=0.15, spacing=0.1, origin=moved.origin)
    assert np.array_equal(given.vertices, moved.vertices)


def test_check_and_coherence_tell_what_the_program_tells(samples, program, tmp_path):
    meshes, particles = [], []
    for frame, file in enumerate(samples["drop"]):
        particles.append(betamesh.read_particles(file))
        meshes.append(betamesh.skin(particles[-1], spacing=0.09))
        betamesh.write_mesh(tmp_path / ("m.%d.ply" % frame), meshes[-1])
        betamesh.write_particles(tmp_path / ("p.%d.ply" % frame), particles[-1])
    read = [betamesh.read_mesh(tmp_path / ("m.%d.ply" % frame)) for frame in (0, 1)]
    words = ["check", tmp_path / "m.0.ply", "--json", "--particles", tmp_path / "p.0.ply"]
    shown = json.loads(program(*words))
    del shown["file"], shown["particles"]["file"]
    assert json.loads(json.dumps(betamesh.check(read[0], particles[0]))) == shown
    assert shown["good"]
    size = betamesh.measure(read[0])
    assert size == pytest.approx({name: shown[name] for name in size}, rel=1e-12)

    words = ["coherence", tmp_path / "m.0.ply", tmp_path / "m.1.ply", "--json", "--particles", tmp_path / "p.#.ply"]
    shown = json.loads(program(*words))
    found = betamesh.coherence(*read, *particles)
    for name in found:
        assert json.loads(json.dumps(found[name])) == shown[name], name
    assert found["ratio"] > 0
    assert "ratio" not in betamesh.coherence(*read)


def test_check_lists_the_faults_of_broken_meshes(program, tmp_path):
    tetrahedron = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    two = betamesh.Mesh(
        np.concatenate([corners, corners + 0.1]), np.concatenate([tetrahedron, tetrahedron[:-1] + 4])
    )
    betamesh.write_mesh(tmp_path / "two.obj", two)
    shown = json.loads(program("check", tmp_path / "two.obj", "--json"))
    found = betamesh.check(betamesh.read_mesh(tmp_path / "two.obj"))
    del shown["file"]
    assert json.loads(json.dumps(found)) == shown
    assert found["faults"] == shown["faults"] and "open_edges" in found["faults"] and "crossings" in found["faults"]
    inside_out = betamesh.Mesh(corners, tetrahedron[:, ::-1])
    assert betamesh.check(inside_out)["faults"] == ["inside_out"]
    outside = betamesh.check(betamesh.Mesh(corners, tetrahedron), [[2, 0, 0], [0.1, 0.1, 0.1]])
    assert outside["faults"] == ["particles_outside"]
    assert outside["particles"]["outside"] == 1 and outside["particles"]["farthest"] == 1


def test_spacing_is_that_of_the_program(samples, program, tmp_path):
    files = samples["drop"]
    pattern = files[0].parent / "drop.####.vdb"
    program("mesh", pattern, tmp_path / "m.####.ply")
    manifest = json.loads((tmp_path / "m.0006.ply.json").read_text())
    frames = [betamesh.read_particles(file) for file in files]
    assert betamesh.spacing(*frames) == manifest["spacing"]
    assert betamesh.spacing(*[frame.positions for frame in frames]) == manifest["spacing"]
