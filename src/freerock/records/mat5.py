"""MATLAB files v5 to v7: numeric matrices, as "MAT-File Format" (The MathWorks) lays them out.

Damaged bytes can end SciPy's compiled reader of these versions in a segmentation fault, hence this one.
"""

import struct
import zlib
from dataclasses import dataclass
from io import BufferedReader
from math import prod
from pathlib import Path

import numpy as np

from freerock.arrays import Floats

HEADER = 128
CHUNK = 1 << 20
HEAD = 1024  # bytes of a matrix that hold its flags, size and name
ORDERS = {b"IM": "<", b"MI": ">"}
MATRIX, COMPRESSED = 14, 15
NUMERIC_CLASSES = range(6, 16)  # double, single and the integers
COMPLEX = 0x0800
Bytes = bytes | memoryview
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}


@dataclass(frozen=True)
class Matrix:
    """A real matrix: its shape and where its element begins in the file."""

    path: Path
    order: str
    kind: int
    start: int
    length: int
    shape: tuple[int, int]

    def read(self) -> Floats:
        """The matrix as doubles.

        Raises
        ------
        ValueError
            Damaged data.
        """
        with open(self.path, "rb") as file:
            file.seek(self.start)
            if self.kind == COMPRESSED:
                body = memoryview(_decompressed(file, self.length, 8 * prod(self.shape) + HEAD))[8:]
            else:
                packed = bytearray(self.length)
                body = memoryview(packed)[: file.readinto(packed)]
        at = 0
        for _ in range(3):
            _, _, at = _element(body, at, self.order)
        kind, data, _ = _element(body, at, self.order)
        values = np.frombuffer(data, self.order + TYPES[kind])
        return values.astype(float, copy=False).reshape(self.shape, order="F")


def _decompressed(file: BufferedReader, length: int, most: int) -> bytearray:
    """The data of a compressed element, part by part; ValueError where they don't end by `most` bytes."""
    stream, found, left = zlib.decompressobj(), bytearray(), length
    while not stream.eof:
        packed = stream.unconsumed_tail or file.read(min(CHUNK, left))
        left -= 0 if stream.unconsumed_tail else len(packed)
        found += stream.decompress(packed, CHUNK)
        if len(found) > most or not packed:
            raise ValueError("compressed data that don't end")
    return found


def matrices(path: Path) -> dict[str, Matrix]:
    """The real matrices of a file by name, without their data; anything else is passed over.

    Raises
    ------
    ValueError, KeyError, struct.error, zlib.error
        A truncated or damaged file.
    """
    found = {}
    size = path.stat().st_size
    with open(path, "rb") as file:
        order = ORDERS[file.read(HEADER)[-2:]]
        start = HEADER
        while start < size:
            file.seek(start)
            kind, length = struct.unpack(f"{order}II", file.read(8))
            start += 8
            if start + length > size:
                raise ValueError(f"the element at byte {start} ends beyond the file")
            head = file.read(min(length, HEAD))
            inner = kind
            if kind == COMPRESSED:
                head = zlib.decompressobj().decompress(head, HEAD)
                inner, _ = struct.unpack(f"{order}II", head[:8])
                head = head[8:]
            if inner == MATRIX:
                name, shape = _described(head, order)
                if shape:
                    found[name] = Matrix(path, order, kind, start, length, shape)
            start += length
    return found


def _described(head: bytes, order: str) -> tuple[str, tuple[int, int] | None]:
    """Name and shape of a real matrix; no shape for other arrays, or MATLAB's own without a name."""
    _, flags, at = _element(head, 0, order)
    (flags,) = struct.unpack_from(f"{order}I", flags)
    if flags & 0xFF not in NUMERIC_CLASSES or flags & COMPLEX:
        return "", None
    _, sizes, at = _element(head, at, order)
    _, name, _ = _element(head, at, order)
    shape = struct.unpack(f"{order}{len(sizes) // 4}i", sizes)
    if min(shape) < 0:
        raise ValueError(f"a matrix of size {shape}")
    return bytes(name).decode("ascii"), (shape[0], shape[1]) if name and len(shape) == 2 else None


def _element(data: Bytes, at: int, order: str) -> tuple[int, Bytes, int]:
    """Type, data and end of an element; one of up to four bytes is packed into its tag."""
    kind, length = struct.unpack_from(f"{order}II", data, at)
    if kind >> 16:
        kind, length = kind & 0xFFFF, kind >> 16
        start, end = at + 4, at + 8
    else:
        start = at + 8
        end = start + length + -length % 8
    if start + length > len(data):
        raise ValueError(f"the element at byte {at} of a matrix ends beyond it")
    return kind, data[start : start + length], end
