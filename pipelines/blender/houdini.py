# SPDX-License-Identifier: Apache-2.0
"""Reads polygons in .bgeo files of Houdini 12 and later, which betamesh writes. Needs NumPy, but not Blender.

A .bgeo file is JSON in a binary encoding. Other primitives than polygons, and .bgeo.sc files, are refused.
"""

import gzip
import zlib
from typing import Any

import numpy as np

from .geometry import FileError, Geometry, columns_of, faces_of

MAGIC = {b"\x7fNSJb": "<", b"\x7fbJSN": ">"}  # and the order of bytes
NUMBERS = {0x11: "i1", 0x12: "i2", 0x13: "i4", 0x14: "i8", 0x18: "f2", 0x19: "f4", 0x1A: "f8", 0x21: "u1", 0x22: "u2"}
CONSTANTS = {0x00: None, 0x30: False, 0x31: True}
LENGTHS = {0xF2: "u2", 0xF4: "u4", 0xF8: "i8"}
BOOLEAN, REFERENCE, TEXT, DEFINE, UNDEFINE, UNIFORM, ARRAY, MAP = 0x10, 0x26, 0x27, 0x2B, 0x2D, 0x40, 0x5B, 0x7B
MOST_NESTED = 100


class Json:
    """The values of a file one after the other. Maps are dictionaries, arrays of equal numbers those of NumPy."""

    def __init__(self, data: bytes):
        if data[:5] not in MAGIC:
            raise ValueError("this is not a .bgeo file of Houdini 12 or later. betamesh writes those as .bgeo; the "
                             "older format, .bhclassic, is not read")
        self.data, self.order, self.at, self.strings = data, MAGIC[data[:5]], 5, {}

    def numbers(self, kind: str, count: int) -> np.ndarray:
        values = np.frombuffer(self.data, self.order + kind, count, self.at)
        self.at += values.nbytes
        return values

    def byte(self) -> int:
        return int(self.numbers("u1", 1)[0])

    def length(self) -> int:
        first = self.byte()
        return first if first < 0xF1 else int(self.numbers(LENGTHS[first], 1)[0])

    def text(self) -> str:
        return self.numbers("u1", self.length()).tobytes().decode("utf-8", "replace")

    def next_token(self) -> int:
        while (token := self.byte()) in (DEFINE, UNDEFINE):
            key = self.length()
            self.strings[key] = self.text() if token == DEFINE else ""
        return token

    def value(self, token: int | None = None, depth: int = 0) -> Any:
        token = self.next_token() if token is None else token
        if token in CONSTANTS:
            return CONSTANTS[token]
        if token in NUMBERS:
            return self.numbers(NUMBERS[token], 1)[0]
        if token == BOOLEAN:
            return self.byte() != 0
        if token in (REFERENCE, TEXT):
            return self.strings[self.length()] if token == REFERENCE else self.text()
        if token == UNIFORM:
            kind, count = self.byte(), self.length()
            if kind != BOOLEAN:
                return self.numbers(NUMBERS[kind], count)
            words = self.numbers("u4", (count + 31) // 32).astype("<u4")
            return np.unpackbits(words.view("u1"), bitorder="little")[:count].astype(bool)
        if token not in (ARRAY, MAP) or depth > MOST_NESTED:
            raise ValueError(f"the byte {token:#x} at {self.at - 1} is no value")
        values = []
        while (following := self.next_token()) != token + 2:
            values.append(self.value(following, depth + 1))
        return values if token == ARRAY else pairs(values)


def pairs(values: Any) -> dict[str, Any]:
    """The map that a list of keys and values stands for."""
    return values if isinstance(values, dict) else dict(zip(values[::2], values[1::2]))


def read_bgeo(path: str) -> Geometry:
    """Reads points, polygons and numeric attributes of points and polygons. Raises FileError."""
    try:
        with open(path, "rb") as file:
            data = file.read()
        root = pairs(Json(gzip.decompress(data) if data[:2] == b"\x1f\x8b" else data).value())
        return geometry_of(root)
    except (OSError, EOFError, zlib.error, ValueError) as error:
        raise FileError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    except (KeyError, IndexError, TypeError, AttributeError, RecursionError) as error:
        raise FileError(f"{path}: the file is damaged, or not geometry: {error!r}") from error


def geometry_of(root: dict[str, Any]) -> Geometry:
    attributes = pairs(root["attributes"])
    points = attributes_of(attributes.get("pointattributes", []), int(root["pointcount"]))
    vectors = {name: points.pop(name)[:, :3].astype(np.float32) for name in ("P", "v", "N")
               if name in points and points[name].ndim == 2 and points[name].shape[1] in (3, 4)}
    geometry = Geometry(vectors["P"], vectors.get("v"), vectors.get("N"))
    for name, values in points.items():
        geometry.point_attributes.update(columns_of(name, values))
    points_of_vertices = np.asarray(pairs(pairs(root["topology"])["pointref"])["indices"])
    lengths, corners = polygons_of(root["primitives"], points_of_vertices)
    faces_of(geometry, lengths, corners)
    for name, values in attributes_of(attributes.get("primitiveattributes", []), len(lengths)).items():
        geometry.face_attributes.update(columns_of(name, values))
    return geometry


def attributes_of(listed: list[Any], rows: int) -> dict[str, np.ndarray]:
    """Numeric attributes, n x k. Others, such as text, are left out."""
    found = {}
    for definition, body in listed:
        body = pairs(body)
        if pairs(definition)["type"] != "numeric" or "values" not in body:
            continue
        values = pairs(body["values"])
        size = int(values["size"])
        if "rawpagedata" in values:
            numbers = unpacked(values, rows, size)
        elif "arrays" in values:  # of each component
            numbers = np.stack([np.asarray(column) for column in values["arrays"]], axis=1)
        else:
            numbers = np.asarray(values["tuples"]).reshape(-1, size)
        if numbers.shape != (rows, size):
            raise ValueError(f"the attribute '{pairs(definition)['name']}' has {len(numbers)} rows, expected {rows}")
        found[pairs(definition)["name"]] = numbers
    return found


def unpacked(values: dict[str, Any], rows: int, size: int) -> np.ndarray:
    """Pages of rows: in each, the numbers of one group of components after the other, or one row if all are equal."""
    data, at = np.asarray(values["rawpagedata"]), 0
    page_rows, widths = int(values["pagesize"]), [int(width) for width in values.get("packing", [size])]
    constant = values.get("constantpageflags")
    result = np.zeros((rows, size), data.dtype)
    for page, first in enumerate(range(0, rows, page_rows)):
        count, column = min(page_rows, rows - first), 0
        for group, width in enumerate(widths):
            stored = 1 if constant is not None and len(constant[group]) and constant[group][page] else count
            block = data[at:at + stored * width].reshape(stored, width)
            result[first:first + count, column:column + width] = block
            at, column = at + stored * width, column + width
    return result


def polygons_of(primitives: list[Any], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The number of corners of each polygon, and their points, counter-clockwise seen from outside."""
    lengths, vertices = [np.zeros(0, np.int64)], [np.zeros(0, np.int64)]
    for definition, body in primitives:
        kind = pairs(definition)["type"]
        kind = pairs(definition)["runtype"] if kind == "run" else kind
        if kind in ("p_r", "Polygon_run"):
            body = pairs(body)
            runs = body.get("r_v", body.get("nvertices_rle"))
            sizes = body.get("n_v", body.get("nvertices")) if runs is None else np.repeat(runs[::2], runs[1::2])
            sizes = np.asarray(sizes, np.int64)
            start = int(body.get("s_v", body.get("startvertex", 0)))
            lengths.append(sizes)
            vertices.append(np.arange(start, start + sizes.sum()))
        elif kind == "Poly":
            polygons = [pairs(body)["vertex"]] if pairs(definition)["type"] == "Poly" else [p[0] for p in body]
            lengths.append(np.array([len(p) for p in polygons], np.int64))
            vertices.extend(np.asarray(p, np.int64) for p in polygons)
        else:
            raise ValueError(f"the file contains primitives of the type {kind}. Only polygons can be shown")
    lengths, corners = np.concatenate(lengths), points[np.concatenate(vertices)]
    # Houdini's polygons are clockwise: all corners but the first in the opposite order.
    starts = np.repeat(np.cumsum(lengths) - lengths, lengths)
    within = np.arange(len(corners)) - starts
    return lengths, corners[starts + (np.repeat(lengths, lengths) - within) % np.repeat(lengths, lengths)]
