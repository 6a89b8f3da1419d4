"""Meshes for the tests of the page: a large ball with holes, a textured ball as GLB, a cube with holes, a body that is
symmetric but for what is missing."""

import json
import struct
import zlib

import numpy as np


def ball(rings, bumps, holes):
    """A bumpy ball with holes, of about 4 rings² triangles: vertices, faces, angles. Holes are cut by balls."""
    across = 2 * rings
    down, round_ = np.linspace(0, np.pi, rings + 1)[1:-1], np.arange(across) * 2 * np.pi / across
    a, b = (x.ravel() for x in np.meshgrid(down, round_, indexing="ij"))
    r = 50 + bumps * np.sin(9 * a) * np.sin(7 * b) * np.sin(a) ** 2
    vertices = np.concatenate([np.stack([r * np.sin(a) * np.cos(b), r * np.sin(a) * np.sin(b), r * np.cos(a)], -1), [[0, 0, 50], [0, 0, -50]]])
    at = np.arange((rings - 2) * across).reshape(rings - 2, across)
    side = np.roll(at, -1, 1)
    quads = np.stack([at, at + across, side, side, at + across, side + across], -1).reshape(-1, 3)
    turn = np.arange(across)
    after, last, pole = np.roll(turn, -1), (rings - 2) * across, len(vertices) - 2
    caps = [np.stack([np.full(across, pole), turn, after], -1), np.stack([np.full(across, pole + 1), last + after, last + turn], -1)]
    faces = np.concatenate([quads, *caps])
    middles = vertices[faces].mean(1)
    for centre, radius in holes:
        faces = faces[np.linalg.norm(middles - centre, axis=1) > radius]
        middles = vertices[faces].mean(1)
    used = np.unique(faces)
    number = np.zeros(len(vertices), int)
    number[used] = np.arange(len(used))
    return vertices[used], number[faces]


def bumpy_ball(path, rings):
    """Writes a ball with three holes as a binary PLY; returns its number of faces."""
    vertices, faces = ball(rings, 3, (((0, -50, 5), 6), ((35, -30, 15), 4), ((0, 40, 30), 3)))
    write_ply(path, vertices, faces)
    return len(faces)


def write_ply(path, vertices, faces):
    """Writes a binary PLY with coordinates as 32-bit floats."""
    rows = np.zeros(len(faces), [("n", "u1"), ("v", "<u4", 3)])
    rows["n"], rows["v"] = 3, faces
    header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\nproperty list uchar uint vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + vertices.astype("<f4").tobytes() + rows.tobytes())


def open_cube(path):
    """Writes a cube of 12 squares along each side as a binary PLY, with a hole across an edge and another over a corner."""
    at, faces = {}, []
    for side in range(6):
        axes = [(side + k) % 3 for k in range(3)]
        for u, v in np.ndindex(12, 12):
            corners = []
            for i, j in ((u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)):
                place = [0, 0, 0]
                place[axes[0]], place[axes[1]], place[axes[2]] = 12 * (side < 3), i, j
                corners.append(at.setdefault(tuple(place), len(at)))
            a, b, c, d = corners if side < 3 else corners[::-1]
            faces += [[a, b, c], [a, c, d]]
    vertices, faces = np.array(list(at), float), np.array(faces)
    for centre, radius in (((6, 0, 12), 3.2), ((12, 12, 0), 2.8)):
        faces = faces[np.linalg.norm(vertices[faces].mean(1) - centre, axis=1) > radius]
    write_ply(path, vertices, faces)


def png(pixels):
    """The bytes of a PNG file of 8-bit RGB pixels."""
    height, width, _ = pixels.shape
    rows = np.concatenate([np.zeros((height, 1), "u1"), pixels.reshape(height, -1)], 1)
    chunks = ((b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(rows.tobytes())), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks)


def textured_glb(path):
    """Writes a ball with four holes and a striped texture, with a seam where the texture coordinates jump."""
    vertices, faces = ball(40, 1.5, (((0, -50, 5), 14), ((30, -36, -22), 11), ((-30, -36, 12), 8), ((30, -36, 25), 7)))
    u = np.arctan2(vertices[:, 1], vertices[:, 0]) / (2 * np.pi) % 1
    v = np.arccos(np.clip(vertices[:, 2] / np.linalg.norm(vertices, axis=1), -1, 1)) / np.pi
    corners = u[faces]
    crossing = corners.max(1) - corners.min(1) > 0.5
    # Faces across the seam get separate vertices for their corners left of it, with the texture coordinate increased by one turn.
    extra = np.unique(faces[crossing][corners[crossing] < 0.5])
    number = {int(old): len(vertices) + i for i, old in enumerate(extra)}
    faces = faces.copy()
    for face in np.flatnonzero(crossing):
        faces[face] = [number[int(x)] if u[x] < 0.5 else x for x in faces[face]]
    vertices, u, v = np.concatenate([vertices, vertices[extra]]), np.concatenate([u, u[extra] + 1]), np.concatenate([v, v[extra]])
    pixels = (np.indices((256, 256)).sum(0) // 32 % 2)[..., None] * np.array([90, 60, 20]) + np.array([140, 150, 120])
    parts = [vertices.astype("<f4").tobytes(), np.stack([u, v], -1).astype("<f4").tobytes(), faces.astype("<u4").tobytes(), png(pixels.astype("u1"))]
    views, blob = [], b""
    for part in parts:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(part)})
        blob += part + b"\0" * (-len(part) % 4)
    low, high = vertices.astype("<f4").min(0).tolist(), vertices.astype("<f4").max(0).tolist()
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "buffers": [{"byteLength": len(blob)}], "bufferViews": views,
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3", "min": low, "max": high},
                      {"bufferView": 1, "componentType": 5126, "count": len(vertices), "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5125, "count": faces.size, "type": "SCALAR"}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    path.write_bytes(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(blob), len(text), 0x4E4F534A) + text + struct.pack("<II", len(blob), 0x4E4942) + blob)


def bust(path):
    """Writes an ellipsoid with bumps on both sides of x = 0 and one on one side, without the faces at one bump, as a binary PLY; beside it
    `cast.ply`, the whole of it, shifted. Both halves of the ellipsoid have the same triangles."""
    vertices, faces = ball(60, 0, ())
    at = vertices / 50
    height = sum(h * np.exp(-(np.linalg.norm(at - np.array(p), axis=1) / 0.16) ** 2)[:, None]
                 for p, h in (((0.69, 0.4, 0.6), 0.16), ((-0.69, 0.4, 0.6), 0.16), ((0, 0.1, 1), 0.1), ((-0.78, -0.6, -0.2), 0.25)))
    vertices = 50 * (at * (1, 1.3, 0.9) + at * height)
    write_ply(path.with_name("cast.ply"), vertices + (4, 0, 0), faces)
    faces = faces[np.linalg.norm(at[faces].mean(1) - (0.69, 0.4, 0.6), axis=1) > 0.3]
    used = np.unique(faces)
    number = np.zeros(len(vertices), int)
    number[used] = np.arange(len(used))
    write_ply(path, vertices[used], number[faces])
