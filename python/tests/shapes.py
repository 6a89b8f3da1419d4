"""Test meshes, and checks of their topology."""

import numpy as np


def open_sphere(around=48, latitudes=24, top=5, dtype=np.float64):
    """A ball of radius 1 without the rings near its top."""
    heights = [np.pi * i / latitudes - np.pi / 2 for i in range(1, latitudes - top)]
    angles = 2 * np.pi * np.arange(around) / around
    vertices = [(0.0, 0.0, -1.0)]
    for i, height in enumerate(heights):
        turned = angles + np.pi * (i % 2) / around
        for angle in turned:
            vertices.append((np.cos(height) * np.cos(angle), np.cos(height) * np.sin(angle), np.sin(height)))
    at = lambda ring, i: 1 + ring * around + i % around  # noqa: E731
    faces = [(0, at(0, i + 1), at(0, i)) for i in range(around)]
    for ring in range(len(heights) - 1):
        for i in range(around):
            low, high = ring, ring + 1
            if ring % 2 == 0:
                faces += [(at(low, i), at(low, i + 1), at(high, i)), (at(low, i + 1), at(high, i + 1), at(high, i))]
            else:
                faces += [(at(low, i), at(low, i + 1), at(high, i + 1)), (at(low, i), at(high, i + 1), at(high, i))]
    return np.array(vertices, dtype), np.array(faces)


def open_ends(**options):
    """The open sphere with a hole at the bottom too."""
    vertices, faces = open_sphere(**options)
    return vertices, faces[(faces != 0).all(axis=1)]


def closed_sphere():
    """A closed ball of radius 1."""
    vertices, faces = open_sphere(top=0)
    around = 48
    ring = len(vertices) - around
    cap = [(ring + i, ring + (i + 1) % around, len(vertices)) for i in range(around)]
    return np.vstack([vertices, [(0.0, 0.0, 1.0)]]), np.vstack([faces, cap])


def edges_of(faces):
    """The set of directed edges of the faces, and the number of edges with repetitions."""
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return {tuple(pair) for pair in pairs.tolist()}, len(pairs)


def is_closed(faces):
    """Whether each edge is used exactly once in each direction."""
    edges, count = edges_of(faces)
    return len(edges) == count and all((b, a) in edges for a, b in edges)


def open_cube():
    """A cube of 12 squares along each side, with a hole across an edge."""
    at, faces = {}, []
    for side in range(6):
        for u, v in np.ndindex(12, 12):
            corners = []
            for i, j in ((u, v), (u + 1, v), (u + 1, v + 1), (u, v + 1)):
                place = [0, 0, 0]
                place[side % 3], place[(side + 1) % 3], place[(side + 2) % 3] = 12 * (side < 3), i, j
                corners.append(at.setdefault(tuple(place), len(at)))
            a, b, c, d = corners if side < 3 else corners[::-1]
            faces += [(a, b, c), (a, c, d)]
    vertices, faces = np.array(list(at), float), np.array(faces)
    middles = vertices[faces].mean(axis=1)
    return vertices, faces[np.linalg.norm(middles - (6, 0, 12), axis=1) > 3.2]
