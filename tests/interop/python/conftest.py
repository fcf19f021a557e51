"""What the tests of the Python module share. BETAMESH_PROGRAM is the path of the program, with which they compare."""

import os
import subprocess

import numpy as np
import pytest

import betamesh


@pytest.fixture(scope="session")
def program():
    """Runs the program: program("mesh", IN, OUT) returns what it prints."""
    path = os.path.abspath(os.environ["BETAMESH_PROGRAM"])

    def run(*words):
        words = [path, *map(str, words)]
        result = subprocess.run(words, capture_output=True, text=True, check=False)
        assert result.returncode in (0, 1), result.stderr
        return result.stdout

    return run


@pytest.fixture(scope="session")
def samples(program, tmp_path_factory):
    """Names of particle files: two frames of each sample."""
    folder = tmp_path_factory.mktemp("samples")
    files = {}
    for name in ("dambreak", "drop", "rotcube"):
        program("sample", name, folder / (name + ".####.vdb"), "--particles", 3000, "--frames", "6,7")
        files[name] = [folder / (name + ".%04d.vdb" % frame) for frame in (6, 7)]
    return files


def lattice(n=6, spacing=0.1, seed=1):
    """Jittered positions in a cube, n along each side, float64."""
    grid = np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), -1).reshape(-1, 3) * spacing
    return grid + np.random.default_rng(seed).uniform(-0.2, 0.2, grid.shape) * spacing


@pytest.fixture
def block():
    return lattice()


def same(a, b):
    """Whether two meshes have the same numbers."""
    return (
        np.array_equal(a.vertices, b.vertices)
        and np.array_equal(a.triangles, b.triangles)
        and (a.velocities is None) == (b.velocities is None)
        and (a.velocities is None or np.array_equal(a.velocities, b.velocities))
    )


assert betamesh.__version__
