"""The scripts in pipelines/python run and do what they say."""

import pathlib
import subprocess
import sys

import pytest

import betamesh

EXAMPLES = pathlib.Path(__file__).parents[3] / "pipelines" / "python"


def run(name, *words):
    command = [sys.executable, str(EXAMPLES / name), *map(str, words)]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_a_sequence_becomes_the_files_of_the_program(samples, program, tmp_path):
    files = samples["drop"]
    pattern = str(files[0].parent / "drop.*.vdb")
    assert "spacing" in run("sequence.py", pattern, tmp_path / "mesh")
    program("mesh", files[0].parent / "drop.####.vdb", tmp_path / "program.####.usda")
    for frame in ("0006", "0007"):
        expected = (tmp_path / ("program.%s.usda" % frame)).read_bytes()
        assert (tmp_path / "mesh" / ("drop.%s.usda" % frame)).read_bytes() == expected
    assert run("sequence.py", pattern, tmp_path / "mesh").count("exists") == 2
    run("sequence.py", pattern, tmp_path / "mesh", "--extension", ".obj", "--radius", "1.2dx", "--at-once", 1)
    assert len(betamesh.read_mesh(tmp_path / "mesh" / "drop.0006.obj").triangles) > 0


def test_one_frame_makes_a_picture(samples, tmp_path):
    pytest.importorskip("matplotlib")
    assert "good" in run("one_frame.py", samples["drop"][0], tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_the_comparison_with_splashsurf_prints_a_table():
    pytest.importorskip("pysplashsurf")
    lines = run("compare_splashsurf.py", 12).splitlines()
    assert len(lines) == 4 and lines[1].startswith("betamesh") and lines[1].endswith("good")
    bumps = [float(line.split("bumps")[1].split()[0]) for line in lines[1:]]
    assert bumps[0] < bumps[2] < bumps[1]
