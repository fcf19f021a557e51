"""What may be passed to the functions, and what they say about the rest."""

import inspect
import os
import re

import numpy as np
import pytest
from conftest import lattice, same

import betamesh
from betamesh import _betamesh


def test_the_arguments_are_the_keys_of_pipeline_files_with_their_defaults():
    table = {path: default for path, default, _, _ in _betamesh.settings()}
    assert set(betamesh._KEYS.values()) | {"surface.dimension"} == set(table)
    for function in (betamesh.skin, betamesh.skin_plane):
        parameters = inspect.signature(function).parameters
        for name, key in betamesh._KEYS.items():
            if name not in parameters:
                assert function is betamesh.skin_plane  # which has no keys of three dimensions
                continue
            default = parameters[name].default
            if name == "bubbles":
                assert default is None and table[key] == "fill"
            else:
                assert betamesh._text(default) == re.sub("1e-05", "1e-05", table[key]), name
        for name in parameters:
            assert name in function.__doc__ or function is betamesh.skin_plane, name


@pytest.mark.parametrize(
    "convert",
    [
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1][::-1],
        lambda a: np.concatenate([a, a], axis=1)[:, 3:],
        lambda a: a.astype(">f4"),
        lambda a: a.astype(np.float64),
        lambda a: a.astype(np.longdouble),
        lambda a: a.tolist(),
        lambda a: tuple(map(tuple, a.tolist())),
        lambda a: np.rec.fromarrays([np.zeros(len(a), "u1"), a], dtype=[("flag", "u1"), ("P", "f4", 3)])["P"],
        lambda a: memoryview(np.ascontiguousarray(a)),
        lambda a: _read_only(a),
    ],
    ids="fortran strided reversed columns big_endian float64 longdouble list tuple packed buffer read_only".split(),
)
def test_strides_and_types_do_not_matter(convert):
    positions = lattice().astype(np.float32)
    velocities = np.random.default_rng(2).normal(size=positions.shape).astype(np.float32)
    expected = betamesh.skin(positions, velocities)
    assert same(betamesh.skin(convert(positions), convert(velocities)), expected)


def _read_only(array):
    array = array.copy()
    array.flags.writeable = False
    return array


def test_whole_numbers_are_positions(block):
    whole = np.round(block * 1000).astype(np.int32)
    assert same(betamesh.skin(whole), betamesh.skin(whole.astype(np.float32)))


def test_outputs_have_the_documented_shapes_and_types(block):
    mesh = betamesh.skin(block, block * 0 + [1, 2, 3], components=True, attributes={"a": block[:, 0], "b": block})
    n, m = len(mesh.vertices), len(mesh.triangles)
    for array, shape, dtype in [
        (mesh.vertices, (n, 3), np.float32),
        (mesh.velocities, (n, 3), np.float32),
        (mesh.normals, (n, 3), np.float32),
        (mesh.triangles, (m, 3), np.uint32),
        (mesh.components, (m,), np.int32),
        (mesh.attributes["a"], (n,), np.float32),
        (mesh.attributes["b"], (n, 3), np.float32),
    ]:
        assert array.shape == shape and array.dtype == dtype and array.flags.c_contiguous
        assert not array.flags.writeable
    assert mesh.triangles.max() == n - 1
    assert mesh.velocities == pytest.approx(np.tile([1, 2, 3], (n, 1)), rel=1e-5)
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(n), rel=1e-5)
    assert np.all(np.sum(mesh.normals * (mesh.vertices - block.mean(0)), axis=1) > 0)
    assert betamesh.check(mesh)["good"]
    assert betamesh.skin(block).velocities is None and betamesh.skin(block).components is None


def test_arrays_are_views_that_keep_their_mesh(block):
    mesh = betamesh.skin(block, attributes={"a": block[:, 0]})
    assert mesh.triangles.ctypes.data == mesh.triangles.ctypes.data
    assert mesh.vertices.ctypes.data == mesh.vertices.ctypes.data
    arrays = [mesh.triangles, mesh.vertices, mesh.attributes["a"], mesh.spheres.positions]
    copies = [array.copy() for array in arrays]
    del mesh
    for _ in range(20):
        betamesh.skin(block)  # takes the memory if it was released
    assert all(np.array_equal(a, b) for a, b in zip(arrays, copies))


@pytest.mark.parametrize("empty", [[], np.zeros((0, 3)), np.zeros((0, 3), np.float32)])
def test_no_particles_give_an_empty_mesh(tmp_path, empty):
    mesh = betamesh.skin(empty, empty, ids=[], attributes={"a": []}, components=True)
    assert mesh.vertices.shape == (0, 3) and mesh.triangles.shape == (0, 3) and mesh.normals.shape == (0, 3)
    assert mesh.attributes["a"].shape == (0,) and len(mesh.spheres) == 0
    assert betamesh.check(mesh)["good"]
    betamesh.write_mesh(tmp_path / "empty.ply", mesh)
    assert betamesh.skin_plane(empty).edges.shape == (0, 2)
    assert betamesh.spacing(empty) is None


def test_one_particle_needs_a_length():
    with pytest.raises(ValueError, match="cannot be measured"):
        betamesh.skin([[0, 0, 0]])
    mesh = betamesh.skin([[0, 0, 0]], radius=0.15)
    assert betamesh.measure(mesh)["volume"] == pytest.approx(0.1**3, rel=0.05)


WRONG = [
    (dict(positions=np.zeros((4, 2))), r"positions has the shape \(4, 2\). Use \(n, 3\)"),
    (dict(positions=np.zeros(12)), r"positions has the shape \(12,\)"),
    (dict(positions=0.0), r"positions has the shape \(\)"),
    (dict(positions=np.zeros((4, 3), complex)), "positions has the type complex128"),
    (dict(positions=[["a", "b", "c"]]), "positions has the type <U1"),
    (dict(positions=None), "positions has the type object"),
    (dict(positions=[[0, 0, 0], [0, float("nan"), 0]]), "particle 1: position is .*nan"),
    (dict(positions=[[0, 0, 0], [0, 1e300, 0]]), "particle 1: position is .*inf"),
    (dict(velocities=np.zeros((3, 3))), "velocities has 3 rows, but there are 216 positions"),
    (dict(velocities=np.full((216, 3), np.inf)), "particle 0: velocity is .*inf"),
    (dict(ids=np.zeros(216)), "ids has the shape .* of floating-point numbers"),
    (dict(ids=-np.arange(216)), "ids: row 1 is -1"),
    (dict(ids=np.arange(7)), "ids has 7 rows"),
    (dict(attributes={"a": np.zeros(7)}), r"attributes\['a'\] has the shape \(7,\). Use \(216,\)"),
    (dict(attributes={"a": np.zeros((216, 2, 2))}), r"attributes\['a'\] has the shape"),
    (dict(attributes={"a": np.full(216, 1e300)}), "row 0 is .*, which 32-bit"),
    (dict(attributes={"a": np.full(216, 2**40)}), "row 0 is 1099511627776, which does not fit"),
    (dict(attributes={"a": np.array(["x"] * 216)}), r"attributes\['a'\] has the type"),
    (dict(attributes="a"), "attributes is text"),
    (dict(attributes={1: np.zeros(216)}), "name is no text"),
    (dict(attributes=["a"]), "attributes is no dict"),
    (dict(radius="1.5dy"), r"radius: '1.5dy' is not valid. Use a number above 0 in world units, or a multiple"),
    (dict(radius=-1), "radius: '-1' is not valid"),
    (dict(radius=float("nan")), "radius: 'nan' is not valid"),
    (dict(radius=None), "radius: 'None' is not valid"),
    (dict(radius=[1]), "radius: .* is not valid"),
    (dict(radius=60.0), r"the radius 60 is .* times the particle spacing .*, measured in these particles"),
    (dict(radius=1e-9, spacing=0.1), "expected a radius of 0.01 to 100 spacings"),
    (dict(radius=1e-44), "radius: '1e-44' is not valid"),
    (dict(spacing=0), "spacing: '0' is not valid"),
    (dict(skin="2dx"), "surface.skin is 2dx, but must be less than surface.radius"),
    (dict(skin=None), "skin: 'None' is not valid"),
    (dict(skin="0.5dx", kind="alpha"), "surface.skin is 0.5dx"),
    (dict(kind="beat"), r"kind: 'beat' is not valid. Use one of beta, alpha, union. Did you mean 'beta'"),
    (dict(arc_subdivisions=0), "arc_subdivisions: '0' is not valid"),
    (dict(smoothing_passes=1.5), "smoothing_passes: '1.5' is not valid"),
    (dict(resolve_intersections="yes"), "resolve_intersections: 'yes' is not valid"),
    (dict(perturbation_tolerance=1), "perturbation_tolerance: '1' is not valid"),
    (dict(threads=0), "threads: '0' is not valid"),
    (dict(threads="two"), "threads: 'two' is not valid"),
    (dict(progress=3), "progress cannot be called"),
    (dict(origin="middle"), "origin: 'middle' is not valid"),
    (dict(origin=[0, 0, float("inf")]), "origin: "),
    (dict(origin=[0, 0]), "origin: "),
]


@pytest.mark.parametrize("arguments,message", WRONG, ids=[str(i) for i in range(len(WRONG))])
def test_wrong_arguments_raise_value_error(block, arguments, message):
    with pytest.raises(ValueError, match=message):
        betamesh.skin(**{"positions": block, **arguments})


def test_attributes_measured_on_the_surface(block):
    mesh = betamesh.skin(block, normals=True, surface_attributes=["thickness", "shape"], attributes={"a": block[:, 0]})
    assert list(mesh.attributes) == ["a", "N", "thickness", "drop", "thread", "sheet", "bulk"]
    assert np.array_equal(mesh.normals, mesh.attributes["N"]) and mesh.normals.shape == mesh.vertices.shape
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.vertices)), rel=1e-5)
    assert sum(mesh.attributes[name] for name in ("drop", "thread", "sheet", "bulk")) == pytest.approx(1, abs=1e-5)
    assert list(betamesh.skin(block, surface_attributes="curvature").attributes) == ["N", "curvature"]
    assert list(betamesh.skin(block).attributes) == ["N"] and not betamesh.skin(block, normals=False).attributes
    assert not betamesh.skin(block, kind="alpha", skin="none").attributes
    carried = betamesh.skin(block, attributes={"N": block * 0 + [0, 2, 0]}).attributes["N"]
    assert carried == pytest.approx(np.tile([0, 2, 0], (len(carried), 1)))
    with pytest.raises(ValueError, match="surface_attributes: 'shapes' is not valid.*Did you mean 'shape'"):
        betamesh.skin(block, surface_attributes=["shapes"])


def test_walls_are_in_the_coordinates_of_the_positions(block):
    settings = dict(radius=0.15, spacing=0.1)
    low = block[:, 1].min() - 0.05
    mesh = betamesh.skin(block, walls=[f"y>{low}"], **settings)
    assert np.sum(np.abs(mesh.vertices[:, 1] - low) < 0.001) > 20
    moved = betamesh.skin(block.astype(float) + [0, 1e6, 0], walls=f"y>{1e6 + low}", origin=[0, 1e6, 0], **settings)
    assert moved.vertices == pytest.approx(mesh.vertices, abs=1e-4)
    with pytest.raises(ValueError, match="walls: 'y=0' is not valid"):
        betamesh.skin(block, walls="y=0")


def test_the_mesh_is_cut_off_at_a_box(block):
    mesh = betamesh.skin(block, box=[-1, -1, -1, 0.25, 1, 1], radius=0.15, spacing=0.1)
    assert mesh.vertices[:, 0].max() == 0.25 and betamesh.check(mesh)["good"]
    with pytest.raises(ValueError, match="box: '1,2' is not valid".replace("1,2", "1.0,2.0")):
        betamesh.skin(block, box=(1, 2))


def test_particles_bring_their_own_arrays(block):
    particles = betamesh.Particles(block, attributes={"a": block[:, 0]})
    with pytest.raises(ValueError, match="have their own"):
        betamesh.skin(particles, block)
    with pytest.raises(ValueError, match="have their own"):
        betamesh.skin(particles, attributes={"b": block[:, 0]})
    with pytest.raises(ValueError, match="'b'.*a"):
        betamesh.skin(particles, attributes=["b"])
    assert list(betamesh.skin(particles, attributes=["a"]).attributes) == ["a", "N"]
    assert list(betamesh.skin(particles).attributes) == ["N"]
    assert len(particles) == len(block) and particles.velocities is None and particles.ids is None


def test_planar_settings_and_positions():
    flat = lattice(7)[:, :2] * [1, 1] + 0
    flat = np.unique(np.round(flat, 1), axis=0)
    curves = betamesh.skin_plane(flat, flat * 0 + [1, 0])
    assert np.all(curves.vertices[:, 2] == 0) and np.all(curves.velocities[:, 0] > 0)
    assert betamesh.check(curves, flat)["good"]
    across = np.stack([flat[:, 0], flat[:, 0] * 0 + 2, flat[:, 1]], axis=1)
    assert np.all(betamesh.skin_plane(across).vertices[:, 1] == 2)
    with pytest.raises(ValueError, match="do not lie in a plane of one z, one y or one x"):
        betamesh.skin_plane(lattice())
    with pytest.raises(TypeError):
        betamesh.skin_plane(flat, predicates="float")


@pytest.mark.parametrize(
    "vertices,triangles,message",
    [
        (np.zeros((3, 3)), [[0, 1, 3]], "triangles: row 0 has the vertex 3. Use numbers from 0 to 3 - 1"),
        (np.zeros((3, 3)), [[0, 1, -1]], "row 0 has the vertex -1"),
        (np.zeros((3, 3)), [[0, 1]], r"triangles has the shape \(1, 2\)"),
        (np.zeros((3, 3)), [[0.0, 1, 2]], "of floating-point numbers"),
        (np.zeros((3, 2)), [[0, 1, 2]], r"vertices has the shape \(3, 2\)"),
    ],
)
def test_meshes_of_wrong_arrays_are_refused(vertices, triangles, message):
    with pytest.raises(ValueError, match=message):
        betamesh.Mesh(vertices, triangles)


def test_simplified_meshes_have_fewer_of_the_same_vertices(block):
    mesh = betamesh.skin(block, block)
    few = betamesh.simplify(mesh, 0.002)
    assert len(few.triangles) < len(mesh.triangles) and betamesh.check(few)["good"]
    rows = lambda m: {tuple(row) for row in np.hstack([m.vertices, m.velocities])}
    assert rows(few) <= rows(mesh)
    assert same(few, betamesh.simplify(mesh, 0.002, threads=1))
    with pytest.raises(ValueError, match="positive length"):
        betamesh.simplify(mesh, 0)


def test_lengths_that_do_not_suit_the_particles_get_a_warning(block):
    with pytest.warns(UserWarning, match="is used for all frames"):
        betamesh.skin(block, spacing=0.2)
    with pytest.warns(UserWarning, match="0.8 to 3 times"):
        betamesh.skin(block, radius="3.5dx")
    with pytest.warns(UserWarning, match="smoothing.method paper needs"):
        betamesh.skin(block, smoothing_method="paper")
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        betamesh.skin(block)
        with pytest.raises(UserWarning):
            betamesh.skin(block, spacing=0.2)


def test_files_raise_what_python_expects(tmp_path, block):
    mesh = betamesh.skin(block)
    for read in (betamesh.read_particles, betamesh.read_mesh, betamesh.read_curves):
        with pytest.raises(FileNotFoundError, match="none.ply: cannot be read: No such file"):
            read(tmp_path / "none.ply")
        with pytest.raises(IsADirectoryError):
            (tmp_path / "folder.ply").mkdir(exist_ok=True)
            read(tmp_path / "folder.ply")
        with pytest.raises(ValueError, match=r"none.docx"):
            read(tmp_path / "none.docx")
    with pytest.raises(FileNotFoundError) as error:
        betamesh.read_particles(tmp_path / "none.vdb")
    assert error.value.errno == 2
    (tmp_path / "damaged.ply").write_bytes(b"ply\nformat ascii 1.0\nelement vertex 3\n")
    with pytest.raises(ValueError, match="damaged.ply"):
        betamesh.read_mesh(tmp_path / "damaged.ply")
    with pytest.raises(FileNotFoundError):
        betamesh.write_mesh(tmp_path / "none" / "m.ply", mesh)
    with pytest.raises(ValueError, match=r"m.docx"):
        betamesh.write_mesh(tmp_path / "m.docx", mesh)
    if os.geteuid() != 0:
        (tmp_path / "locked").mkdir(mode=0o500)
        with pytest.raises(PermissionError):
            betamesh.write_mesh(tmp_path / "locked" / "m.ply", mesh)
    with pytest.raises(ValueError, match="neither"):
        betamesh.write_mesh(tmp_path / "m.ply", block)
    betamesh.write_mesh(str(tmp_path / "m.ply"), mesh)
    betamesh.write_mesh(tmp_path / "m.ply", mesh)  # replaces it
    assert same(betamesh.read_mesh(tmp_path / "m.ply"), betamesh.Mesh(mesh.vertices, mesh.triangles, mesh.vertices * 0))


def test_time_samples_are_read_by_frame(tmp_path):
    face = "int[] faceVertexCounts = [3]\nint[] faceVertexIndices = [0, 1, 2]\n"
    points = ", ".join(f"{x}: [({x}, 0, 0), ({x}, 1, 0), ({x}, 0, 1)]" for x in (1, 3))
    samples = "point3f[] points.timeSamples = { " + points + " }\n"
    (tmp_path / "p.usda").write_text('#usda 1.0\ndef Points "p" {\n' + samples + "}\n")
    (tmp_path / "m.usda").write_text('#usda 1.0\ndef Mesh "m" {\n' + face + samples + "}\n")
    for frame, x in ((None, 1), (1, 1), (2, 1), (3, 3), (3.5, 3)):
        assert betamesh.read_particles(tmp_path / "p.usda", frame=frame).positions[0, 0] == x
        assert betamesh.read_mesh(tmp_path / "m.usda", frame=frame).vertices[0, 0] == x
    with pytest.raises(ValueError, match="frame is not finite"):
        betamesh.read_mesh(tmp_path / "m.usda", frame=float("nan"))


def test_reading_chooses_and_converts_particles(tmp_path, block):
    kind = np.arange(len(block)) % 2
    particles = betamesh.Particles(block, block, ids=np.arange(len(block)) + 5, attributes={"kind": kind.astype("i4")})
    betamesh.write_particles(tmp_path / "p.ply", particles)
    chosen = betamesh.read_particles(tmp_path / "p.ply", where="kind == 1", scale=2, velocity_scale=0.5, up_axis="z")
    expected = np.float32(block[kind == 1])[:, [0, 2, 1]] * [2, 2, -2]
    assert chosen.positions == pytest.approx(expected) and chosen.velocities == pytest.approx(expected / 2)
    assert np.array_equal(chosen.ids, np.arange(len(block))[kind == 1] + 5)
    assert np.all(chosen.attributes["kind"] == 1)
    boxed = betamesh.read_particles(tmp_path / "p.ply", box=[0, 0, 0, 1, 1, 0.3], origin=(0.5, 0, 0))
    assert 0 < len(boxed) < len(block) and boxed.origin == (0.5, 0, 0)
    for arguments, message in [
        (dict(where="kind =="), "kind =="),
        (dict(up_axis="x"), "up_axis: 'x' is not valid. Use one of y, z"),
        (dict(on_bad_particle="dorp"), "Did you mean 'drop'"),
        (dict(scale=0), "scale: "),
        (dict(velocity="vv"), "vv"),
    ]:
        with pytest.raises(ValueError, match=re.escape(message)):
            betamesh.read_particles(tmp_path / "p.ply", **arguments)
