#!/usr/bin/env python3
"""Compares betamesh with splashsurf, from PyPI as pysplashsurf, on a calm pool whose particles are jittered.

    python3 -m pip install pysplashsurf
    python3 compare_splashsurf.py [SPACINGS]      the pool is SPACINGS wide (default 40) and half as deep

The pool should be flat and have the volume of its particles. splashsurf has the settings that its documentation
recommends for a smooth surface: smoothing length 2 and cube size 0.5 particle radii, weighted smoothing.
"""

import sys
import time

import numpy as np
import pysplashsurf

import betamesh

width = int(sys.argv[1]) if len(sys.argv) > 1 else 40
dx = 0.1
grid = np.stack(np.meshgrid(np.arange(width), np.arange(width // 2), np.arange(width), indexing="ij"), axis=-1)
positions = grid.reshape(-1, 3) * dx + np.random.default_rng(1).uniform(-dx / 4, dx / 4, (grid.size // 3, 3))
top, side = (width // 2 - 1) * dx, (width - 1) * dx


def with_betamesh():
    mesh = betamesh.skin(positions, spacing=dx)
    return mesh.vertices, mesh.triangles


def with_splashsurf(smoothing):
    mesh, _ = pysplashsurf.reconstruction_pipeline(
        positions,
        particle_radius=dx / 2,
        smoothing_length=2.0,
        cube_size=0.5,
        iso_surface_threshold=0.6,
        mesh_cleanup=smoothing > 0,
        mesh_smoothing_iters=smoothing,
        mesh_smoothing_weights=True,
    )
    return mesh.mesh.vertices, mesh.mesh.triangles


def report(name, surface):
    start = time.perf_counter()
    vertices, triangles = surface()
    seconds = time.perf_counter() - start
    mesh = betamesh.Mesh(vertices, triangles)
    check = betamesh.check(mesh)
    # Tilt of the surface in the middle of the pool's top, where it should be level.
    inner = (np.abs(vertices[:, [0, 2]] - side / 2) < side / 4).all(axis=1) & (vertices[:, 1] > top - dx)
    up = np.clip(mesh.normals[inner, 1], -1, 1)
    tilt = np.degrees(np.sqrt(np.mean(np.arccos(up) ** 2)))
    volume = check["volume"] / (len(positions) * dx**3)
    print(
        "%-28s %7.2f s %9d triangles   bumps %5.2f degrees   volume %.3f   %s"
        % (name, seconds, len(triangles), tilt, volume, "good" if check["good"] else ", ".join(check["faults"]))
    )


print("%d particles" % len(positions))
report("betamesh", with_betamesh)
report("splashsurf", lambda: with_splashsurf(0))
report("splashsurf, 25 smoothing steps", lambda: with_splashsurf(25))
