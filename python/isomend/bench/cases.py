"""Test cases: holes whose true surface is known, in exact surfaces, in real meshes, and in solids with sharp edges. They need only numpy;
the real meshes come from the package pymeshlab."""

import re
from pathlib import Path

import numpy as np

from . import surfaces

NECK = 0.55  # half the height of the catenoid's part that is cut out, over the radius of its waist
ELLIPSOID = np.array([1.0, 0.7, 0.5])  # semi-axes

# --- exact surfaces: nearest points and unit normals ----------------------------------------------------------------


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=1, keepdims=True), 1e-300)


def on_sphere(p):
    return unit(p), unit(p)


def on_torus(p):
    ring = unit(p * [1, 1, 0]) * surfaces.BIG
    return ring + unit(p - ring), unit(p - ring)


def on_ellipsoid(p):
    squares = ELLIPSOID**2
    low = np.full(len(p), -squares.min() * (1 - 1e-9))
    high = np.linalg.norm(p, axis=1) + 1e-9
    for _ in range(80):
        middle = (low + high) / 2
        outside = (squares * p * p / (middle[:, None] + squares) ** 2).sum(axis=1) > 1
        low, high = np.where(outside, middle, low), np.where(outside, high, middle)
    q = squares * p / (low[:, None] + squares)
    return q, unit(q / squares)


def on_catenoid(p):
    r, z = np.hypot(p[:, 0], p[:, 1]), p[:, 2]
    t = np.clip(z, -1.2, 1.2)
    for _ in range(80):
        c, s = np.cosh(t), np.sinh(t)
        t = t - np.clip(((c - r) * s + t - z) / np.maximum(s * s + 1 + (c - r) * c, 0.1), -0.2, 0.2)
    out = unit(p * [1, 1, 0])
    q = out * np.cosh(t)[:, None] + np.outer(t, [0, 0, 1])
    return q, unit(out - np.outer(np.sinh(t), [0, 0, 1]))


class Exact:
    """An exact surface, rotated by `surfaces.TURN`; `project` returns nearest points and normals of the surface before the rotation."""

    def __init__(self, project):
        self.project = project

    def nearest(self, p):
        q, n = self.project(p @ surfaces.TURN)
        return q @ surfaces.TURN.T, n @ surfaces.TURN.T


def vertex_normals(v, f):
    normals = np.zeros_like(v)
    area = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    for k in range(3):
        np.add.at(normals, f[:, k], area)
    return unit(normals)


# --- cases ----------------------------------------------------------------------------------------------------------


class Case:
    """A mesh with a hole (`v`, `f`), the true surface, samples on the part that is missing (`points`), and the mesh before the cut with its
    removed faces (`whole`). `noise` displaces vertices along normals, by this part of the mean edge (standard deviation)."""

    def __init__(self, name, v, f, gone, truth, turned=True, noise=0.0, bridge=False):
        self.name = name
        self.bridge = bridge
        v = v @ surfaces.TURN.T if turned else v
        kept = v
        if noise:
            edge = np.linalg.norm(v[f] - v[np.roll(f, 1, axis=1)], axis=2).mean()
            rng = np.random.default_rng(0)
            kept = v + truth.nearest(v)[1] * rng.normal(scale=noise * edge, size=(len(v), 1))
        kept = kept.astype(np.float32).astype(float)
        self.v, self.f = surfaces.cut(kept, f, gone)
        self.truth = truth
        self.whole = (kept, f, gone)
        missing = surfaces.cut(v, f, ~gone)
        self.points = truth.nearest(spread(*missing, 20_000, np.random.default_rng(1)))[0]
        rim = self.v[np.unique(boundary(self.f))]
        self.diameter = max(np.linalg.norm(rim - p, axis=1).max() for p in rim)


def boundary(f):
    half = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    keys = np.sort(half, axis=1)
    _, number, count = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    return half[count[number.reshape(-1)] == 1]


def spread(v, f, count, rng):
    """Points on the faces, evenly by area."""
    area = np.linalg.norm(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]), axis=1)
    pick = rng.choice(len(f), count, p=area / area.sum())
    a, b = np.sqrt(rng.random(count)), rng.random(count)
    return np.einsum("nk,nkd->nd", np.stack([1 - a, a * (1 - b), a * b], axis=1), v[f[pick]])


def cap(v, f, degrees):
    centre = unit(v[f].mean(axis=1))
    return np.degrees(np.arccos(centre[:, 2])) < degrees


def bunny():
    import pymeshlab

    path = Path(pymeshlab.__file__).parent / "tests/sample_meshes/bunny.obj"
    rows = {"v": [], "f": []}
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] in rows:
            rows[words[0]].append([word.split("/")[0] for word in words[1:4]])
    return np.array(rows["v"], float), np.array(rows["f"], int) - 1


BUNNY = {  # centre of a hole, as parts of the bounding box; its radius over the diagonal
    "back": ((0.72, 0.62, 0.30), 0.06),
    "haunch": ((0.80, 0.25, 0.75), 0.06),
    "chest": ((0.12, 0.35, 0.55), 0.05),
    "ear": ((0.45, 0.95, 0.40), 0.035),
}


def cases(pattern="", truth=None, with_bunny=True):
    """Yields the cases on exact surfaces, and on the bunny, whose names match the regular expression. The bunny needs pymeshlab."""
    spheres = {}

    def sphere(count):
        if count not in spheres:
            spheres[count] = surfaces.sphere_mesh(count, 21)
        return spheres[count]

    def capped(name, count, degrees, noise=0.0):
        v, f = sphere(count)
        return Case(name, v, f, cap(v, f, degrees), Exact(on_sphere), noise=noise)

    def torus(name, size, outer):
        v, f = surfaces.torus(*size)
        middle, radius = ([surfaces.BIG + 1, 0, 0], 0.8) if outer else ([1 - surfaces.BIG, 0, 0], 0.35)
        return Case(name, v, f, np.linalg.norm(v[f].mean(axis=1) - middle, axis=1) < radius, Exact(on_torus))

    def catenoid(name, spacing):
        v, f = surfaces.dumb_bell(spacing)
        return Case(name, v, f, np.abs(v[f].mean(axis=1)[:, 2]) < NECK, Exact(on_catenoid), bridge=True)

    def ellipsoid(name, count):
        v, f = sphere(count)
        v = v * ELLIPSOID
        gone = np.linalg.norm(v[f].mean(axis=1) - [0, ELLIPSOID[1], 0], axis=1) < 0.4
        return Case(name, v, f, gone, Exact(on_ellipsoid))

    def real(name):
        v, f = bunny()
        at, radius = BUNNY[name.split(", ")[1]]
        size = np.ptp(v, axis=0)
        target = v[np.argmin(np.linalg.norm(v - (v.min(axis=0) + np.array(at) * size), axis=1))]
        gone = np.linalg.norm(v[f].mean(axis=1) - target, axis=1) < radius * np.linalg.norm(size)
        component = surfaces.components(f[gone])
        largest = np.bincount(component).argmax()
        gone[np.flatnonzero(gone)[component != largest]] = False
        return Case(name, v, f, gone, truth(v, f), turned=False)

    makers = {
        "sphere 30°": lambda n: capped(n, 2000, 30),
        "sphere 60°": lambda n: capped(n, 2000, 60),
        "sphere 60°, fine": lambda n: capped(n, 8000, 60),
        "sphere 90°": lambda n: capped(n, 2000, 90),
        "sphere 60°, noise 3 %": lambda n: capped(n, 2000, 60, 0.03),
        "sphere 60°, noise 10 %": lambda n: capped(n, 2000, 60, 0.10),
        "torus, outer": lambda n: torus(n, (64, 46), True),
        "torus, outer, fine": lambda n: torus(n, (128, 92), True),
        "torus, inner": lambda n: torus(n, (128, 92), False),
        "catenoid neck": lambda n: catenoid(n, 0.13),
        "catenoid neck, fine": lambda n: catenoid(n, 0.065),
        "ellipsoid": lambda n: ellipsoid(n, 2000),
        "ellipsoid, fine": lambda n: ellipsoid(n, 8000),
        **{f"bunny, {place}": real for place in BUNNY if with_bunny},
    }
    for name, make in makers.items():
        if re.search(pattern, name):
            yield make(name)


def ragged():
    """A sphere without its cap of 60 degrees and without 40 % of the faces next to it: rims touch themselves."""
    case = next(case for case in cases("sphere 60°") if case.name == "sphere 60°")
    v, f = surfaces.sphere_mesh(2000, 21)
    gone = cap(v, f, 60)
    near = np.isin(f, np.unique(f[gone])).any(axis=1) & ~gone
    gone |= near & (np.random.default_rng(8).random(len(f)) < 0.4)
    component = surfaces.components(f[~gone])
    kept = np.flatnonzero(~gone)
    gone[kept[component != np.bincount(component).argmax()]] = True
    return Case("sphere 60°, ragged", v, f, gone, case.truth)


# --- real meshes ----------------------------------------------------------------------------------------------------

MESHES = ["bunny.obj", "bone.ply", "cow.obj"]
CENTRES = 18  # holes of each mesh, before unsuitable ones are skipped
RADII = (0.025, 0.04, 0.06)  # of holes, in turn, over the diagonal of the bounding box
FEWEST = 12  # least number of removed faces


def read(name):
    """Vertices and triangles of a mesh in pymeshlab. Vertices at the same position are merged and sorted by position; degenerate and
    duplicate faces are dropped."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(Path(pymeshlab.__file__).parent / "tests/sample_meshes" / name))
    mesh = meshes.current_mesh()
    v, number = np.unique(np.asarray(mesh.vertex_matrix(), float), axis=0, return_inverse=True)
    f = number.reshape(-1)[np.asarray(mesh.face_matrix(), np.int64)]
    f = f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])]
    f = f[np.sort(np.unique(np.sort(f, axis=1), axis=0, return_index=True)[1])]
    used, number = np.unique(f, return_inverse=True)
    return v[used], number.reshape(f.shape)


def centres(v, count):
    """Farthest-point samples of the vertices, from the vertex farthest from their mean on."""
    near = np.linalg.norm(v - v.mean(axis=0), axis=1)
    chosen = [int(near.argmax())]
    distance = np.linalg.norm(v - v[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(v - v[chosen[-1]], axis=1))
    return chosen


def is_disc(f):
    """Whether triangles form a disc: at most two triangles at each edge, a boundary that does not touch itself, Euler characteristic 1."""
    half = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    edges, number = np.unique(np.sort(half, axis=1), axis=0, return_counts=True)
    rim = boundary(f)
    simple = len(np.unique(rim[:, 0])) == len(rim)
    return simple and number.max() <= 2 and len(np.unique(f)) - len(edges) + len(f) == 1


def real_cases(truth):
    for name in MESHES:
        v, f = read(name)
        size = np.linalg.norm(np.ptp(v, axis=0))
        middle = v[f].mean(axis=1)
        for number, centre in enumerate(centres(v, CENTRES)):
            gone = np.linalg.norm(middle - v[centre], axis=1) < RADII[number % len(RADII)] * size
            if gone.sum() < FEWEST:
                continue
            component = surfaces.components(f[gone])
            gone[np.flatnonzero(gone)[component != np.bincount(component).argmax()]] = False
            # The removed faces must be a disc whose boundary is entirely new, so that the hole is apart from the mesh's own holes.
            before, after = len(boundary(f)), len(boundary(f[~gone]))
            if not is_disc(f[gone]) or after - before != len(boundary(f[gone])):
                continue
            if before:
                rim = np.unique(boundary(f[gone]))
                if np.isin(rim, np.unique(boundary(f))).any():
                    continue
            case = Case(f"{name.split('.')[0]} {number}", v, f, gone, truth(v, f), turned=False)
            normals = vertex_normals(v, f[~gone])[np.unique(boundary(f[gone]))]
            mean = unit(normals.sum(axis=0)[None])[0]
            case.curved = float(np.degrees(np.arccos(np.clip(normals @ mean, -1, 1))).mean())
            case.rim = len(boundary(f[gone]))
            case.centre = v[centre]
            yield case


# --- solids with sharp edges ----------------------------------------------------------------------------------------


def box(cells):
    """A cube from 0 to 1; each side has cells × cells squares of two triangles."""
    at = {}
    faces = []

    def vertex(p):
        return at.setdefault(p, len(at))

    for axis in range(3):
        for side in (0, cells):
            for i in range(cells):
                for j in range(cells):
                    corners = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0, 0, 0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, a, b
                        corners.append(vertex(tuple(p)))
                    corners = corners if side else corners[::-1]
                    faces += [corners[:3], [corners[0], *corners[2:]]]
    return np.array(list(at), float) / cells, np.array(faces)


def cylinder(spacing):
    """A cylinder of radius 1 and height 2."""
    steps = round(1 / spacing)
    radii, heights = np.linspace(0, 1, steps + 1), np.linspace(-1, 1, 2 * steps + 1)
    profile = [*((r, -1) for r in radii), *((1, z) for z in heights[1:-1]), *((r, 1) for r in radii[::-1])]
    return surfaces.revolve(profile, spacing)


def solid_cases(truth):
    """Yields holes over an edge, a corner and a side of a cube, and over the rim and the wall of a cylinder."""
    whole = {"box": box(24), "cylinder": cylinder(0.06)}
    for name, shape, middle, radius in (
        ("box, edge", "box", (0.5, 1, 1), 0.22),
        ("box, corner", "box", (1, 1, 1), 0.22),
        ("box, side", "box", (0.45, 0.5, 1), 0.22),
        ("cylinder, rim", "cylinder", (1, 0, 1), 0.35),
        ("cylinder, wall", "cylinder", (0, 1, 0), 0.4),
    ):
        v, f = whole[shape]
        gone = np.linalg.norm(v[f].mean(axis=1) - middle, axis=1) < radius
        yield Case(name, v, f, gone, truth(v @ surfaces.TURN.T, f))
