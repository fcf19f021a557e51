# SPDX-License-Identifier: Apache-2.0
"""What the readers of this folder make of a file. Needs NumPy, but not Blender."""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Geometry:
    """A mesh as its file stores it: n points, m faces with their corners one face after the other."""

    positions: np.ndarray  # n x 3
    velocities: np.ndarray | None = None  # n x 3, units per second
    normals: np.ndarray | None = None  # n x 3
    corners: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # index of a point
    face_starts: np.ndarray = field(default_factory=lambda: np.zeros(0, np.int32))  # m, index of its first corner
    point_attributes: dict[str, np.ndarray] = field(default_factory=dict)  # n or n x k
    face_attributes: dict[str, np.ndarray] = field(default_factory=dict)  # m or m x k


class FileError(Exception):
    """A file that cannot be read. The message begins with its path."""


def faces_of(geometry: Geometry, lengths: np.ndarray, corners: np.ndarray) -> None:
    """Sets the faces: their numbers of corners, and the points at the corners. Raises ValueError."""
    if not len(corners):
        return
    count = len(geometry.positions)
    for corner in (corners.min(), corners.max()):
        if not 0 <= corner < count:
            raise ValueError(f"a face refers to the vertex {corner}; there are {count}, the first is 0")
    if lengths.min() < 3:
        raise ValueError(f"a face has {lengths.min()} corners")
    geometry.corners = corners.astype(np.int32)
    geometry.face_starts = (np.cumsum(lengths) - lengths).astype(np.int32)


def columns_of(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
    """An attribute as Blender can store it: one number, or two to four real numbers. Others become one per number."""
    if values.ndim == 1 or values.dtype.kind == "f" and 2 <= values.shape[1] <= 4:
        return {name: values}
    if values.shape[1] == 1:
        return {name: values[:, 0]}
    return {f"{name}_{i}": values[:, i] for i in range(values.shape[1])}
