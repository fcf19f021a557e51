"""Threads, progress, interruption."""

import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import lattice, same

import betamesh

STAGES = ["spacing", "structure", "tessellate", "smooth", "velocity"]


def test_the_number_of_threads_changes_nothing():
    positions = lattice(12)
    expected = betamesh.skin(positions, positions, threads=1)
    for threads in (2, 7, None):
        assert same(betamesh.skin(positions, positions, threads=threads), expected)


def test_two_frames_at_once():
    clouds = [lattice(12, seed=1), lattice(11, seed=2)]
    expected = [betamesh.skin(cloud) for cloud in clouds]
    for threads in (None, 1):
        found = [[], []]

        def work(i, threads=threads, found=found):
            found[i].extend(betamesh.skin(clouds[i], threads=threads) for _ in range(4))

        workers = [threading.Thread(target=work, args=(i,)) for i in (0, 1)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        assert [len(meshes) for meshes in found] == [4, 4]
        assert all(same(mesh, expected[i]) for i in (0, 1) for mesh in found[i])


def test_other_threads_go_on_meanwhile():
    ticks = []
    stop = threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    ticker = threading.Thread(target=tick)
    ticker.start()
    start = time.monotonic()
    betamesh.skin(lattice(26), threads=1)
    end = time.monotonic()
    stop.set()
    ticker.join()
    within = [t for t in ticks if start < t < end]
    assert end - start > 0.1 and len(within) > (end - start) / 0.05


def test_progress_names_the_stages_in_order():
    calls = []
    expected = betamesh.skin(lattice(20))

    def progress(stage, seconds):
        calls.append((stage, seconds, threading.get_ident()))

    mesh = betamesh.skin(lattice(20), progress=progress)
    assert same(mesh, expected)
    stages = [stage for stage, _, _ in calls]
    assert [s for i, s in enumerate(stages) if i == 0 or stages[i - 1] != s] == [s for s in STAGES if s in stages]
    assert {"structure", "smooth"} <= set(stages) <= set(STAGES)
    seconds = [s for _, s, _ in calls]
    assert seconds == sorted(seconds) and seconds[0] >= 0
    assert {thread for _, _, thread in calls} == {threading.get_ident()}  # the caller's


class Stopped(Exception):
    pass


@pytest.mark.parametrize("at", ["structure", "smooth"])
def test_an_exception_of_progress_ends_the_call(at):
    def progress(stage, seconds):
        if stage == at:
            raise Stopped(stage)

    positions = lattice(55)
    start = time.monotonic()
    with pytest.raises(Stopped):
        betamesh.skin(positions, spacing=0.1, radius="2.5dx", progress=progress)
    assert time.monotonic() - start < 10
    small = lattice(8)
    assert same(betamesh.skin(small), betamesh.skin(small, threads=1))  # the next call is not affected


def test_ctrl_c_ends_a_long_call():
    code = """
import time, numpy as np, betamesh
grid = np.stack(np.meshgrid(*[np.arange(100)] * 3), -1).reshape(-1, 3) * 0.1
grid = grid + np.random.default_rng(1).uniform(-.02, .02, grid.shape)
print("begins", flush=True)
try:
    betamesh.skin(grid, spacing=0.1, radius="2.5dx", threads=1, smoothing_passes=100)
    print("ended")
except KeyboardInterrupt:
    print("interrupted", betamesh.skin(grid[::1000], radius=0.15, spacing=0.1) is not None)
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=os.environ)
    assert process.stdout.readline() == "begins\n"
    time.sleep(1.5)
    process.send_signal(signal.SIGINT)
    start = time.monotonic()
    assert process.communicate(timeout=60)[0] == "interrupted True\n"
    assert time.monotonic() - start < 10
