"""Writes an arm whose links have meshes, for the page of a motion: a URDF of `cr7 robots --urdf`, and spheres as STL files.

    cr7 robots --urdf ur5e | python3 mesh_arm.py FOLDER
"""

import math
import re
import struct
import sys
from pathlib import Path

FINE = 60


def sphere(radius):
    """Triangles of a sphere that is drawn out along z, in m."""
    def place(i, k):
        u, v = math.pi * i / FINE, 2 * math.pi * k / FINE
        return radius * math.sin(u) * math.cos(v), radius * math.sin(u) * math.sin(v), 1.5 * radius * math.cos(u)

    for i in range(FINE):
        for k in range(FINE):
            yield place(i, k), place(i + 1, k), place(i + 1, k + 1)
            yield place(i, k), place(i + 1, k + 1), place(i, k + 1)


def binary(triangles):
    triangles = list(triangles)
    body = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for corner in t for v in corner), 0) for t in triangles)
    return bytes(80) + struct.pack("<I", len(triangles)) + body


def text(triangles):
    lines = ["solid a link"]
    for corners in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x:e} {y:e} {z:e}" for x, y, z in corners), "endloop", "endfacet"]
    return "\n".join([*lines, "endsolid a link", ""]).encode()


def main(folder):
    folder = Path(folder)
    (folder / "meshes").mkdir(parents=True, exist_ok=True)
    urdf, count = sys.stdin.read(), 0

    def with_visual(link):
        nonlocal count
        count += 1
        write = text if count == 1 else binary
        (folder / f"meshes/{count}.stl").write_bytes(write(sphere(0.11 - 0.01 * count)))
        mesh = f'<mesh filename="package://arm/meshes/{count}.stl"/>'
        return f"{link[0]}<visual><geometry>{mesh}</geometry></visual>"

    urdf = re.sub(r'<link name="[^"]*">', with_visual, urdf)
    assert count >= 6, urdf
    (folder / "arm.urdf").write_text(urdf, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
