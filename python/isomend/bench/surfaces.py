"""Meshes of exact surfaces: Delaunay triangulations of the sphere, tori, surfaces of revolution. It needs only numpy."""

import numpy as np


def turn(axis, degrees):
    """Rotation matrix about an axis."""
    axis, angle = np.asarray(axis, float), np.radians(degrees)
    x, y, z = axis / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


# The rotation of all exact surfaces, so that they are not aligned with the grid's axes.
TURN = turn([3, -5, 8], 37)


# --- meshes on the unit sphere --------------------------------------------------------------------------------------


class SphereMesh:
    """Delaunay triangulation of points on the unit sphere, built point by point with Lawson's flips."""

    def __init__(self):
        s = 3**-0.5
        self.points = [(x * s, y * s, z * s) for x, y, z in [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]]
        self.across = {}
        for face in [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]:
            self.add_face(*face)
        self.last = (0, 1)

    def add_face(self, a, b, c):
        self.across[a, b] = c
        self.across[b, c] = a
        self.across[c, a] = b

    def volume(self, i, j, k):
        (a, b, c), (d, e, f), (g, h, m) = i, j, k
        return a * (e * m - f * h) + b * (f * g - d * m) + c * (d * h - e * g)

    def above(self, a, b, c, p):
        """Whether p lies above the plane of a, b and c."""
        a, b, c = (tuple(x - y for x, y in zip(self.points[q], p)) for q in (a, b, c))
        return self.volume(a, b, c) < -1e-12

    def locate(self, p):
        """Walks to the face that contains p."""
        a, b = self.last
        while True:
            c = self.across[a, b]
            for i, j in ((a, b), (b, c), (c, a)):
                if self.volume(self.points[i], self.points[j], p) < 0:
                    a, b = j, i
                    break
            else:
                return a, b, c

    def insert(self, p):
        new = len(self.points)
        a, b, c = self.locate(p)
        self.points.append(p)
        stack = [(a, b), (b, c), (c, a)]
        for i, j in stack:
            self.add_face(i, j, new)
        while stack:
            i, j = stack.pop()
            far = self.across[j, i]
            if self.above(i, j, new, self.points[far]):
                del self.across[i, j], self.across[j, i]
                self.add_face(i, far, new)
                self.add_face(far, j, new)
                stack += [(i, far), (far, j)]
        self.last = (a, new)

    def arrays(self):
        faces = [(a, b, c) for (a, b), c in self.across.items() if a < b and a < c]
        return np.array(self.points), np.array(sorted(faces))


def scattered(count, density, rng):
    """Uneven points on the sphere, in a spatially coherent order: random points with a smallest distance of 0.62 of the mean spacing, over
    the square root of the density."""
    mean = (4 * np.pi / count) ** 0.5
    cells, kept = {}, []
    while len(kept) < count:
        drawn = rng.normal(size=(count, 3))
        drawn /= np.linalg.norm(drawn, axis=1)[:, None]
        gaps = 0.62 * mean / np.sqrt(density(drawn))
        for p, gap in zip(drawn.tolist(), gaps.tolist()):
            x, y, z = p
            i, j, k = (int(c // mean) for c in p)
            reach = range(-int(-(-gap // mean)), int(-(-gap // mean)) + 1)
            near = (q for a in reach for b in reach for c in reach for q in cells.get((i + a, j + b, k + c), ()))
            if all((x - q[0]) ** 2 + (y - q[1]) ** 2 + (z - q[2]) ** 2 > gap * gap for q in near):
                cells.setdefault((i, j, k), []).append(p)
                kept.append(p)
    kept = np.array(kept[:count])
    stripe = np.floor((kept[:, 2] + 1) * 12).astype(int)
    return kept[np.lexsort((np.arctan2(kept[:, 1], kept[:, 0]), stripe))]


def sphere_mesh(count, seed, density=lambda d: np.ones(len(d))):
    mesh = SphereMesh()
    for p in scattered(count, density, np.random.default_rng(seed)).tolist():
        mesh.insert(tuple(p))
    return mesh.arrays()


# --- cutting --------------------------------------------------------------------------------------------------------


def cut(vertices, faces, removed):
    """Removes faces, and vertices that no remaining face uses."""
    faces = faces[~removed]
    used = np.unique(faces)
    number = np.full(len(vertices), -1)
    number[used] = np.arange(len(used))
    return vertices[used], number[faces]


def components(faces):
    """The connected component of each face, by the index of one of its faces. Faces are connected through edges."""
    owner = {}
    parent = np.arange(len(faces))

    def root(f):
        while parent[f] != f:
            parent[f] = parent[parent[f]]
            f = parent[f]
        return f

    for f, (a, b, c) in enumerate(faces):
        for edge in ((a, b), (b, c), (c, a)):
            key = min(edge), max(edge)
            if key in owner:
                parent[root(f)] = root(owner[key])
            owner[key] = f
    return np.array([root(f) for f in range(len(faces))])


# --- analytic shapes ------------------------------------------------------------------------------------------------

BIG = np.sqrt(2)  # major radius of the torus; the minor radius is 1
JOIN = 0.8  # height at which the catenoid of the dumb-bell meets its balls, over the radius of the catenoid's waist


def torus(around, across):
    """The Clifford torus with radii sqrt(2) and 1."""
    v, f = [], []
    for i in range(around):
        for j in range(across):
            u, w = 2 * np.pi * (i + 0.5 * (j % 2)) / around, 2 * np.pi * j / across
            v.append([(BIG + np.cos(w)) * np.cos(u), (BIG + np.cos(w)) * np.sin(u), np.sin(w)])
            at = lambda a, b: (i + a) % around * across + (j + b) % across  # noqa: B023, E731
            if j % 2 == 0:
                f += [[at(0, 0), at(1, 0), at(0, 1)], [at(1, 0), at(1, 1), at(0, 1)]]
            else:
                f += [[at(0, 0), at(1, 1), at(0, 1)], [at(0, 0), at(1, 0), at(1, 1)]]
    return np.array(v), np.array(f)


def revolve(profile, spacing):
    """A surface of revolution about z: for each point (r, z) of the profile a ring of vertices about `spacing` apart, or a single vertex
    where r is 0."""
    v, f, ring = [], [], []
    for k, (r, z) in enumerate(profile):
        n = 1 if r < 1e-9 else max(6, round(2 * np.pi * r / spacing))
        angle = 2 * np.pi * (np.arange(n) + 0.5 * (k % 2)) / n
        ring.append((len(v), n, angle[0]))
        v += [[r * np.cos(a), r * np.sin(a), z] for a in angle]
    for (s, n, a0), (t, m, b0) in zip(ring, ring[1:]):
        i = j = 0
        while i < n * (n > 1) or j < m * (m > 1):
            lower, upper = s + i % n, t + j % m
            next_a, next_b = a0 + 2 * np.pi * (i + 1) / n, b0 + 2 * np.pi * (j + 1) / m
            if j >= m * (m > 1) or (i < n * (n > 1) and next_a <= next_b):
                f.append([lower, s + (i + 1) % n, upper])
                i += 1
            else:
                f.append([lower, t + (j + 1) % m, upper])
                j += 1
    return np.array(v), np.array(f)


def dumb_bell(spacing):
    """A dumb-bell: two balls joined by a catenoid, closed."""
    ball = np.cosh(JOIN) ** 2
    centre = JOIN + np.cosh(JOIN) * np.sinh(JOIN)
    start = np.arccos(-np.tanh(JOIN))
    arc = np.linspace(start, 0, round(ball * start / (0.87 * spacing)) + 1)[1:]
    half = np.arcsinh(np.linspace(0, np.sinh(JOIN), round(np.sinh(JOIN) / (0.87 * spacing)) + 1))
    neck = np.concatenate([-half[:0:-1], half])
    profile = [(ball * np.sin(a), -centre - ball * np.cos(a)) for a in arc[::-1]] + [(np.cosh(z), z) for z in neck]
    profile += [(ball * np.sin(a), centre + ball * np.cos(a)) for a in arc]
    return revolve(profile, spacing)
