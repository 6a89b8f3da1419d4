# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pymeshlab==2025.7.post1", "scipy==1.17.1", "trimesh==5.2.0"]
# ///
"""Fill the meshes of data/ and check the written files with trimesh and MeshLab, which share no code with isomend.

    cargo build --release && python3 scripts/crosscheck.py [--isomend PROGRAM]

Every file must be watertight, manifold, consistently oriented, of the right Euler number and volume and free of
self-intersections, and hold the input's vertices and faces first, in order and bit for bit (STL keeps the triangles).
VTK files, which neither program reads, are first converted to PLY by isomend. The distances of `isomend compare` between
input and output must agree with MeshLab's Hausdorff filter, within the error of sampling. The exit code is 1 if a check
fails."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from left_out import left_out

try:
    import pymeshlab
except ImportError as error:
    pymeshlab = None
    left_out("MeshLab's checks", f"pymeshlab cannot be loaded ({error}); on Debian, apt install libgl1 libopengl0")

ROOT = Path(__file__).resolve().parent.parent
FORMATS = ["ply", "obj", "stl", "gltf", "glb", "vtk", "vtp", "off"]
TEXT = ["ply", "stl", "vtk"]
# name: Euler number of the filled mesh, its volume (None: not known)
CASES = {
    "sphere": (2, 4 / 3 * np.pi),
    "island": (2, 4 / 3 * np.pi),
    "torus": (0, 2 * np.pi**2 * np.sqrt(2)),
    "catenoid": (2, None),
    "slab": (2, 8 * 1.0 * 0.8 * 0.5),
    "scan": (2, None),
}


def load(path, kind=None):
    return trimesh.load(path, file_type=kind, process=False, force="mesh", maintain_order=True)


def welded(mesh):
    """The mesh with vertices at equal positions merged."""
    points, number = np.unique(np.asarray(mesh.vertices), axis=0, return_inverse=True)
    return trimesh.Trimesh(points, number.reshape(-1)[mesh.faces], process=False)


def check_trimesh(mesh, original, euler, volume, kind):
    wrong = []
    joined = welded(mesh)
    if not joined.is_watertight:
        wrong.append("not watertight")
    if not joined.is_winding_consistent:
        wrong.append("not consistently oriented")
    if joined.euler_number != euler:
        wrong.append(f"Euler number {joined.euler_number}, not {euler}")
    if not joined.volume > 0:
        wrong.append(f"volume {joined.volume:.4g}")
    if volume and abs(joined.volume / volume - 1) > 0.02:
        wrong.append(f"volume {joined.volume:.4f}, not {volume:.4f}")
    n, m = len(original.vertices), len(original.faces)
    corners = np.asarray(original.vertices)[original.faces]
    if kind == "stl":
        # Text files have the shortest decimals that round to these 32-bit floats.
        if not np.array_equal(np.asarray(mesh.vertices, np.float32)[mesh.faces[:m]], corners.astype(np.float32)):
            wrong.append("the input's triangles are not kept")
    else:
        if not np.array_equal(np.asarray(mesh.vertices)[:n], np.asarray(original.vertices)):
            wrong.append("the input's vertices are not kept")
        if not np.array_equal(mesh.faces[:m], original.faces):
            wrong.append("the input's faces are not kept")
    return wrong, joined


def check_meshlab(joined):
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(joined.vertices, joined.faces))
    measures = meshes.get_topological_measures()
    wrong = [
        f"{measures[key]} {key.replace('_', ' ')}"
        for key in ("boundary_edges", "non_two_manifold_edges", "non_two_manifold_vertices")
        if measures[key]
    ]
    meshes.compute_selection_by_self_intersections_per_face()
    crossing = meshes.current_mesh().selected_face_number()
    return wrong + ([f"{crossing} faces intersect others"] if crossing else [])


def run(program, *arguments):
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        return f"exit {done.returncode}: {done.stderr.strip()[-200:]}"
    return None


def check(program, name, suffix, options, folder):
    """Checks one output; returns a list of what is wrong."""
    euler, volume = CASES[name]
    source = ROOT / "data" / f"{name}.ply"
    target = Path(folder) / f"{name}.{suffix}"
    failed = run(program, "fill", source, "-o", target, "-q", *options)
    if failed:
        return [failed]
    kind = suffix
    if suffix in ("vtk", "vtp"):
        back = target.with_suffix(".back.ply")
        failed = run(program, "fill", target, "-o", back, "-q", "--holes", "all")
        if failed:
            return [failed]
        target, kind = back, "ply"
    wrong, joined = check_trimesh(load(target), load(source), euler, volume, kind)
    return wrong + (check_meshlab(joined) if pymeshlab else [])


def check_compare(program, name, folder):
    """Checks that isomend and MeshLab measure the same distances from the filled mesh to the input, and that the whole input is kept."""
    source, target = ROOT / "data" / f"{name}.ply", Path(folder) / f"{name}.ply"
    report = Path(folder) / "compare.json"
    # Enough samples to find the largest distance, which can be inside a large face, within a hundredth.
    failed = run(program, "compare", source, target, "-q", "--samples", "1000000", "--json", report)
    if failed:
        return [failed]
    got = json.loads(report.read_text())
    meshes = pymeshlab.MeshSet()
    for path in (source, target):
        meshes.load_new_mesh(str(path))
    common = dict(sampledmesh=1, targetmesh=0, samplenum=400_000, sampleface=True)
    spread = meshes.get_hausdorff_distance(samplevert=False, **common)
    corners = meshes.get_hausdorff_distance(samplevert=True, **common)
    wrong = []
    for ours, theirs, part in (
        ("rms", spread["RMS"], 0.02),
        ("mean", spread["mean"], 0.02),
        ("max", corners["max"], 0.01),
    ):
        if abs(got["b_to_a"][ours] - theirs) > part * theirs:
            wrong.append(f"{ours} distance {got['b_to_a'][ours]:.6g}, MeshLab {theirs:.6g}")
    kept, first = got["kept"], got["a"]
    if kept["faces_in_order"] != first["faces"] or kept["vertices_in_order"] != first["vertices"]:
        wrong.append(f"not all of the input is kept: {kept}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    program = parser.parse_args().isomend
    jobs = [(name, "ply", []) for name in CASES]
    jobs += [("scan", suffix, []) for suffix in FORMATS if suffix != "ply"]
    jobs += [("scan", suffix, ["--ascii"]) for suffix in TEXT]
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, suffix, options in jobs:
            wrong = check(program, name, suffix, options, folder)
            failures += bool(wrong)
            print(f"{name:9s} {suffix:5s} {' '.join(options):8s} {'; '.join(wrong) or 'right'}", flush=True)
        for name in CASES if pymeshlab else ():
            wrong = check_compare(program, name, folder)
            failures += bool(wrong)
            print(f"{name:9s} {'compare':14s} {'; '.join(wrong) or 'right'}", flush=True)
    total = len(jobs) + (len(CASES) if pymeshlab else 0)
    print(f"{total - failures} of {total} checks are right")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
