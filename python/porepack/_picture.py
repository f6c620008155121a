"""Pictures for notebooks: a section through voxels as PNG, without another package."""

from __future__ import annotations

import base64
import struct
import zlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray

# By phase: grain, pore, outside.
COLOURS = ((138, 116, 92), (226, 238, 246), (255, 255, 255))


def png_of(pixels: NDArray[Any]) -> bytes:
    """An array (rows, columns, 3) of bytes as a PNG file."""
    rows, columns, _ = pixels.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    lines = b"".join(b"\0" + pixels[row].tobytes() for row in range(rows))
    header = struct.pack(">IIBBBBB", columns, rows, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(lines)) + chunk(b"IEND", b"")


def section_html(phases: NDArray[Any], text: str) -> str:
    """The plane y = middle of an array [x, y, z] of phases, z up, at most about 240 pixels wide and high, with a text below."""
    import numpy

    step = max(1, max(phases.shape) // 240)
    plane = phases[::step, phases.shape[1] // 2, ::step].T[::-1]
    scale = max(1, 240 // max(plane.shape))
    pixels = numpy.array(COLOURS, dtype=numpy.uint8)[plane].repeat(scale, axis=0).repeat(scale, axis=1)
    data = base64.b64encode(png_of(pixels)).decode()
    return f'<div><img alt="section" src="data:image/png;base64,{data}"/><br/>{text}</div>'
