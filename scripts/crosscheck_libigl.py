# /// script
# requires-python = ">=3.11"
# dependencies = ["libigl==2.6.3", "numpy==2.4.6", "pymeshlab==2025.7.post1", "pyvista==0.49.1"]
# ///
"""Check distances, signs and curvature with libigl and MeshLab, which share no code with isomend.

    cargo build --release && python3 scripts/crosscheck_libigl.py [--isomend PROGRAM]

Distances that `isomend sdf --f64` writes at the nodes of lattices with odd voxel sizes must equal libigl's to 1e-5 of a voxel,
on closed and open meshes, on triangle soups, and far from the origin. Nodes must be inside where the magnitude of libigl's winding
number, exact and fast, exceeds one half; nodes where it is within 0.05 of one half are left out. Signed distances of mended files
must equal MeshLab's, and the bending energy of `isomend compare` must agree with the mean curvatures that MeshLab measures. The
exit code is 1 if a check fails."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from left_out import left_out

try:
    import igl
    import pyvista as pv
except ImportError as error:
    left_out("libigl's checks", error)
    sys.exit(0)
try:
    import pymeshlab
except ImportError as error:
    pymeshlab = None
    left_out("MeshLab's checks", f"pymeshlab cannot be loaded ({error}); on Debian, apt install libgl1 libopengl0")

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "scripts"))
from make_data import write_ply  # noqa: E402

DATA = ["sphere.ply", "island.ply", "torus.ply", "catenoid.ply", "slab.ply", "scan.ply", "sheet.obj"]
DISTANCE, MARGIN = 1e-5, 0.05


def read(path):
    """Vertices (32-bit coordinates) and triangles of a file, read by VTK."""
    mesh = pv.read(path)
    return np.array(mesh.points, float), np.array(mesh.faces, np.int64).reshape(-1, 4)[:, 1:]


def made(folder):
    """Makes files with triangle soups, nested shells, reversed orientation, flat meshes, and meshes far from the origin."""
    rng = np.random.default_rng(3)
    v, f = read(ROOT / "data/sphere.ply")
    corners = rng.normal(size=(120, 1, 3)) + 0.4 * rng.normal(size=(120, 3, 3))
    meshes = {
        "soup": (corners.reshape(-1, 3), np.arange(360).reshape(-1, 3)),
        "shells": (np.vstack([v, 0.6 * v]), np.vstack([f, f[:, ::-1] + len(v)])),
        "overlap": (np.vstack([v, v + [0.7, 0.2, 0.1]]), np.vstack([f, f + len(v)])),
        "inside out": (v, f[:, ::-1]),
        "flat": (v * [1, 1, 0.01], f),
        "far": (v + [1e4, -2e4, 3e4], f),
    }
    for name, (points, faces) in meshes.items():
        path = folder / f"{name}.ply"
        faces = np.ascontiguousarray(faces)
        write_ply(path, points, faces, double=True)
        yield path, points, faces


def run(program, *arguments):
    done = subprocess.run([str(a) for a in (program, *arguments, "-q")], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()[-200:]}")
    return done.stdout


def volume(program, source, folder, voxel, *more):
    """Runs `isomend sdf`; returns the nodes and values of its volume."""
    target = folder / "volume.vti"
    run(program, "sdf", source, "-o", target, "--voxel", repr(float(voxel)), "--f64", *more)
    grid = pv.read(target)
    # Computed from origin and spacing, which are 64-bit floats; VTK's points are 32-bit.
    index = np.indices(grid.dimensions[::-1]).reshape(3, -1)[::-1].T
    return np.array(grid.origin) + index * np.array(grid.spacing), np.array(grid["distance"])


def check_distances(program, source, folder, v, f):
    rng = np.random.default_rng(sum(map(ord, source.name)))
    size = np.ptp(v, axis=0).max()
    wrong, furthest, nodes, signs = [], 0.0, 0, 0
    for cells, band in ((rng.uniform(20, 35), None), (rng.uniform(35, 60), None), (rng.uniform(50, 70), 4.0)):
        voxel = size / cells
        points, values = volume(program, source, folder, voxel, *(("--band", band * voxel) if band else ()))
        # Half of the nodes anywhere, half near the surface, where wrong signs are most likely.
        near = np.flatnonzero(np.abs(values) < 2 * voxel)
        pick = np.concatenate([rng.choice(len(points), 6000), rng.choice(near, 6000)])
        points, values = np.ascontiguousarray(points[pick]), values[pick]
        distance = np.sqrt(igl.point_mesh_squared_distance(points, v, f)[0])
        if band:
            distance = np.minimum(distance, band * voxel)
        error = np.abs(np.abs(values) - distance).max() / voxel
        furthest, nodes = max(furthest, error), nodes + len(pick)
        if error > DISTANCE:
            wrong.append(f"distances differ by {error:.1e} voxels")
        for kind, winding in (("exact", igl.winding_number), ("fast", igl.fast_winding_number)):
            some = slice(None) if kind == "fast" else slice(None, None, 4)
            # Centred, as the fast winding number is less exact far from the origin.
            number = np.abs(winding(v - v.mean(axis=0), f, points[some] - v.mean(axis=0))).ravel()
            clear = (np.abs(number - 0.5) > MARGIN) & (distance[some] > DISTANCE * voxel)
            signs += int(clear.sum())
            bad = int(((values[some] < 0) != (number > 0.5))[clear].sum())
            if bad:
                wrong.append(f"{bad} of {clear.sum()} signs differ from the {kind} winding number")
    return wrong, f"{nodes} nodes to {furthest:.0e} voxels, {signs} signs"


def check_mended(program, source, folder):
    """Compares signed distances and curvature of a filled mesh with MeshLab's."""
    target = folder / "mended.ply"
    run(program, "fill", source, "-o", target)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(target))
    wrong = []
    v, f = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix().astype(np.int64)
    voxel = np.ptp(v, axis=0).max() / 47.3
    points, values = volume(program, target, folder, voxel)
    near = np.random.default_rng(4).choice(np.flatnonzero(np.abs(values) < 6 * voxel), 20_000)
    meshes.add_mesh(pymeshlab.Mesh(points[near]))
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=True)
    theirs = meshes.current_mesh().vertex_scalar_array()
    # MeshLab takes the sign from one nearest face, which can be wrong at edges and corners, where several faces are nearest.
    signs = np.mean((theirs < 0) == (values[near] < 0))
    # MeshLab's search in a grid sometimes misses the nearest face, and its distance is then larger.
    larger = (np.abs(theirs) - np.abs(values[near])) / voxel
    if larger.min() < -1e-5 or np.mean(larger > 1e-5) > 1e-3:
        wrong.append(f"distances differ from MeshLab's by {larger.min():.1e} to {larger.max():.1e} voxels")
    if signs < 0.995:
        wrong.append(f"{100 * (1 - signs):.2f} % of the signs differ from MeshLab's")
    meshes.set_current_mesh(0)
    meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Mean Curvature")
    mean = meshes.current_mesh().vertex_scalar_array()
    area = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    theirs = 0.5 * ((2 * mean) ** 2 * area).sum()
    vector = np.linalg.norm(igl.cotmatrix(v, f) @ v, axis=1)
    libigl = 0.5 * (vector**2 / area).sum()
    ours = json.loads(run(program, "compare", source, target, "--json", "-"))["b"]["willmore_energy"]
    for who, energy, part in (("MeshLab", theirs, 1e-3), ("libigl", libigl, 1e-9)):
        if abs(ours / energy - 1) > part:
            wrong.append(f"energy {ours:.8g}, by {who}'s curvatures {energy:.8g}")
    return wrong, f"energy {ours:.6g}, signs {100 * signs:.2f} %"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    program = parser.parse_args().isomend
    failures = total = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        jobs = [("distance", path, check_distances, *read(path)) for path in (ROOT / "data" / name for name in DATA)]
        jobs += [("distance", path, check_distances, v, f) for path, v, f in made(folder)]
        if pymeshlab:
            jobs += [("mended", ROOT / "data" / name, check_mended) for name in DATA if name != "sheet.obj"]
        for kind, path, check, *mesh in jobs:
            try:
                wrong, text = check(program, path, folder, *mesh)
            except RuntimeError as error:
                wrong, text = [str(error)], ""
            failures, total = failures + bool(wrong), total + 1
            print(f"{kind:8s} {path.name:14s} {'; '.join(wrong) or 'right: ' + text}", flush=True)
    print(f"{total - failures} of {total} checks with libigl are right")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
