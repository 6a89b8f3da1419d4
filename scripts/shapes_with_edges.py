# /// script
# requires-python = ">=3.11"
# dependencies = [
#   "gmsh==4.15.2", "libigl==2.6.3", "meshlib==3.1.4.297", "numpy==2.4.6", "pymeshfix==0.18.1",
#   "pymeshlab==2025.7.post1", "pyvista==0.49.1",
# ]
# ///
"""Fill holes cut out of man-made shapes with isomend, with and without continued sharp edges, and with other programs.

    cargo build --release && uv run scripts/shapes_with_edges.py [--isomend PROGRAM] [--docs] [--json FILE] [--keep DIR]

(or in any virtual environment with the packages of the first lines; on Debian gmsh needs apt install libglu1-mesa libxcursor1
libxft2 libxinerama1). The solids, their meshes and the places of the holes come from scripts/edged_solids.py; every mesh has one
hole. The run takes about four minutes on one core and gives the same figures each time.

Distances are over points spread evenly, in 1/1000 of the hole's diameter D: rms and maximum, the larger of patch to truth and
truth to mesh. 'normals': mean angle between the patch's faces and the truth. 'creases found': share of the length of the truth's
sharp edges (above 25 degrees) inside the hole that have a sharp edge of the patch (above 20 degrees) within 0.02 D. 'false
creases': length over D of sharp edges of the patch farther than 0.1 D from any edge of the truth. 'intersecting': number of patches
with a face that intersects another. In geometric means, distances below 0.1 per mille count as 0.1. 'cut-out faces': the removed
faces, measured like a patch. Results that leave the hole open are left out, with a message.

CGAL's triangulate_refine_and_fair_hole (continuity 1, its default) is compiled from scripts/cgal_fill.cpp, on Debian with
libcgal-dev and libeigen3-dev; without them it is left out. MeshLib is fillHoleNicely with its smoothing; libigl is igl.harmonic with
k = 2 of MeshLib's triangulation without smoothing (scripts/compare_libigl.py); both have edges as long as the rim's. MeshFix is
fill_small_boundaries with refinement. --docs writes the tables into docs/accuracy.md."""

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import igl
import numpy as np
import pymeshfix
import pymeshlab

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import bench_peers as peers  # noqa: E402
import compare_libigl as libigl  # noqa: E402
import edged_solids as solids  # noqa: E402
import make_data as data  # noqa: E402
from benchmark import cases as benchmark  # noqa: E402
from tables import renew  # noqa: E402

FLOOR = "cut-out faces"
TOOLS = {
    "isomend": "isomend",
    "smooth": "isomend `--sharp off`",
    "meshlib": "MeshLib",
    "cgal": "CGAL",
    "igl": "libigl k = 2",
    "meshfix": "MeshFix",
}
QUALITIES = {"clean": "clean meshes", "scanned": "as scanned"}
ACROSS = {"convex", "concave", "curved", "two", "corner", "mixed"}  # kinds whose sharp edges end at the rim
PATCH_SHARP = 20.0  # degrees: edges of a patch above this count as sharp
FOUND = 0.02  # over D: an edge of the truth counts as found if a sharp edge of the patch is within this distance
FALSE = 0.1  # over D: a sharp edge of the patch counts as false if it is farther than this from the truth's edges
SAMPLES = 10_000  # points on the patch, and on the truth round the hole
LEAST = 0.1  # per mille of D: lower bound of distances in geometric means; flat sides of clean meshes are exact for many tools


# --- holes ----------------------------------------------------------------------------------------------------------


def middle_of(site, truth, ends, angle):
    """The hole's centre: the nearest point of the truth to the site, or on a sharp edge or at a corner, depending on the site's kind."""
    if site.kind in solids.ON_EDGE:
        points = ends[np.abs(angle) > 10].mean(axis=1)
    elif site.kind in solids.ON_CORNER:
        points, number = np.unique(ends[np.abs(angle) > 10].reshape(-1, 3).round(9), axis=0, return_counts=True)
        points = points[number > 2]
    else:
        return truth.nearest(site.at[None])[0][0]
    return points[np.linalg.norm(points - site.at, axis=1).argmin()]


def removed(v, f, middle, site, truth):
    """The faces of a hole: a disc of faces within the radius, for the kind `rim` on one side of the solid only; None if there is none."""
    centre = v[f].mean(axis=1)
    _, _, side = truth.nearest(np.vstack([centre, site.at]))
    for factor in (1.0, 1.06, 0.94, 1.12, 0.88):
        gone = np.linalg.norm(centre - middle, axis=1) < factor * site.radius
        if site.kind == "rim":
            gone &= side[:-1] == side[-1]
        inside = np.flatnonzero(gone)
        if len(inside) < 4:
            continue
        component = data.components(f[gone])
        gone[inside[component != component[np.linalg.norm(centre[inside] - middle, axis=1).argmin()]]] = False
        kept = data.components(f[~gone])
        if benchmark.is_disc(f[gone]) and (kept == kept[0]).all():
            return gone
    return None


class Hole:
    """A mesh with a hole, the faces that were cut out, and the truth round them; v, f, whole and bridge are used by other scripts."""

    bridge = False

    def __init__(self, solid, kind, quality, number, mesh, gone, truth):
        self.solid, self.kind, self.quality = solid, kind, quality
        self.name = f"{solid} {number} {kind} {quality}".replace(" ", "-")
        v, f = mesh
        # All tools get the 32-bit coordinates of the file.
        v = v.astype(np.float32).astype(float)
        kept, self.f = data.cut(v, f, gone)
        order = np.concatenate([np.unique(f[~gone]), np.setdiff1d(np.arange(len(v)), f[~gone])])
        place = np.argsort(order)
        self.v = kept
        self.whole = v[order], place[f], gone
        border = libigl.boundary(self.f)
        rim = self.v[np.unique(border)]
        self.rim = len(border)
        self.diameter = max(np.linalg.norm(rim - p, axis=1).max() for p in rim)
        self.edge = np.linalg.norm(self.v[border[:, 0]] - self.v[border[:, 1]], axis=1).mean()
        self.centre = rim.mean(axis=0)
        self.truth = truth.near(self.centre, 2.5 * self.diameter)
        points = truth.near(self.centre, 1.5 * self.diameter).spread(4 * SAMPLES, np.random.default_rng(1))
        self.points = points[self.inside(points)]
        self.set_creases()

    def inside(self, points):
        """For each point whether the nearest face of the whole mesh was cut out."""
        face = igl.point_mesh_squared_distance(np.ascontiguousarray(points), self.whole[0], np.ascontiguousarray(self.whole[1]))[1]
        return self.whole[2][face]

    def set_creases(self):
        """Sets the points on the truth's sharp edges inside the hole, with lengths and angles (degrees), and all edges near the hole."""
        ends, angle = self.truth.creases()
        steps = (np.arange(4) + 0.5) / 4
        points = (ends[:, :1] + steps[:, None] * (ends[:, 1:] - ends[:, :1])).reshape(-1, 3)
        lengths = np.repeat(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / 4, 4)
        angles = np.repeat(angle, 4)
        own = (np.abs(angles) > solids.SHARP) & self.inside(points) if len(points) else np.zeros(0, bool)
        self.creases, self.crease_lengths, self.crease_angles = points[own], lengths[own], angles[own]
        self.all_creases = ends[np.abs(angle) > 5]

    def holds(self):
        """Length of convex and of concave sharp edges in the hole, over D."""
        return [float(self.crease_lengths[sign * self.crease_angles > 0].sum() / self.diameter) for sign in (1, -1)]


def holes(pattern):
    for seed, name in enumerate(solids.SOLIDS):
        if not re.search(pattern, name):
            continue
        truth, meshes, sites = solids.sampled(name, seed)
        ends, angle = truth.creases()
        for quality, mesh in meshes.items():
            for number, site in enumerate(sites, 1):
                gone = removed(*mesh, middle_of(site, truth, ends, angle), site, truth)
                if gone is None:
                    print(f"{name} {number} {site.kind} {quality}: NO HOLE could be cut", file=sys.stderr)
                    continue
                yield Hole(name, site.kind, quality, number, mesh, gone, truth)


# --- fills ----------------------------------------------------------------------------------------------------------


def by_isomend(program, hole, folder, options=()):
    command = [program, "fill", folder / "in.ply", "-o", folder / "out.obj", "--json", "-", "-q", "--threads", 1, *options]
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        raise RuntimeError(done.stderr.strip())
    v, f = peers.read_obj(folder / "out.obj")
    v[: len(hole.v)] = hole.v
    region = (json.loads(done.stdout)["regions"] or [{}])[0]
    return v, f, {"closed_by": region.get("closed_by"), "creases": region.get("creases", [])}


def by_meshfix(hole):
    mesh = pymeshfix.PyTMesh()
    mesh.set_quiet(True)
    mesh.load_array(hole.v, hole.f.astype(np.int32))
    mesh.fill_small_boundaries(nbe=0, refine=True)
    v, f = mesh.return_arrays()
    return np.asarray(v, float), np.asarray(f, int)


def by_cgal(program, hole, folder):
    peers.write_off(folder / "in.off", hole.v, hole.f)
    subprocess.run([program, folder / "in.off", folder / "out.off", "1"], check=True, capture_output=True)
    return peers.read_off(folder / "out.off")


def fills(hole, program, cgal, with_peers, folder):
    """Functions that fill the hole, by the tools' names; each returns vertices and faces, isomend's also the report."""
    data.write_ply(folder / "in.ply", hole.v, hole.f)
    yield "isomend", lambda: by_isomend(program, hole, folder)
    yield "smooth", lambda: by_isomend(program, hole, folder, ("--sharp", "off"))
    if not with_peers:
        return
    longest = hole.edge / 0.75
    yield "meshlib", lambda: libigl.triangulate(hole, longest, True)[:2]

    def faired():
        v, f, _, _ = libigl.triangulate(hole, longest, False)
        moved = libigl.fair(hole, v, f, 2, 1)[0]
        return v if moved is None else moved, f

    yield "igl", faired
    yield "meshfix", lambda: by_meshfix(hole)
    if cgal:
        yield "cgal", lambda: by_cgal(cgal, hole, folder)


# --- scores ---------------------------------------------------------------------------------------------------------


def to_segments(points, ends):
    """Distances of points to the nearest of the segments; infinite if there are no segments."""
    nearest = np.full(len(points), np.inf)
    for a, b in ends:
        along = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0, 1)
        nearest = np.minimum(nearest, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return nearest


def sharp_edges(v, f, patch):
    """Ends of the patch's edges, rim included, with more than PATCH_SHARP between their faces' normals."""
    half = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    face = np.tile(np.arange(len(f)), 3)
    order = np.lexsort(np.sort(half, axis=1).T)
    keys, face = np.sort(half, axis=1)[order], face[order]
    pair = np.flatnonzero((keys[1:] == keys[:-1]).all(axis=1))
    a, b = face[pair], face[pair + 1]
    normals = libigl.unit(solids.crossed(v, f))
    sharp = (patch[a] | patch[b]) & ((normals[a] * normals[b]).sum(axis=1) < np.cos(np.radians(PATCH_SHARP)))
    return v[keys[pair[sharp]]]


def intersections(v, f, patch, centre, radius):
    """Number of faces of the patch that intersect other faces."""
    near = patch | (np.linalg.norm(v[f].mean(axis=1) - centre, axis=1) < radius)
    used, local = np.unique(f[near], return_inverse=True)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(v[used], local.reshape(-1, 3)))
    meshes.compute_selection_by_self_intersections_per_face()
    return int((meshes.current_mesh().face_selection_array() & patch[near]).sum())


def score(hole, v, f, patch):
    own = f[patch]
    samples = libigl.spread(v, own, SAMPLES, np.random.default_rng(2))
    # The same random numbers give the faces of the samples, for their normals.
    area = solids.crossed(v, own)
    sizes = np.linalg.norm(area, axis=1)
    face = np.random.default_rng(2).choice(len(own), SAMPLES, p=sizes / sizes.sum())
    nearest, normal, _ = hole.truth.nearest(samples)
    there = np.linalg.norm(samples - nearest, axis=1)
    back = np.sqrt(igl.point_mesh_squared_distance(hole.points, np.ascontiguousarray(v), np.ascontiguousarray(f, np.int64))[0])
    cosine = (libigl.unit(area)[face] * normal).sum(axis=1)
    ends = sharp_edges(v, f, patch)
    off = to_segments(ends.mean(axis=1), hole.all_creases) if len(ends) else np.zeros(0)
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    row = {
        "rms": max(float(np.sqrt((d**2).mean()) / hole.diameter * 1e3) for d in (there, back)),
        "max": max(float(d.max() / hole.diameter * 1e3) for d in (there, back)),
        "normals": float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean()),
        "false": float(length[off > FALSE * hole.diameter].sum() / hole.diameter),
        "intersecting": intersections(v, f, patch, hole.centre, 1.5 * hole.diameter),
        "faces": int(patch.sum()),
    }
    if hole.crease_lengths.sum() > 0.15 * hole.diameter:
        near = to_segments(hole.creases, ends) < FOUND * hole.diameter
        row["found"] = float((near * hole.crease_lengths).sum() / hole.crease_lengths.sum())
    return row


def measured(hole, program, cgal, with_peers, folder):
    convex, concave = hole.holds()
    row = {
        "hole": hole.name, "solid": hole.solid, "kind": hole.kind, "quality": hole.quality, "diameter": hole.diameter,
        "rim": hole.rim, "edge": hole.edge, "convex": convex, "concave": concave, "scores": {},
    }
    row["scores"]["floor"] = score(hole, *hole.whole)
    for tool, fill in fills(hole, program, cgal, with_peers, folder):
        try:
            start = time.perf_counter()
            v, f, *report = fill()
            seconds = time.perf_counter() - start
        except (RuntimeError, ValueError, subprocess.CalledProcessError) as error:
            print(f"{hole.name}: {TOOLS[tool]} failed: {error}", file=sys.stderr)
            continue
        patch, closed = peers.marked(hole, v, f)
        if not closed:
            print(f"{hole.name}: {TOOLS[tool]} left the hole open", file=sys.stderr)
            continue
        row["scores"][tool] = score(hole, v, f, patch) | {"seconds": seconds} | (report[0] if report else {})
    return row


# --- tables ---------------------------------------------------------------------------------------------------------


def mean(values):
    return float(np.exp(np.mean(np.log(np.maximum(values, LEAST)))))


def shown(value):
    return f"{value:.1f}"


def bold_least(values):
    texts = [shown(value) for value in values]
    return [f"**{text}**" if text == shown(min(values)) else text for text in texts]


def by_kind(rows, tools, quality):
    names = " | ".join(TOOLS[t] for t in tools)
    lines = [f"| hole, {QUALITIES[quality]} | number | {FLOOR} | {names} |", "|---|---:|---:|" + "---:|" * len(tools)]
    for kind, title in (solids.KINDS | {"": "all"}).items():
        own = [r for r in rows if kind in ("", r["kind"]) and r["quality"] == quality and all(t in r["scores"] for t in tools)]
        if own:
            floor, *means = (mean([r["scores"][t]["rms"] for r in own]) for t in ("floor", *tools))
            lines.append(f"| {title} | {len(own)} | {shown(floor)} | {' | '.join(bold_least(means))} |")
    return "\n".join(lines)


def by_measure(rows, tools):
    lines = ["| tool | meshes | rms, ‰ | largest, ‰ | normals | creases found | false creases | intersecting |",
             "|---|---|---:|---:|---:|---:|---:|---:|"]
    for quality, title in QUALITIES.items():
        for tool in ("floor", *tools):
            own = [r["scores"][tool] for r in rows if r["quality"] == quality and all(t in r["scores"] for t in tools)]
            if not own:
                continue
            found = [s["found"] for s in own if "found" in s]
            lines.append(
                f"| {TOOLS.get(tool, FLOOR)} | {title} | {mean([s['rms'] for s in own]):.1f} | {mean([s['max'] for s in own]):.1f} "
                f"| {np.mean([s['normals'] for s in own]):.1f}° | {100 * np.mean(found):.0f} % "
                f"| {np.mean([s['false'] for s in own]):.2f} D | {sum(s['intersecting'] > 0 for s in own)} |"
            )
    return "\n".join(lines)


def summary(rows):
    """A text on how often continued sharp edges are nearer to or farther from the truth, and where edges are missed or invented."""
    both = [r for r in rows if "isomend" in r["scores"] and "smooth" in r["scores"]]
    ratio = np.array([np.divide(*(max(r["scores"][t]["rms"], LEAST) for t in ("isomend", "smooth"))) for r in both])
    continued = {r["hole"]: len(r["scores"]["isomend"]["creases"]) > 0 for r in both}
    across = [continued[r["hole"]] for r in both if r["kind"] in ACROSS]
    smooth = [continued[r["hole"]] for r in both if r["kind"] in ("round", "fillet")]
    # No line may start with a number and a full stop, which is a list in Markdown.
    return (
        f"Of {len(both)} holes, the default is nearer to the truth than `--sharp off` by more than a tenth in {(ratio < 0.9).sum()}, "
        f"and farther by more\nthan a tenth in {(ratio > 1.1).sum()}. Of {len(across)} holes across edges or over corners, "
        f"{across.count(False)} got no edge. Of {len(smooth)} holes in round sides and across\nfillets, where no edge is to be "
        f"continued, {smooth.count(True)} got one."
    )


def loop(f):
    """Vertices of the hole's rim, in order."""
    after = {int(a): int(b) for a, b in libigl.boundary(f)}
    rim = [min(after)]
    while after[rim[-1]] != rim[0]:
        rim.append(after[rim[-1]])
    return rim


def keep(folder, hole):
    """Writes the mesh with its hole, the whole mesh and the truth near the hole; returns their paths and the hole's rim."""
    used, local = np.unique(hole.truth.f, return_inverse=True)
    meshes = {
        "input": ("", hole.v, hole.f),
        "whole": ("whole/", *hole.whole[:2]),
        "truth": ("truth/", hole.truth.v[used], local.reshape(-1, 3)),
    }
    paths = {}
    for name, (sub, v, f) in meshes.items():
        paths[name] = str((folder / f"{sub}{hole.name}.ply").resolve())
        data.write_ply(paths[name], v, f, double=name == "truth")
    return paths | {"rim": loop(hole.f)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--solids", default="", help="regular expression of the names of solids")
    parser.add_argument("--no-peers", action="store_true", help="run isomend only, with and without --sharp off")
    parser.add_argument("--cgal", type=Path, help="compiled program of scripts/cgal_fill.cpp")
    parser.add_argument("--json", type=Path, help="file for all figures")
    parser.add_argument("--keep", type=Path, help="folder in which to keep the meshes with and without holes, and the truth near the holes")
    parser.add_argument("--docs", action="store_true", help="write the tables into docs/accuracy.md")
    arguments = parser.parse_args()
    rows, kept = [], {}
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        cgal = None if arguments.no_peers else arguments.cgal or peers.compile_cgal(folder)
        tools = [t for t in TOOLS if t in ("isomend", "smooth") or (not arguments.no_peers and (t != "cgal" or cgal))]
        for sub in ("whole", "truth") if arguments.keep else ():
            (arguments.keep / sub).mkdir(parents=True, exist_ok=True)
        for hole in holes(arguments.solids):
            rows.append(measured(hole, arguments.isomend.resolve(), cgal, not arguments.no_peers, folder))
            if arguments.keep:
                kept[hole.name] = keep(arguments.keep, hole)
            scores = rows[-1]["scores"]
            figures = "  ".join(f"{t} {scores[t]['rms']:.2f}" for t in ("floor", *tools) if t in scores)
            print(f"{hole.name:36} rim {hole.rim:3}  D/edge {hole.diameter / hole.edge:4.1f}  {figures}", flush=True)
    kinds = "\n\n".join(by_kind(rows, tools, quality) for quality in QUALITIES)
    measures = by_measure(rows, tools) + "\n\n" + summary(rows)
    print(f"\n{kinds}\n\n{measures}")
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=1) + "\n")
    if arguments.keep:
        (arguments.keep / "holes.json").write_text(json.dumps(kept) + "\n")
    if arguments.docs:
        renew("edges", "shapes_with_edges.py", kinds)
        renew("edges-measures", "shapes_with_edges.py", measures)


if __name__ == "__main__":
    main()
