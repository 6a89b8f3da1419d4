# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6"]
# ///
"""Fill the analytic meshes of data/ and measure the patches against the exact surfaces.

    cargo build --release && python3 scripts/accuracy.py [--json FILE] [--docs]

Distances are from the patch to the exact surface, over points spread evenly on its faces, in 1/1000 of the hole's
diameter. 'floor' is this distance for the mesh's own faces round the hole, which are flat although the surface is curved.
With --docs the table is written into docs/accuracy.md, between the markers."""

import argparse
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from make_data import SHAPES, exact_distance  # noqa: E402
from tables import renew  # noqa: E402

TITLES = {
    "sphere": "sphere, cap of 60° removed",
    "island": "sphere, island in the hole",
    "torus": "Clifford torus, outer and inner hole",
    "catenoid": "catenoid, neck missing between two rims",
    "slab": "flat side of a box",
}


def read_ply(path):
    """Vertices and faces of a binary PLY of 32-bit floats."""
    data = Path(path).read_bytes()
    header, body = data.split(b"end_header\n", 1)
    n, m = (int(re.search(rf"element {kind} (\d+)".encode(), header)[1]) for kind in ("vertex", "face"))
    # Vertices of filled meshes have a fourth value: the expected error.
    width = 4 if b"isomend_sigma" in header else 3
    vertices = np.frombuffer(body, "<f4", width * n).reshape(n, width)[:, :3].astype(float)
    face = [("n", "u1"), ("v", "<i4", 3)]
    if b"property uchar isomend_patch" in header:
        face.append(("patch", "u1"))
    faces = np.frombuffer(body, np.dtype(face), m, 4 * width * n)
    return vertices, faces["v"].astype(int)


def spread(vertices, faces, count, rng):
    """Random points on the faces, spread evenly by area."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    pick = rng.choice(len(faces), count, p=area / area.sum())
    u, v = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    return np.einsum("nk,nkd->nd", weights, vertices[faces[pick]])


def measure(program, name):
    source = ROOT / "data" / f"{name}.ply"
    with tempfile.TemporaryDirectory() as folder:
        target = Path(folder) / "out.ply"
        command = [program, "fill", source, "-o", target, "--json", "-", "-q"]
        report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        vertices, faces = read_ply(target)
    own = report["faces"]
    diameter = max(region["diameter"] for region in report["regions"])
    if name == "torus":
        diameter = min(region["diameter"] for region in report["regions"])
    rng = np.random.default_rng(0)
    patch = exact_distance(name, spread(vertices, faces[own:], 200_000, rng)) / diameter
    rim = np.isin(faces[:own], np.unique(faces[own:])).any(axis=1)
    floor = exact_distance(name, spread(vertices, faces[:own][rim], 50_000, rng)) / diameter
    regions = report["regions"]
    return {
        "shape": name,
        "diameter": diameter,
        "patch_faces": len(faces) - own,
        "rms_per_mille": 1e3 * float(np.sqrt((patch**2).mean())),
        "max_per_mille": 1e3 * float(patch.max()),
        "floor_rms_per_mille": 1e3 * float(np.sqrt((floor**2).mean())),
        "seam_angle_mean": max(region["seam_angle_mean"] or 0.0 for region in regions),
        "quality_mean": min(region["quality_mean"] for region in regions),
        "seconds": report["seconds"],
    }


def table(rows):
    lines = [
        "| shape | patch faces | rms, ‰ | largest, ‰ | floor rms, ‰ | mean seam angle | quality | seconds |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in rows:
        lines.append(
            f"| {TITLES[row['shape']]} | {row['patch_faces']} | {row['rms_per_mille']:.2f} | {row['max_per_mille']:.2f} "
            f"| {row['floor_rms_per_mille']:.2f} | {row['seam_angle_mean']:.1f}° | {row['quality_mean']:.2f} "
            f"| {row['seconds']:.1f} |"
        )
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--json", help="file for all figures")
    parser.add_argument("--docs", action="store_true", help="write the table into docs/accuracy.md")
    arguments = parser.parse_args()
    rows = [measure(arguments.isomend, name) for name in SHAPES]
    print(table(rows))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    if arguments.docs:
        renew("accuracy", "accuracy.py", table(rows))


if __name__ == "__main__":
    main()
