# SPDX-License-Identifier: Apache-2.0
"""Reads polygons in .vtp files, which VTK, ParaView and betamesh write. Needs NumPy, but not Blender.

Arrays may be text, base64 or raw bytes, compressed by zlib or not. Files of several pieces, and strips, are refused.
"""

import base64
import re
import zlib
from xml.etree import ElementTree

import numpy as np

from .geometry import FileError, Geometry, columns_of, faces_of

TYPES = {"Int8": "i1", "UInt8": "u1", "Int16": "i2", "UInt16": "u2", "Int32": "i4", "UInt32": "u4", "Int64": "i8",
         "UInt64": "u8", "Float32": "f4", "Float64": "f8"}
VELOCITIES = ("velocity", "velocities", "v", "vel")


def read_vtp(path: str) -> Geometry:
    """Reads points, polygons and the attributes of both. Raises FileError."""
    try:
        with open(path, "rb") as file:
            return VtpFile(file.read()).geometry()
    except (OSError, ValueError, zlib.error) as error:
        raise FileError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    except (ElementTree.ParseError, KeyError, IndexError, TypeError, AttributeError) as error:
        raise FileError(f"{path}: the file is damaged, or no .vtp file: {error!r}") from error


class VtpFile:
    def __init__(self, data: bytes):
        # Raw bytes are no XML: they follow the first underscore of AppendedData.
        appended = re.search(rb"<AppendedData[^>]*>\s*_", data)
        self.appended = data[appended.end():] if appended else b""
        self.is_raw = bool(appended) and b"base64" not in appended[0]
        text = data[:appended.start()] + b"</VTKFile>" if appended else data
        root = ElementTree.fromstring(text)
        if root.get("type") != "PolyData":
            raise ValueError(f"the file contains {root.get('type')}; expected PolyData")
        self.order = ">" if root.get("byte_order") == "BigEndian" else "<"
        self.header = np.dtype(self.order + TYPES[root.get("header_type", "UInt32")])
        self.compressor = root.get("compressor")
        if self.compressor not in (None, "vtkZLibDataCompressor"):
            raise ValueError(f"the file is compressed by {self.compressor}; expected vtkZLibDataCompressor")
        pieces = root.findall("PolyData/Piece")
        if len(pieces) != 1:
            raise ValueError(f"the file has {len(pieces)} pieces; expected one")
        self.piece = pieces[0]

    def count(self, what: str) -> int:
        return int(self.piece.get("NumberOf" + what, "0"))

    def geometry(self) -> Geometry:
        if self.count("Strips"):
            raise ValueError("the file contains strips of triangles; expected polygons")
        points = self.arrays("PointData")
        vectors = {name: values for name, values in points.items() if values.ndim == 2 and values.shape[1] == 3}
        geometry = Geometry(self.array(self.piece.find("Points/DataArray")).astype(np.float32))
        velocity = next((name for name in VELOCITIES if name in vectors), None)
        normals = next((name for name in ("Normals", "N") if name in vectors), None)
        geometry.velocities = points.pop(velocity).astype(np.float32) if velocity else None
        geometry.normals = points.pop(normals).astype(np.float32) if normals else None
        for name, values in points.items():
            geometry.point_attributes.update(columns_of(name, values))
        if not self.count("Polys"):
            return geometry
        cells = self.arrays("Polys")
        ends = cells["offsets"].astype(np.int64)
        faces_of(geometry, np.diff(ends, prepend=0), cells["connectivity"])
        before = self.count("Verts") + self.count("Lines")  # cells of these kinds come first
        for name, values in self.arrays("CellData").items():
            geometry.face_attributes.update(columns_of(name, values[before:]))
        return geometry

    def arrays(self, section: str) -> dict[str, np.ndarray]:
        """The numeric arrays of a section by name."""
        found = self.piece.findall(section + "/DataArray")
        return {array.get("Name"): self.array(array) for array in found if array.get("type") in TYPES}

    def array(self, element: ElementTree.Element) -> np.ndarray:
        """n numbers, or n x k."""
        kind = self.order + TYPES[element.get("type")]
        form, components = element.get("format"), int(element.get("NumberOfComponents", "1"))
        if form == "ascii":
            values = np.array((element.text or "").split(), dtype=kind)
        elif form == "appended":
            values = np.frombuffer(self.bytes_at(self.appended[int(element.get("offset")):], self.is_raw), kind)
        else:
            values = np.frombuffer(self.bytes_at((element.text or "").strip().encode(), False), kind)
        return values if components == 1 else values.reshape(-1, components)

    def bytes_at(self, data: bytes, is_raw: bool) -> bytes:
        """The bytes of an array, behind their length or, compressed, the lengths of their blocks."""
        size = self.header.itemsize

        def taken(at: int, count: int) -> tuple[bytes, int]:
            """`count` bytes of a part of its own, which begins at the character `at`, and where the next one begins."""
            if is_raw:
                if at + count > len(data):
                    raise ValueError("the file ends inside an array")
                return data[at:at + count], at + count
            end = at + 4 * ((count + 2) // 3)
            return base64.b64decode(data[at:end])[:count], end

        if not self.compressor:
            if is_raw:
                return taken(size, int(np.frombuffer(data, self.header, 1)[0]))[0]
            count = int(np.frombuffer(taken(0, size)[0], self.header)[0])  # one part with the numbers
            return taken(0, size + count)[0][size:]
        blocks = int(np.frombuffer(taken(0, size)[0], self.header)[0])
        lengths, at = taken(0, (3 + blocks) * size)
        sizes = np.frombuffer(lengths, self.header)[3:].astype(int)
        packed, _ = taken(at, int(sizes.sum()))
        ends = np.cumsum(sizes)
        return b"".join(zlib.decompress(packed[end - size:end]) for size, end in zip(sizes, ends))
