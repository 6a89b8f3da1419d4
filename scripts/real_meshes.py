# /// script
# requires-python = ">=3.11"
# dependencies = ["libigl==2.6.3", "meshlib==3.1.4.297", "numpy==2.4.6", "pymeshlab==2025.7.post1", "pyvista==0.49.1"]
# ///
"""Fill holes cut out of real meshes with isomend, libigl and MeshLib, and compare isomend's expected errors with the distances.

    cargo build --release && uv run scripts/real_meshes.py [--isomend PROGRAM] [--json FILE] [--docs]

(or in any virtual environment with the packages of the first lines). The meshes come from the package pymeshlab: the Stanford
bunny, a bone, a cow. Balls of three sizes are cut out around farthest-point samples of the vertices, if they leave one simple
rim; the holes are the same in every run. The true surface is the faces that were cut out.

Distances are root mean squares in 1/1000 of the hole's diameter, the larger of patch to truth and truth to mesh, in geometric means.
libigl's fills (`igl.harmonic`, k = 2 and 3) move the vertices of MeshLib's triangulation, with edges as long as isomend's.
Curvedness: the mean angle between normals at the rim and their mean. Expected errors: the share of all new vertices whose distance
from the truth is less than isomend_sigma, and less than twice this value. --docs writes the tables into docs/accuracy.md."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
import compare_libigl as libigl  # noqa: E402
import make_data as data  # noqa: E402
from benchmark import cases as known  # noqa: E402
from tables import renew  # noqa: E402

TOOLS = {"isomend": "isomend", "k2": "libigl k = 2", "k3": "libigl k = 3", "meshlib": "MeshLib"}


def fill(program, case):
    """Fills a case with isomend; returns vertices, faces and the expected errors of vertices."""
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.ply", Path(folder) / "out.vtp"
        data.write_ply(source, case.v, case.f)
        seen = subprocess.run([program, "inspect", source, "--json", "-"], check=True, capture_output=True, text=True)
        holes = json.loads(seen.stdout)["holes"]
        wanted = min(holes, key=lambda h: (h["edges"] != case.rim, np.linalg.norm(np.array(h["centre"]) - case.centre)))
        command = [program, "fill", source, "-o", target, "--holes", str(wanted["id"]), "-q"]
        subprocess.run(command, check=True, capture_output=True)
        surface = pv.read(target)
    v, f = np.array(surface.points, float), surface.faces.reshape(-1, 4)[:, 1:].astype(np.int64)
    v[: len(case.v)] = case.v
    # A patch without new vertices has no expected errors.
    sigma = surface.point_data.get("isomend_sigma", np.zeros(len(v)))
    return v, f, np.asarray(sigma, float)


def measured(program, case):
    v, f, sigma = fill(program, case)
    patch = np.arange(len(f)) >= len(case.f)
    scores = {"isomend": libigl.score(case, v, f, patch)}
    new = np.arange(len(case.v), len(v))
    off = np.linalg.norm(v[new] - case.truth.nearest(v[new])[0], axis=1)
    known = np.isfinite(sigma[new]) & (sigma[new] > 0)
    below = [(off[known] < times * sigma[new][known]).tolist() for times in (1, 2)]
    # MeshLib closes every hole; only the hole that was cut is scored.
    aim = scores["isomend"]["edge"]
    longest = aim / 0.75
    for _ in range(3):
        tv, tf, marks, _ = libigl.triangulate(case, longest, False)
        longest *= aim / libigl.mean_edge(tv, tf[marks])
    for name, smooth, k in (("k2", False, 2), ("k3", False, 3), ("meshlib", True, None)):
        tv, tf, marks, _ = libigl.triangulate(case, longest, smooth)
        if k:
            tv, _ = libigl.fair(case, tv, tf, k, 1)
        if tv is None:
            continue
        own = marks & (np.linalg.norm(tv[tf].mean(axis=1) - case.centre, axis=1) < 2 * case.diameter)
        scores[name] = libigl.score(case, tv, tf, own)
    return {
        "case": case.name,
        "rim": case.rim,
        "curved": case.curved,
        "diameter": case.diameter,
        "scores": scores,
        "below": below,
    }


def mean(values):
    return float(np.exp(np.mean(np.log(np.maximum(values, 1e-4)))))


def tables(rows):
    kinds = {
        "all": lambda r: True,
        "rim of at most 25 edges": lambda r: r["rim"] <= 25,
        "of 26 to 60": lambda r: 25 < r["rim"] <= 60,
        "of more": lambda r: r["rim"] > 60,
        "curvedness below 12°": lambda r: r["curved"] < 12,
        "12° to 30°": lambda r: 12 <= r["curved"] < 30,
        "above": lambda r: r["curved"] >= 30,
    }
    lines = [f"| holes | number | {' | '.join(TOOLS.values())} |", "|---|---:|" + "---:|" * len(TOOLS)]
    for name, is_one in kinds.items():
        own = [r for r in rows if is_one(r) and all(t in r["scores"] for t in TOOLS)]
        if not own:
            continue
        values = [mean([r["scores"][t]["rms"] for r in own]) for t in TOOLS]
        cells = [f"**{x:.1f}**" if x == min(values) else f"{x:.1f}" for x in values]
        lines.append(f"| {name} | {len(own)} | {' | '.join(cells)} |")
    order = sorted(rows, key=lambda r: r["curved"])
    thirds = [order[: len(order) // 3], order[len(order) // 3 : 2 * len(order) // 3], order[2 * len(order) // 3 :]]
    sigma = ["| holes | vertices | nearer than σ | nearer than 2 σ |", "|---|---:|---:|---:|"]
    for name, own in zip(("all", "the flattest third", "the middle third", "the most curved third"), [order, *thirds]):
        one, two = (np.concatenate([r["below"][k] for r in own]) for k in (0, 1))
        sigma.append(f"| {name} | {len(one)} | {100 * one.mean():.0f} % | {100 * two.mean():.0f} % |")
    return "\n".join(lines), "\n".join(sigma)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--docs", action="store_true", help="write the tables into docs/accuracy.md")
    arguments = parser.parse_args()
    rows = []
    for case in known.real_cases(libigl.Triangles):
        row = measured(str(arguments.isomend), case)
        rows.append(row)
        found = "  ".join(f"{t} {row['scores'][t]['rms']:.2f}" for t in TOOLS if t in row["scores"])
        print(f"{row['case']:22} rim {row['rim']:4} curved {row['curved']:5.1f}  {found}", flush=True)
    real, sigma = tables(rows)
    print(f"\n{real}\n\n{sigma}")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows) + "\n")
    if arguments.docs:
        renew("real", "real_meshes.py", real)
        renew("sigma", "real_meshes.py", sigma)


if __name__ == "__main__":
    main()
