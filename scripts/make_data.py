# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6"]
# ///
"""Make the example meshes of data/: analytic shapes with holes, and a mesh that imitates a scan of an object.

    python3 scripts/make_data.py [FOLDER]

The analytic shapes are rotated, so that no lattice is aligned with them. Each has a function for the distance to its exact
surface, against which scripts/accuracy.py measures fills. The output is the same on every run."""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from benchmark import surfaces  # noqa: E402
from bust import bust_mesh  # noqa: E402

BIG, JOIN, TURN = surfaces.BIG, surfaces.JOIN, surfaces.TURN
closed_torus, components, cut, revolve, sphere_mesh, turn = (
    surfaces.torus, surfaces.components, surfaces.cut, surfaces.revolve, surfaces.sphere_mesh, surfaces.turn
)  # fmt: skip


# --- analytic shapes ------------------------------------------------------------------------------------------------


def sphere(count, seed, polar_range):
    """The unit sphere without the faces with centres between two polar angles, in degrees."""
    v, f = sphere_mesh(count, seed)
    centre = v[f].mean(axis=1)
    angle = np.degrees(np.arccos(centre[:, 2] / np.linalg.norm(centre, axis=1)))
    v, f = cut(v, f, (angle > polar_range[0]) & (angle < polar_range[1]))
    return v, f


def sphere_distance(p):
    return np.linalg.norm(p, axis=1) - 1


def torus(around, across):
    """The Clifford torus with radii sqrt(2) and 1 and a hole on its outer and on its inner equator."""
    v, f = closed_torus(around, across)
    centre = v[f].mean(axis=1)
    outer = np.linalg.norm(centre - [BIG + 1, 0, 0], axis=1) < 0.8
    inner = np.linalg.norm(centre + [BIG - 1, 0, 0], axis=1) < 0.35
    return cut(v, f, outer | inner)


def torus_distance(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - BIG, p[:, 2]) - 1


NECK = 0.55


def catenoid(spacing):
    """A dumb-bell without its neck: a catenoid with a waist of radius 1 joins two balls; the part between two rims is missing."""
    ball = np.cosh(JOIN) ** 2
    centre = JOIN + np.cosh(JOIN) * np.sinh(JOIN)
    start = np.arccos(-np.tanh(JOIN))
    arc = np.linspace(start, 0, round(ball * start / (0.87 * spacing)) + 1)
    neck = np.arcsinh(np.linspace(np.sinh(NECK), np.sinh(JOIN), round((np.sinh(JOIN) - np.sinh(NECK)) / (0.87 * spacing)) + 1))
    profile = [(np.cosh(z), z) for z in neck] + [(ball * np.sin(a), centre + ball * np.cos(a)) for a in arc[1:]]
    v, f = revolve(profile, spacing)
    low = v * [1, -1, -1]
    return np.vstack([v, low]), np.vstack([f, f + len(v)])


def catenoid_distance(p):
    r, z = np.hypot(p[:, 0], p[:, 1]), p[:, 2]
    t = np.clip(z, -1, 1)
    for _ in range(60):
        c, s = np.cosh(t), np.sinh(t)
        step = ((c - r) * s + t - z) / np.maximum(s * s + 1 + (c - r) * c, 0.1)
        t = t - np.clip(step, -0.2, 0.2)
    return np.hypot(r - np.cosh(t), z - t)


SLAB = np.array([1.0, 0.8, 0.5])


def box(cells):
    """A box of triangles whose edges are edges of the mesh."""
    number, v, f = {}, [], []
    counts = np.round(cells * SLAB).astype(int)

    def vertex(p):
        key = tuple(np.round(p * 1e6).astype(int))
        if key not in number:
            number[key] = len(v)
            v.append(p)
        return number[key]

    rng = np.random.default_rng(5)
    for axis in range(3):
        for side in (-1, 1):
            i, j = [(1, 2), (2, 0), (0, 1)][axis]
            jitter = rng.uniform(-0.25, 0.25, (counts[i] + 1, counts[j] + 1, 2))
            jitter[[0, -1]] = jitter[:, [0, -1]] = 0

            def at(a, b):
                p = np.zeros(3)
                p[axis] = side * SLAB[axis]
                p[i] = (2 * (a + jitter[a, b, 0]) / counts[i] - 1) * SLAB[i]
                p[j] = (2 * (b + jitter[a, b, 1]) / counts[j] - 1) * SLAB[j]
                return vertex(p)

            for a in range(counts[i]):
                for b in range(counts[j]):
                    q = [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)]
                    q = q if side > 0 else q[::-1]
                    k = rng.integers(2)
                    f += [[q[k], q[1 + k], q[2 + k]], [q[k], q[2 + k], q[(3 + k) % 4]]]
    return np.array(v), np.array(f)


def slab(cells):
    """A box with a round hole in its flat top."""
    v, f = box(cells)
    centre = v[f].mean(axis=1)
    return cut(v, f, (centre[:, 2] > SLAB[2] - 1e-6) & (np.hypot(centre[:, 0] - 0.1, centre[:, 1]) < 0.35))


def part(cells):
    """A box with a hole across an edge and one over a corner."""
    v, f = box(cells)
    centre = v[f].mean(axis=1)
    at_edge = np.linalg.norm(centre - [-0.2, SLAB[1], SLAB[2]], axis=1) < 0.22
    at_corner = np.linalg.norm(centre - [SLAB[0], -SLAB[1], SLAB[2]], axis=1) < 0.3
    return cut(v, f, at_edge | at_corner)


def slab_distance(p):
    return p[:, 2] - SLAB[2]


def sheet(cells):
    """An open sheet, part of a paraboloid, with one hole: its outer border is not a hole."""
    x, y = np.meshgrid(np.linspace(-1, 1, cells + 1), np.linspace(-1, 1, cells + 1), indexing="ij")
    jitter = np.random.default_rng(6).uniform(-0.5, 0.5, (2, cells + 1, cells + 1)) / cells
    v = np.stack([x + jitter[0], y + jitter[1], 0 * x], axis=-1).reshape(-1, 3)
    v[:, 2] = 0.3 * (v[:, 0] ** 2 + v[:, 1] ** 2)
    f = []
    for i in range(cells):
        for j in range(cells):
            a, b = i * (cells + 1) + j, (i + 1) * (cells + 1) + j
            f += [[a, b, b + 1], [a, b + 1, a + 1]]
    f = np.array(f)
    centre = v[f].mean(axis=1)
    return cut(v, f, np.hypot(centre[:, 0] + 0.2, centre[:, 1] - 0.1) < 0.3)


def painted(count):
    """The unit sphere with a dent that is painted red and has noise, and the colours of its vertices."""
    v, f = sphere_mesh(count, 7)
    angle = np.degrees(np.arccos(v @ np.divide([2, -3, 6], 7)))
    depth = 0.15 * np.exp(-((angle / 12) ** 2)) + np.random.default_rng(7).normal(scale=0.008, size=len(v))
    inside = angle < 28
    colours = np.where(inside[:, None], [255, 0, 0], [190, 190, 190])
    return v * (1 - depth * inside)[:, None], f, colours


# --- an imitated scan -----------------------------------------------------------------------------------------------

HOLES = [  # place on the bust, radius as a fraction of its unit, raggedness
    ((0.42, -0.30, 0.95), 0.225, 0.15),  # crown of the head
    ((0.10, 0.60, -1.75), 0.21, 0.25),  # back
    ((-0.50, -0.30, -0.42), 0.165, 0.25),  # jaw
    ((0.72, -0.12, -1.78), 0.27, 0.25),  # shoulder
    ((-0.36, -0.30, -1.80), 0.33, 0.25),  # chest, with an island
    ((0.05, 0.14, -2.30), 0.295, 0.25),  # base
    ((0.40, -0.62, -0.25), 0.08, 0.3),  # cheek
]
ISLAND = 4  # the hole with an island
BESIDE = (0.43, 0.55, -1.75)  # place of a small hole beside the one in the back
SINGLE = 14  # single triangles that are missing


def ragged(v, f, at, radius, raggedness, edge, rng):
    """Which faces lie in a ragged disc about a point: one connected part of the mesh."""
    centre = v[f].mean(axis=1)
    away = centre - at
    side = np.cross(at, [0.3, 0.5, 0.8])
    angle = np.arctan2(away @ side, away @ np.cross(at, side))
    phase = rng.uniform(0, 2 * np.pi, 3)
    wave = np.sin(2 * angle + phase[0]) + 0.7 * np.sin(5 * angle + phase[1]) + 0.5 * np.sin(9 * angle + phase[2])
    reach = radius * (1 + 0.5 * raggedness * wave) + 0.3 * edge * rng.normal(size=len(centre))
    inside = np.flatnonzero(np.linalg.norm(away, axis=1) < reach)
    component = components(f[inside])
    disc = np.zeros(len(f), bool)
    disc[inside[component == np.bincount(component).argmax()]] = True
    return disc


def scan(count):
    """A bust like a scan: uneven triangles, noise, ragged rims, holes of all sizes, an island."""
    rng = np.random.default_rng(11)
    v, way, f = bust_mesh(count, 11)
    edge = np.linalg.norm(v[f] - v[np.roll(f, 1, axis=1)], axis=2).mean()
    v = v + way * rng.normal(scale=0.025 * edge, size=(len(v), 1))
    centre = v[f].mean(axis=1)
    removed, keep, near = np.zeros(len(f), bool), np.zeros(len(f), bool), np.zeros(len(f), bool)
    for number, (place, radius, raggedness) in enumerate(HOLES):
        at = v[np.argmin(np.linalg.norm(v - place, axis=1))]
        removed |= ragged(v, f, at, radius, raggedness, edge, rng)
        away = np.linalg.norm(centre - at, axis=1)
        near |= away < 1.5 * radius + 0.1
        if number == ISLAND:
            keep |= np.linalg.norm(centre - at - [0, 0, 0.07], axis=1) < 0.12
            whole = away < 1.5 * radius
    removed &= ~keep
    # Triangles are missing at the rims, except at the hole with the island: the rim of the island is joined to that hole only.
    at_rim = np.isin(f, np.unique(f[removed])).any(axis=1) & ~whole
    removed |= at_rim & (rng.random(len(f)) < 0.01)
    # A few triangles beside a hole, and single ones elsewhere, but not in the face.
    beside = v[np.argmin(np.linalg.norm(v - BESIDE, axis=1))]
    removed |= np.linalg.norm(centre - beside, axis=1) < 1.3 * edge
    near |= centre[:, 1] < -0.3
    removed[rng.choice(np.flatnonzero(~near), SINGLE, replace=False)] = True
    v, f = cut(v, f, removed)
    component = components(f)
    number, size = np.unique(component, return_counts=True)
    v, f = cut(v, f, ~np.isin(component, number[np.argsort(size)[-2:]]))
    return v * 90.0, f


# --- files ----------------------------------------------------------------------------------------------------------

SHAPES = {  # name: (maker, distance to the exact surface)
    "sphere": (lambda: sphere(3600, 1, (-1, 60)), sphere_distance),
    "island": (lambda: sphere(3600, 2, (18, 55)), sphere_distance),
    "torus": (lambda: torus(82, 58), torus_distance),
    "catenoid": (lambda: catenoid(0.13), catenoid_distance),
    "slab": (lambda: slab(22), slab_distance),
}


def exact_distance(name, points):
    """Distance of points to the exact surface of a shape."""
    return np.abs(SHAPES[name][1](points @ TURN))


def write_ply(path, v, f, colours=None, double=False):
    """Writes a binary PLY with 32-bit coordinates (64-bit with `double`), and colours of vertices if given."""
    kind, code = ("double", "<f8") if double else ("float", "<f4")
    names = "" if colours is None else "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
    with open(path, "wb") as out:
        out.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(v)}\nproperty {kind} x\nproperty {kind} y\n"
            f"property {kind} z\n{names}element face {len(f)}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        points = np.zeros(len(v), dtype=[("at", code, 3)] + [("colour", "u1", 3)] * (colours is not None))
        points["at"] = v
        if colours is not None:
            points["colour"] = colours
        out.write(points.tobytes())
        rows = np.zeros(len(f), dtype=[("n", "u1"), ("v", "<i4", 3)])
        rows["n"], rows["v"] = 3, f
        out.write(rows.tobytes())


def write_obj(path, v, f):
    lines = ["v {:.6f} {:.6f} {:.6f}".format(*p) for p in v] + ["f {} {} {}".format(*(t + 1)) for t in f]
    Path(path).write_text("\n".join(lines) + "\n")


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "data"
    folder.mkdir(exist_ok=True)
    for name, (make, _) in SHAPES.items():
        v, f = make()
        write_ply(folder / f"{name}.ply", v @ TURN.T, f)
    v, f = part(16)
    write_ply(folder / "part.ply", v @ TURN.T, f)
    write_ply(folder / "scan.ply", *scan(7300))
    write_ply(folder / "painted.ply", *painted(2000))
    write_obj(folder / "sheet.obj", *sheet(36))
    for path in sorted(folder.glob("*.ply")) + sorted(folder.glob("*.obj")):
        print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
