"""Small solids that the tests write in every format."""

from __future__ import annotations

import struct

import numpy as np

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
QUADS = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


class Box:
    """An axis-aligned box: 8 vertices, 6 quads or 12 triangles, outward."""

    def __init__(self, low=(0, 0, 0), size=(1, 1, 1)):
        self.vertices = np.array(low) + CORNERS * np.array(size)
        self.quads = QUADS
        self.faces = np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])

    def stl(self, count=None):
        corners = self.vertices[self.faces].astype("<f4")
        records = b"".join(struct.pack("<3f", 0, 0, 0) + c.tobytes() + b"\0\0" for c in corners)
        return b"\0" * 80 + struct.pack("<I", len(corners) if count is None else count) + records

    def solid(self, name):
        lines = [f"solid {name}"]
        for corners in self.vertices[self.faces]:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += [f"vertex {x} {y} {z}" for x, y, z in corners] + ["endloop", "endfacet"]
        return "\n".join([*lines, f"endsolid {name}", ""])

    def ply(self, kind="binary_little_endian", count=None, labels=None):
        header = [
            "ply",
            f"format {kind} 1.0",
            "comment made for a test",
            f"element vertex {len(self.vertices)}",
            *(f"property float {axis}" for axis in "xyz"),
            f"element face {len(self.faces) if count is None else count}",
            "property list uchar int vertex_indices",
            *([] if labels is None else ["property int label"]),
            "end_header",
        ]
        head = ("\n".join(header) + "\n").encode()
        tails = [[] if labels is None else [int(labels[i])] for i in range(len(self.faces))]
        if kind == "ascii":
            rows = [" ".join(map(str, v)) for v in self.vertices]
            rows += [" ".join(map(str, (3, *f, *t))) for f, t in zip(self.faces, tails, strict=True)]
            return head + ("\n".join(rows) + "\n").encode()
        order = "<" if kind == "binary_little_endian" else ">"
        body = self.vertices.astype(order + "f4").tobytes()
        for face, tail in zip(self.faces, tails, strict=True):
            body += struct.pack(f"{order}B{3 + len(tail)}i", 3, *face, *tail)
        return head + body

    def off(self):
        rows = ["OFF", "# made for a test", "8 6 0"]
        rows += [" ".join(map(str, v)) for v in self.vertices]
        rows += [" ".join(map(str, (4, *q))) for q in self.quads]
        return "\n".join(rows) + "\n"

    def obj(self, start=0):
        rows = [f"v {x} {y} {z}" for x, y, z in self.vertices]
        return "\n".join([*rows, self.obj_faces(start)])

    def obj_faces(self, start=0):
        return "\n".join("f " + " ".join(str(i + start + 1) for i in q) for q in self.quads) + "\n"


def volume(part):
    """Signed volume of a closed part: positive when its faces look outwards."""
    a, b, c = part.vertices[part.faces].transpose(1, 0, 2)
    return float((a * np.cross(b, c)).sum()) / 6
