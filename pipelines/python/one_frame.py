"""A look at one frame, cell by cell as in a notebook (VS Code, Spyder and Jupytext understand the marks).

    python3 one_frame.py [PARTICLES] [PICTURE]

Without particles it makes a drop above a pool. The picture is one_frame.png unless another one is named.
"""

# %% Particles: any array of shape (n, 3), or a file
import sys

import matplotlib

matplotlib.use("Agg")  # leave this out in a notebook
import matplotlib.pyplot as plt
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
import numpy as np

import betamesh

dx = 0.1
if len(sys.argv) > 1:
    particles = betamesh.read_particles(sys.argv[1])
    positions, velocities = particles.positions, particles.velocities
else:
    x, y, z = np.meshgrid(*[np.arange(-1, 1, dx)] * 3, indexing="ij")
    grid = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    pool = grid[grid[:, 1] < -0.5]
    drop = grid[np.linalg.norm(grid - [0, 0.3, 0], axis=1) < 0.35]
    positions = np.concatenate([pool, drop])
    positions += np.random.default_rng(1).uniform(-dx / 4, dx / 4, positions.shape)
    velocities = np.where(positions[:, 1:2] > -0.4, [0, -2, 0], 0.0)
print(len(positions), "particles with a spacing of", betamesh.spacing(positions))

# %% The surface, with the speed of the particles
speed = np.zeros(len(positions)) if velocities is None else np.linalg.norm(velocities, axis=1)
mesh = betamesh.skin(positions, velocities, attributes={"speed": speed})
print(mesh, mesh.report)

# %% Is it closed, manifold and free of self-intersections?
check = betamesh.check(mesh, positions)
print("good" if check["good"] else check["faults"], check["components"], "components, volume", check["volume"])

# %% What does another radius join?
for radius in ("1.2dx", "1.5dx", "2dx"):
    size = betamesh.measure(betamesh.skin(positions, radius=radius))
    print("radius", radius, "components", size["components"], "volume", size["volume"])

# %% A picture: triangles shaded by their normals, coloured by speed; and a section
figure = plt.figure(figsize=(10, 5))
view = figure.add_subplot(121, projection="3d")
corners = mesh.vertices[mesh.triangles][:, :, [0, 2, 1]]  # matplotlib has z up
light = np.clip(mesh.normals[mesh.triangles].mean(axis=1) @ [0.4, 0.8, 0.4], 0.2, 1)
colours = plt.get_cmap("viridis")(plt.Normalize()(mesh.attributes["speed"][mesh.triangles].mean(axis=1)))
colours[:, :3] *= light[:, None]
view.add_collection3d(Poly3DCollection(corners, facecolors=colours))
low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
view.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]), box_aspect=high - low)
view.set_title("%d triangles, coloured by speed" % len(mesh.triangles))

section = figure.add_subplot(122)
middle = (low[1] + high[1]) / 2
for corner in corners:
    sides = corner[:, 1] - middle
    ends = [
        corner[i] + (corner[j] - corner[i]) * sides[i] / (sides[i] - sides[j])
        for i, j in ((0, 1), (1, 2), (2, 0))
        if (sides[i] < 0) != (sides[j] < 0)
    ]
    if len(ends) == 2:
        section.plot([ends[0][0], ends[1][0]], [ends[0][2], ends[1][2]], "C0", linewidth=1)
near = np.abs(positions[:, 2] - middle) < dx / 2
section.plot(positions[near, 0], positions[near, 1], ".", color="grey", markersize=3)
section.set(aspect="equal", title="section, with the particles near it")
picture = sys.argv[2] if len(sys.argv) > 2 else "one_frame.png"
figure.savefig(picture, dpi=120)
print(picture)
