# SPDX-License-Identifier: Apache-2.0
"""Reads .ply files. Needs NumPy, but not Blender."""

from dataclasses import dataclass, field
from typing import BinaryIO

import numpy as np

from .geometry import FileError, Geometry, faces_of


@dataclass
class PlyProperty:
    name: str
    type: str  # of NumPy, without byte order
    count_type: str | None = None  # of the length, if the property is a list


@dataclass
class PlyElement:
    name: str
    rows: int
    properties: list[PlyProperty] = field(default_factory=list)


PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}

# A property of an element: a number per row, or, for lists, the lengths of all lists and their numbers end to end.
Column = np.ndarray | tuple[np.ndarray, np.ndarray]


def read_ply(path: str) -> Geometry:
    """Reads the elements vertex and face. Raises FileError."""
    try:
        with open(path, "rb") as file:
            encoding, elements = read_ply_header(file)
            data = file.read()
        if encoding == "ascii":
            data = np.array(data.split()).astype("<f8").tobytes()
        offset, tables = 0, {}
        for element in elements:
            tables[element.name], offset = read_ply_element(element, data, offset, encoding)
        return geometry_of_tables(tables)
    except (OSError, ValueError) as error:
        raise FileError(f"{path}: {getattr(error, 'strerror', None) or error}") from error


def read_ply_header(file: BinaryIO) -> tuple[str, list[PlyElement]]:
    """The encoding ("ascii", "binary_little_endian" or "binary_big_endian") and what the file contains."""
    if file.readline(16).strip() != b"ply":
        raise ValueError("this is not a .ply file: the first line is not 'ply'")
    encoding, elements = "", []
    while (line := file.readline(1 << 16).decode("utf-8", "replace")).strip() != "end_header":
        if not line:
            raise ValueError("the header has no end: there is no line 'end_header'")
        words = line.split()
        try:
            if words[:1] == ["format"]:
                encoding = words[1]
            elif words[:1] == ["element"]:
                elements.append(PlyElement(words[1], int(words[2])))
                if elements[-1].rows < 0:
                    raise ValueError
            elif words[:2] == ["property", "list"]:
                elements[-1].properties.append(PlyProperty(words[4], PLY_TYPES[words[3]], PLY_TYPES[words[2]]))
            elif words[:1] == ["property"]:
                elements[-1].properties.append(PlyProperty(words[2], PLY_TYPES[words[1]]))
        except (IndexError, KeyError, ValueError):
            raise ValueError(f"cannot understand the line '{line.strip()}' of the header") from None
    if encoding not in ("ascii", "binary_little_endian", "binary_big_endian"):
        raise ValueError(f"the format is '{encoding}'; expected ascii, binary_little_endian or binary_big_endian")
    return encoding, elements


def read_ply_element(element: PlyElement, data: bytes, offset: int, encoding: str) -> tuple[dict[str, Column], int]:
    """All rows of an element, which begins at the byte `offset`, and the offset of the next one."""

    def stored(number_type: str) -> str:  # numbers of ASCII files have been converted to double precision
        return "<f8" if encoding == "ascii" else ("<" if encoding == "binary_little_endian" else ">") + number_type

    def row_type(row_offset: int) -> np.dtype:  # with the lengths that lists have in this row
        fields = []
        for p in element.properties:
            if p.count_type is None:
                fields.append((p.name, stored(p.type)))
                continue
            count_at = row_offset + np.dtype(fields).itemsize
            if count_at + np.dtype(stored(p.count_type)).itemsize > len(data):
                raise ValueError(f"the file ends inside the element '{element.name}'")
            count = int(np.frombuffer(data, stored(p.count_type), 1, count_at)[0])
            if not 0 <= count <= len(data):
                raise ValueError(f"a list '{p.name}' of the element '{element.name}' has the length {count}")
            fields += [("number of " + p.name, stored(p.count_type)), (p.name, stored(p.type), (count,))]
        return np.dtype(fields)

    def rows_at(row_offset: int, dtype: np.dtype, count: int) -> np.ndarray:
        if row_offset + count * dtype.itemsize > len(data):
            raise ValueError(f"the file ends inside the element '{element.name}'")
        return np.frombuffer(data, dtype, count, row_offset) if dtype.itemsize else np.zeros(count, dtype)

    def all_like(dtype: np.dtype) -> bool:
        """True if the lists of all rows have the same length, as in a mesh of triangles."""
        if offset + element.rows * dtype.itemsize > len(data):
            return False
        rows = rows_at(offset, dtype, element.rows)
        return all((rows["number of " + p.name] == rows[p.name].shape[1]).all() for p in lists)

    lists = [p for p in element.properties if p.count_type is not None]
    blocks, end = [], offset
    if element.rows:
        dtype = row_type(offset)
        if not lists or all_like(dtype):
            blocks.append(rows_at(offset, dtype, element.rows))
            end += element.rows * dtype.itemsize
        else:
            for _ in range(element.rows):
                blocks.append(rows_at(end, row_type(end), 1))
                end += blocks[-1].dtype.itemsize

    def column(p: PlyProperty) -> Column:
        if p.count_type is None:
            return concatenated([b[p.name] for b in blocks], p.type)
        counts = concatenated([b["number of " + p.name] for b in blocks], "i4")
        return counts, concatenated([b[p.name].reshape(-1) for b in blocks], p.type)

    return {p.name: column(p) for p in element.properties}, end


def concatenated(arrays: list[np.ndarray], number_type: str) -> np.ndarray:
    return np.concatenate(arrays).astype(number_type) if arrays else np.zeros(0, number_type)


def geometry_of_tables(tables: dict[str, dict[str, Column]]) -> Geometry:
    points = tables.get("vertex", {})
    if not {"x", "y", "z"} <= points.keys():
        raise ValueError("the element 'vertex' has no x, y and z")
    taken = {"x", "y", "z"}

    def vectors(*names: str) -> np.ndarray | None:
        if not set(names) <= points.keys():
            return None
        taken.update(names)
        return np.stack([points[name] for name in names], axis=1).astype(np.float32)

    geometry = Geometry(vectors("x", "y", "z"))
    geometry.velocities = vectors("vx", "vy", "vz")
    if geometry.velocities is None:
        geometry.velocities = vectors("velocity_x", "velocity_y", "velocity_z")
    geometry.normals = vectors("nx", "ny", "nz")
    geometry.point_attributes = grouped({name: c for name, c in points.items() if name not in taken})

    faces = dict(tables.get("face", {}))
    lengths, corners = faces.pop("vertex_indices", None) or faces.pop("vertex_index", None) or (None, None)
    if corners is not None and len(corners):
        faces_of(geometry, lengths, corners)
        geometry.face_attributes = grouped(faces)
    return geometry


def grouped(columns: dict[str, Column]) -> dict[str, np.ndarray]:
    """Joins adjacent properties a_x a_y (a_z a_w), if they are real numbers, to one attribute a. Leaves out lists."""
    attributes: dict[str, np.ndarray] = {}
    names = [name for name, column in columns.items() if not isinstance(column, tuple)]
    while names:
        stem = names[0].removesuffix("_x")
        size = 0
        while size < min(4, len(names)) and names[size] == f"{stem}_{'xyzw'[size]}":
            size += 1
        if size < 2 or any(columns[name].dtype.kind != "f" for name in names[:size]):
            stem, size = names[0], 1
        parts = [columns[name] for name in names[:size]]
        attributes[stem] = parts[0] if size == 1 else np.stack(parts, axis=1)
        del names[:size]
    return attributes
