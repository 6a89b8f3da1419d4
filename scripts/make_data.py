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

ELLIPSOIDS = [  # centre, radii: all contain the origin, so that every ray from it leaves them once
    ((0, 0.02, 0.42), (0.40, 0.47, 0.58)),  # head
    ((0, 0.0, 0.0), (0.27, 0.27, 0.6)),  # neck
    ((0, -0.05, -0.52), (0.86, 0.42, 0.56)),  # shoulders
]
BUMPS = [  # direction, height, width in radians
    ((0, 0.62, 0.50), 0.13, 0.085),  # nose
    ((0, 0.55, 0.13), 0.07, 0.14),  # chin
    ((0.15, 0.6, 0.66), 0.035, 0.12),  # brows
    ((-0.15, 0.6, 0.66), 0.035, 0.12),
    ((0.14, 0.6, 0.57), -0.035, 0.075),  # eyes
    ((-0.14, 0.6, 0.57), -0.035, 0.075),
    ((0.62, 0.0, 0.50), 0.09, 0.11),  # ears
    ((-0.62, 0.0, 0.50), 0.09, 0.11),
    ((0, -0.6, 0.35), 0.12, 0.22),  # knot of hair
]


def bust(d):
    """Distance from the origin to the surface in the directions d."""
    exits = []
    for centre, radii in ELLIPSOIDS:
        q, c = d / radii, np.divide(centre, radii)
        a, b = (q * q).sum(axis=1), q @ c
        exits.append((b + np.sqrt(b * b - a * (c @ c - 1))) / a)
    sharp = 14.0
    exits = np.array(exits)
    top = exits.max(axis=0)
    r = top + np.log(np.exp(sharp * (exits - top)).sum(axis=0)) / sharp
    for towards, height, width in BUMPS:
        towards = np.divide(towards, np.linalg.norm(towards))
        r += height * np.exp((d @ towards - 1) / width**2)
    hair = 1 / (1 + np.exp(-14 * (d[:, 2] - 0.75 - 0.5 * d[:, 1])))
    r += 0.012 * hair * np.sin(26 * np.arctan2(d[:, 0], d[:, 2]) + 6 * d[:, 1])
    return r


HOLES = [  # direction, radius as a fraction of the unit, raggedness
    ((0.25, -0.1, 0.97), 0.20, 0.25),  # crown of the head
    ((0.0, 0.42, -0.25), 0.17, 0.25),  # chest
    ((-0.62, 0.25, 0.30), 0.13, 0.35),  # jaw
    ((0.80, 0.05, -0.35), 0.17, 0.25),  # shoulder
    ((-0.45, -0.35, -0.45), 0.24, 0.2),  # back, with an island
    ((0.3, 0.3, -1.0), 0.20, 0.2),  # base
    ((0.45, 0.5, 0.55), 0.07, 0.3),  # cheek
]


def scan(count):
    """A bust like a scan: uneven triangles, noise, ragged rims, holes of all sizes, an island."""
    rng = np.random.default_rng(11)
    face = np.array([0, 0.7, 0.6]) / np.linalg.norm([0, 0.7, 0.6])

    def density(d):
        uneven = 1.3 + 1.5 * np.exp(4 * (d @ face - 1)) + 0.45 * np.sin(9 * d[:, 0]) * np.sin(7 * d[:, 2])
        return bust(d) ** 2 * uneven

    d, f = sphere_mesh(count, 11, density)
    r = bust(d)
    v = d * r[:, None]
    edge = np.linalg.norm(v[f] - v[np.roll(f, 1, axis=1)], axis=2).mean()
    v = v + d * rng.normal(scale=0.035 * edge, size=(len(v), 1))
    centre = v[f].mean(axis=1)
    removed = np.zeros(len(f), bool)
    keep = np.zeros(len(f), bool)
    for number, (towards, radius, ragged) in enumerate(HOLES):
        towards = np.divide(towards, np.linalg.norm(towards))
        at = towards * bust(towards[None])[0]
        away = centre - at
        side = np.cross(towards, [0.3, 0.5, 0.8])
        angle = np.arctan2(away @ side, away @ np.cross(towards, side))
        phase = rng.uniform(0, 2 * np.pi, 3)
        wave = np.sin(2 * angle + phase[0]) + 0.7 * np.sin(5 * angle + phase[1]) + 0.5 * np.sin(9 * angle + phase[2])
        reach = radius * (1 + 0.5 * ragged * wave) + 0.3 * edge * rng.normal(size=len(f))
        removed |= np.linalg.norm(away, axis=1) < reach
        if number == 4:
            keep |= np.linalg.norm(away - [0.02, 0, 0.03], axis=1) < 0.075
    removed &= ~keep
    at_rim = np.isin(f, np.unique(f[removed])).any(axis=1) & ~keep
    removed |= at_rim & (rng.random(len(f)) < 0.015)
    # A few single triangles are missing elsewhere.
    removed |= (rng.random(len(f)) < 0.0003) & ~keep
    v, f = cut(v, f, removed)
    component = components(f)
    number, size = np.unique(component, return_counts=True)
    v, f = cut(v, f, ~np.isin(component, number[np.argsort(size)[-2:]]))
    return v * 120.0, f


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
    write_ply(folder / "scan.ply", *scan(7000))
    write_ply(folder / "painted.ply", *painted(2000))
    write_obj(folder / "sheet.obj", *sheet(36))
    for path in sorted(folder.glob("*.ply")) + sorted(folder.glob("*.obj")):
        print(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
