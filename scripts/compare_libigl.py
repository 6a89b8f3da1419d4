# /// script
# requires-python = ">=3.11"
# dependencies = [
#   "libigl==2.6.3", "matplotlib==3.11.2", "meshlib==3.1.4.297", "numpy==2.4.6", "pillow==13.0.0",
#   "pymeshlab==2025.7.post1", "pyvista==0.49.1",
# ]
# ///
"""Fill the same holes with isomend and with libigl's k-harmonic fairing, and measure both against the true surface.

    cargo build --release && uv run scripts/compare_libigl.py [--json FILE] [--markdown FILE] [--picture FILE] [--docs]

(or in any virtual environment with the packages of the first lines). The holes are the same in every run. They are cut out of
analytic surfaces, from which distances are exact, and out of the Stanford bunny of the package pymeshlab.

libigl has no hole filling of its own. Its users triangulate and refine the hole with another program and then move
the new vertices: `igl.harmonic(V, F, b, bc, k)` with cotangent Laplacian and Voronoi areas, all vertices of the input in b,
k = 2 (continues position and normal) and k = 3 (curvature too). Here MeshLib triangulates (`fillHoleNicely`, for two rims
`stitchHolesNicely`), with its longest edge chosen so that the mean edge is as long as in isomend's patch. The Laplacian depends
on the triangulation, so the fairing is initialised twice, with and without MeshLib's own smoothing, and the result nearer to the
true surface counts: a choice that users, who do not know the true surface, do not have. 'x 10': solved ten times more, each time
with the Laplacian of the previous positions.

Distances are root mean squares (rms) and maxima over points spread evenly, in 1/1000 of the hole's diameter, the larger of
patch to truth and truth to mesh; for noisy meshes the truth is the surface without noise. 'normal': mean angle at the
new vertices between the mesh's normal and the truth's; 'seam': mean angle between the faces on both sides of the rim;
'quality': mean of twice inradius over circumradius. Seconds are the time of the fill without reading and writing, the least of
three runs; for libigl the time of MeshLib's triangulation and of the solves on a crop of six rings, whose result is the same as
for the whole mesh. 'floor' is the score of the removed triangles."""

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

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import make_data as data  # noqa: E402
from benchmark import cases as known  # noqa: E402
from benchmark import peers  # noqa: E402
from tables import renew  # noqa: E402

Case, Exact, boundary, cap, spread, unit, vertex_normals = (
    known.Case, known.Exact, known.boundary, known.cap, known.spread, known.unit, known.vertex_normals
)  # fmt: skip
fair, mean_edge, triangulate = peers.fair, peers.mean_edge, peers.triangulate
METHODS = {
    "k2": "libigl k = 2",
    "k2x10": "libigl k = 2 × 10",
    "k3": "libigl k = 3",
    "k3x10": "libigl k = 3 × 10",
    "isomend": "isomend",
    "variation": "isomend, curvature-variation",
}
TIMES = 3


class Triangles:
    """A mesh as the true surface."""

    def __init__(self, v, f):
        self.v, self.f = v, f
        self.normals = unit(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]))
        self.smooth = vertex_normals(v, f)

    def nearest(self, p):
        _, face, q = igl.point_mesh_squared_distance(np.ascontiguousarray(p), self.v, self.f)
        a, b, c = (self.v[self.f[face, k]] for k in range(3))
        total = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        weights = [np.linalg.norm(np.cross(y - q, z - q), axis=1) / total for y, z in ((b, c), (c, a), (a, b))]
        return q, unit(sum(w[:, None] * self.smooth[self.f[face, k]] for k, w in enumerate(weights)))


def cases(pattern=""):
    """Yields the cases of the benchmark whose names match the regular expression."""
    return known.cases(pattern, Triangles)


# --- fills ----------------------------------------------------------------------------------------------------------


def quickest(run, at):
    """The fastest of several runs, which all have the same result; `at` is the index of the seconds in it."""
    return min((run() for _ in range(TIMES)), key=lambda result: result[at])


def fill_isomend(program, case, options=()):
    """Fills a case with isomend; returns vertices and faces, the input's first, and seconds."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.ply", Path(folder) / "out.obj"
        data.write_ply(source, case.v, case.f)
        command = [program, "fill", source, "-o", target, "--json", "-", "-q", *options]
        report = json.loads(subprocess.run([str(c) for c in command], check=True, capture_output=True, text=True).stdout)
        rows = {"v": [], "f": []}
        for line in target.read_text().splitlines():
            words = line.split()
            if words and words[0] in rows:
                rows[words[0]].append([word.split("/")[0] for word in words[1:4]])
    v, f = np.array(rows["v"], float), np.array(rows["f"], int) - 1
    v[: len(case.v)] = case.v
    outcomes = {hole["closed_by"] or hole["outcome"] for hole in report["holes"]}
    return v, f, report["seconds"], ", ".join(sorted(outcomes - {"level_set"}))


# --- scores ---------------------------------------------------------------------------------------------------------


def score(case, v, f, patch):
    rng = np.random.default_rng(2)
    own = f[patch]
    samples = spread(v, own, 20_000, rng)
    there = np.linalg.norm(samples - case.truth.nearest(samples)[0], axis=1)
    back = np.sqrt(igl.point_mesh_squared_distance(case.points, np.ascontiguousarray(v), np.ascontiguousarray(f, np.int64))[0])
    new = np.setdiff1d(np.unique(own), np.unique(f[~patch]))
    angle = 0.0
    if len(new):
        cosine = (vertex_normals(v, f)[new] * case.truth.nearest(v[new])[1]).sum(axis=1)
        angle = np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean()
    normals = unit(np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]]))
    half = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    face = np.tile(np.arange(len(f)), 3)
    order = np.lexsort(np.sort(half, axis=1).T)
    keys, face = np.sort(half, axis=1)[order], face[order]
    pair = np.flatnonzero((keys[1:] == keys[:-1]).all(axis=1))
    a, b = face[pair], face[pair + 1]
    across = patch[a] != patch[b]
    seam = np.degrees(np.arccos(np.clip((normals[a[across]] * normals[b[across]]).sum(axis=1), -1, 1)))
    sides = np.linalg.norm(v[own] - v[np.roll(own, 1, axis=1)], axis=2)
    area = np.linalg.norm(np.cross(v[own[:, 1]] - v[own[:, 0]], v[own[:, 2]] - v[own[:, 0]]), axis=1) / 2
    quality = 16 * area**2 / np.maximum(sides.prod(axis=1) * sides.sum(axis=1), 1e-300)
    rms = [float(np.sqrt((d**2).mean()) / case.diameter * 1e3) for d in (there, back)]
    most = [float(d.max() / case.diameter * 1e3) for d in (there, back)]
    return {
        "rms": max(rms),
        "rms_patch_to_truth": rms[0],
        "rms_truth_to_mesh": rms[1],
        "max": max(most),
        "normal": float(angle),
        "seam": float(seam.mean()),
        "quality": float(quality.mean()),
        "edge": float(sides.mean()),
        "faces": int(patch.sum()),
    }


def compare(program, case):
    """The scores of all methods on a case, and the meshes."""
    meshes = {"truth": case.whole}
    scores = {"floor": score(case, *case.whole)}
    v, f, seconds, failed = quickest(lambda: fill_isomend(program, case), 2)
    patch = np.arange(len(f)) >= len(case.f)
    scores["isomend"] = score(case, v, f, patch) | {"seconds": seconds, "failed": failed}
    meshes["isomend"] = v, f, patch
    v, f, seconds, failed = fill_isomend(program, case, ("--energy", "curvature-variation", "--edge-ratio", 0.8))
    patch = np.arange(len(f)) >= len(case.f)
    scores["variation"] = score(case, v, f, patch) | {"seconds": seconds, "failed": failed}
    aim, longest = scores["isomend"]["edge"], scores["isomend"]["edge"] / 0.75
    for _ in range(4):
        v, f, patch, _ = triangulate(case, longest, True)
        longest *= aim / mean_edge(v, f[patch])
    for smooth in (False, True):
        v, f, patch, seconds = quickest(lambda: triangulate(case, longest, smooth), 3)  # noqa: B023
        for name in ("k2", "k2x10", "k3", "k3x10"):
            solves = 11 if "x" in name else 1
            moved, more = quickest(lambda: fair(case, v, f, int(name[1]), solves), 1)  # noqa: B023
            if moved is None:
                continue
            row = score(case, moved, f, patch) | {"seconds": seconds + more, "start": "smoothed" if smooth else "flat"}
            if name not in scores or row["rms"] < scores[name]["rms"]:
                scores[name] = row
                meshes[name] = moved, f, patch
    result = {"case": case.name, "diameter": case.diameter, "input_faces": len(case.f), "scores": scores}
    return result, meshes


# --- table and picture ----------------------------------------------------------------------------------------------


def table(rows):
    names = list(METHODS.values())
    lines = [
        "| hole | floor | " + " | ".join(names) + " | seconds: k = 3 × 10, isomend |",
        "|---|---:|" + "---:|" * len(names) + "---|",
    ]
    for row in rows:
        scores = row["scores"]
        best = min(scores[name]["rms"] for name in METHODS if name in scores)
        cells = []
        for name in METHODS:
            text = f"{scores[name]['rms']:.2f}" if name in scores else "failed"
            cells.append(f"**{text}**" if name in scores and scores[name]["rms"] == best else text)
        times = ", ".join(f"{scores[name]['seconds']:.2f}" if name in scores else "failed" for name in ("k3x10", "isomend"))
        lines.append(f"| {row['case']} | {scores['floor']['rms']:.2f} | {' | '.join(cells)} | {times} |")
    return "\n".join(lines)


def detailed(rows):
    """The table of all figures, with a row for each case and method."""
    lines = [
        "| hole | method | rms ‰ | largest ‰ | normal | seam | quality | edge | faces | seconds | start |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---|",
    ]
    for row in rows:
        for name in ("floor", *METHODS):
            if name not in row["scores"]:
                lines.append(f"| {row['case']} | {METHODS[name]} | failed |" + " |" * 8)
                continue
            s = row["scores"][name]
            lines.append(
                f"| {row['case']} | {METHODS.get(name, name)} | {s['rms']:.3f} | {s['max']:.2f} | {s['normal']:.2f}° "
                f"| {s['seam']:.1f}° | {s['quality']:.3f} | {s['edge']:.4g} | {s['faces']} "
                f"| {s['seconds'] if 'seconds' in s else float('nan'):.3f} | {s.get('start', '')} |"
            )
    return "\n".join(lines)


def summary(rows):
    """The number of cases in which each method is nearest to the truth."""
    wins = {}
    for row in rows:
        best = min((name for name in METHODS if name in row["scores"]), key=lambda name: row["scores"][name]["rms"])
        wins[METHODS[best]] = wins.get(METHODS[best], 0) + 1
    return wins


PICTURE = ["sphere 60°, fine", "sphere 60°, noise 3 %", "torus, outer, fine", "catenoid neck", "bunny, haunch"]
COLUMNS = ["truth", "k2", "k3", "k3x10", "isomend"]
LOWEST, HIGHEST = 0.1, 100.0


def towards(case):
    """The view of a case: the direction to the camera, and the direction that is up."""
    facing = case.truth.nearest(case.points)[1].mean(axis=0)
    axis = data.TURN @ [0, 0, 1]
    if np.linalg.norm(facing) < 0.3:
        return unit(np.cross(axis, [[0.2, 0.3, 1.0]]))[0], axis
    facing /= np.linalg.norm(facing)
    return facing + 0.55 * np.cross(facing, [0.3, 1, 0.2]), facing


def panel(case, v, f, patch, plain):
    """A picture of one mesh; the patch is coloured by the distance from the truth, unless `plain`."""
    import pyvista as pv

    plotter = pv.Plotter(off_screen=True, window_size=(400, 340))
    plotter.set_background("white")
    mesh = pv.PolyData.from_regular_faces(v, f[~patch])
    plotter.add_mesh(mesh, color="#dcdad6", ambient=0.2, diffuse=0.85, backface_params={"color": "#a09a90"})
    mesh = pv.PolyData.from_regular_faces(v, f[patch]).clean(tolerance=0)
    if plain:
        plotter.add_mesh(mesh, color="#b4c8de", ambient=0.2, diffuse=0.85)
    else:
        points = np.array(mesh.points, float)
        error = 1e3 * np.linalg.norm(points - case.truth.nearest(points)[0], axis=1) / case.diameter
        mesh["error"] = np.log10(np.clip(error, LOWEST, HIGHEST))
        plotter.add_mesh(mesh, scalars="error", cmap="turbo", clim=np.log10([LOWEST, HIGHEST]), show_scalar_bar=False, ambient=0.55, diffuse=0.5)
    rim = mesh.extract_feature_edges(boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False)
    plotter.add_mesh(rim, color="black", line_width=1.5, lighting=False)
    middle = case.points.mean(axis=0)
    view, up = towards(case)
    plotter.camera.focal_point = middle
    plotter.camera.position = middle + 6 * case.diameter * view / np.linalg.norm(view)
    plotter.camera.up = up
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 0.6 * case.diameter
    plotter.enable_anti_aliasing("ssaa")
    return plotter.screenshot(return_img=True)


def draw(chosen, target):
    """Draws the picture of some cases: a row for each case, a column for each method. Figures are in the table only."""
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt
    from matplotlib.colors import LogNorm
    from PIL import Image

    figure, axes = plt.subplots(len(chosen), len(COLUMNS), figsize=(11.2, 2.02 * len(chosen) + 0.9), squeeze=False)
    for number, (row, (case, meshes)) in enumerate(zip(axes, chosen)):
        for at, name in zip(row, COLUMNS):
            at.set_xticks([])
            at.set_yticks([])
            for spine in at.spines.values():
                spine.set_color("#cccccc")
            if name in meshes:
                at.imshow(panel(case, *meshes[name], name == "truth"), interpolation="lanczos")
            if number == 0:
                at.set_title(METHODS.get(name, name), fontsize=11)
        row[0].set_ylabel(case.name, fontsize=9.5)
    figure.subplots_adjust(left=0.03, right=0.995, top=0.965, bottom=0.075, wspace=0.02, hspace=0.03)
    bar = figure.add_axes((0.3, 0.042, 0.4, 0.012))
    shades = matplotlib.cm.ScalarMappable(LogNorm(LOWEST, HIGHEST), "turbo")
    figure.colorbar(shades, cax=bar, orientation="horizontal")
    bar.set_title("distance from the truth, 1/1000 of the hole's diameter", fontsize=8, pad=3)
    bar.tick_params(labelsize=8)
    figure.savefig(target, dpi=100)
    image = Image.open(target).convert("RGB").quantize(160, dither=Image.Dither.NONE)
    image.save(target, optimize=True)
    print(f"{target}: {Path(target).stat().st_size / 1000:.0f} kB")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--cases", default="", help="regular expression of the names of cases to run")
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--markdown", help="file for a table of all figures")
    parser.add_argument("--picture", help="file for the picture")
    parser.add_argument("--docs", action="store_true", help="write the table into docs/accuracy.md and draw data/libigl.png")
    arguments = parser.parse_args()
    rows, chosen = [], []
    for case in cases(arguments.cases):
        row, meshes = compare(arguments.isomend, case)
        rows.append(row)
        if case.name in PICTURE:
            chosen.append((case, meshes))
        print(detailed([row]).split("\n", 2)[2], flush=True)
    print("\n" + table(rows))
    print("nearest to the truth:", summary(rows))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    if arguments.markdown:
        Path(arguments.markdown).write_text(detailed(rows) + "\n")
    picture = arguments.picture or (ROOT / "data/libigl.png" if arguments.docs else None)
    if picture:
        draw(sorted(chosen, key=lambda entry: PICTURE.index(entry[0].name)), picture)
    if arguments.docs:
        renew("libigl", "compare_libigl.py", table(rows))


if __name__ == "__main__":
    main()
