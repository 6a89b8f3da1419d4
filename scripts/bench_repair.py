# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pymeshfix==0.18.1", "pymeshlab==2025.7.post1", "pyvista==0.49.1", "scipy==1.17.1", "trimesh==5.2.0", "networkx==3.6.1"]
# ///
"""Compare the results of mesh repair: isomend, MeshFix (pymeshfix), MeshLab's repair filters (pymeshlab) and trimesh.

    cargo build --release && python3 scripts/bench_repair.py [--isomend PROGRAM] [--json FILE] [--seconds TIME] [--only PROGRAM]... [--docs] [FILE...]

Without files the meshes are made here: sound meshes with added defects, and meshes that pyvista ships. For each file and program the
table has: whether the result is watertight (trimesh's definition, after merging vertices at the same position), the number of faces that
intersect others (MeshLab's selection), the faces of the input that are not kept bit for bit in either orientation, the components of the
input that have lost all faces, the largest distance from the input's faces without defects to the result over the diagonal of the bounding
box, and seconds. A program that fails, or does not end within its time, has a dash. --docs writes a short table into docs/accuracy.md."""

import argparse
import itertools
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from tables import renew

ROOT = Path(__file__).resolve().parent.parent
OPTIONS = {
    "isomend": [],
    "isomend, borders too": ["--close-borders"],
    "isomend, largest part": ["--debris", "1", "--close-borders"],
}
# Twice the distance, over the edge length, by which isomend moves vertices of surfaces that it separates.
MOVED = 2e-3
METHODS = [*OPTIONS, "MeshFix", "MeshFix, all parts", "MeshLab", "trimesh"]


def load(path):
    """Positions and faces of a file, with vertices at the same position merged and without degenerate faces."""
    import trimesh

    if Path(path).suffix in (".vtk", ".vtp"):
        import pyvista

        surface = pyvista.read(path).triangulate()
        points, faces = np.asarray(surface.points), surface.faces.reshape(-1, 4)[:, 1:]
    else:
        mesh = trimesh.load(path, process=False, force="mesh")
        points, faces = np.asarray(mesh.vertices), np.asarray(mesh.faces)
    points = points.astype(np.float32).astype(float) + 0.0
    points, number = np.unique(points, axis=0, return_inverse=True)
    faces = number.reshape(-1)[faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points, faces[proper]


def save(path, points, faces):
    import trimesh

    mesh = trimesh.Trimesh(points, faces, process=False)
    Path(path).write_bytes(trimesh.exchange.ply.export_ply(mesh, vertex_normal=False))


def by_meshfix(source, target, all_parts):
    import pymeshfix

    points, faces = load(source)
    fixer = pymeshfix.MeshFix(points, faces.astype(np.int32))
    fixer.repair(joincomp=all_parts, remove_smallest_components=not all_parts)
    save(target, np.asarray(fixer.points), np.asarray(fixer.faces))


def by_meshlab(source, target):
    import pymeshlab

    points, faces = load(source)
    own = pymeshlab.MeshSet()
    own.add_mesh(pymeshlab.Mesh(points, faces))
    own.meshing_remove_duplicate_vertices()
    own.meshing_remove_duplicate_faces()
    own.meshing_remove_null_faces()
    own.meshing_repair_non_manifold_edges(method="Remove Faces")
    own.meshing_repair_non_manifold_vertices(vertdispratio=0.001)
    own.compute_selection_by_self_intersections_per_face()
    own.apply_selection_dilatation()
    own.meshing_remove_selected_faces()
    own.meshing_remove_unreferenced_vertices()
    own.meshing_repair_non_manifold_edges(method="Remove Faces")
    own.meshing_repair_non_manifold_vertices(vertdispratio=0.001)
    own.meshing_re_orient_faces_coherently()
    own.meshing_close_holes(maxholesize=100000, newfaceselected=False)
    mesh = own.current_mesh()
    save(target, mesh.vertex_matrix(), mesh.face_matrix())


def by_trimesh(source, target):
    import trimesh

    points, faces = load(source)
    mesh = trimesh.Trimesh(points, faces, process=True)
    mesh.update_faces(mesh.unique_faces())
    mesh.update_faces(mesh.nondegenerate_faces())
    trimesh.repair.fix_normals(mesh, multibody=True)
    trimesh.repair.fill_holes(mesh)
    save(target, mesh.vertices, mesh.faces)


def run(method, program, source, target, most):
    """Repairs a file in a separate process; returns the seconds, or none if it fails or needs more than `most` seconds."""
    if method.startswith("isomend"):
        command = [program, "repair", source, "-o", target, "-q", *OPTIONS[method]]
    else:
        command = [sys.executable, __file__, "--one", method, source, target]
    start = time.time()
    try:
        done = subprocess.run(command, capture_output=True, timeout=most)
    except subprocess.TimeoutExpired:
        return None
    return time.time() - start if done.returncode in (0, 3) and Path(target).exists() else None


def keys(points, faces):
    """For each face the sorted 32-bit positions of its corners."""
    corners = np.ascontiguousarray(points.astype(np.float32) + np.float32(0)).view(np.dtype((np.void, 12))).reshape(-1)
    return [b"".join(sorted(c.tobytes() for c in face)) for face in corners[faces]]


def lost_components(points, faces, kept, after, new):
    """The number of components of the input, and how many of them have lost all faces. A face counts as kept if its corners moved by less
    than MOVED times its longest edge, as they do where touching surfaces are separated."""
    import scipy.spatial
    import trimesh

    parts = trimesh.graph.connected_component_labels(trimesh.Trimesh(points, faces, process=False).face_adjacency, len(faces))
    count = len(np.unique(parts))
    rest = np.flatnonzero(~np.isin(parts, np.unique(parts[kept])))
    tree = scipy.spatial.cKDTree(after)
    known = {tuple(sorted(face)) for face in new.tolist()}
    found = set(parts[kept])
    for f in rest:
        corners = points[faces[f]]
        reach = MOVED * max(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1))
        near = tree.query_ball_point(corners, reach)
        if any(tuple(sorted(corners)) in known for corners in itertools.product(*near)):
            found.add(parts[f])
    return count, count - len(found)


def crossing(points, faces):
    import pymeshlab

    own = pymeshlab.MeshSet()
    own.add_mesh(pymeshlab.Mesh(points, faces))
    own.compute_selection_by_self_intersections_per_face()
    return own.current_mesh().face_selection_array()


def measured(source, target):
    import pymeshlab
    import trimesh

    points, faces = load(source)
    after, new = load(target)
    if not len(new):
        return None  # The result is empty.
    there = set(keys(after, new))
    kept = np.array([key in there for key in keys(points, faces)])
    components, lost = lost_components(points, faces, kept, after, new)
    bad = crossing(points, faces)
    touched = np.isin(faces, np.unique(faces[bad])).any(axis=1)
    pair = pymeshlab.MeshSet()
    pair.add_mesh(pymeshlab.Mesh(points, faces[~touched]))
    pair.add_mesh(pymeshlab.Mesh(after, new))
    far = pair.get_hausdorff_distance(sampledmesh=0, targetmesh=1, samplenum=200_000, sampleface=True, maxdist=pymeshlab.PercentageValue(100))
    return {
        "watertight": bool(trimesh.Trimesh(after, new, process=False).is_watertight),
        "crossing": int(crossing(after, new).sum()),
        "faces": len(faces),
        "lost": int((~kept).sum()),
        "lost_components": lost,
        "components": components,
        "distance": far["max"] / float(np.linalg.norm(np.ptp(points, axis=0))),
    }


def made(folder):
    """Yields the files to repair: sound meshes with added defects, and meshes that pyvista ships."""
    import pyvista
    import trimesh

    random = np.random.default_rng(5)
    ball = trimesh.creation.icosphere(subdivisions=4)
    points, faces = np.asarray(ball.vertices), np.asarray(ball.faces)
    small = trimesh.creation.icosphere(subdivisions=3, radius=0.3)
    torus = trimesh.creation.torus(1.0, 0.4, 64, 32)
    flipped = faces.copy()
    which = random.permutation(len(faces))[:200]
    flipped[which] = flipped[which][:, ::-1]
    box = trimesh.creation.box(extents=[1, 1, 1]).subdivide().subdivide().subdivide()

    def both(p, f, q, g):
        return np.vstack([p, q]), np.vstack([f, g + len(p)])

    def block(low, high, other=False):
        """A box of twelve faces, its sides divided along one diagonal or the other."""
        unit = np.array([[i & 1, i >> 1 & 1, i >> 2] for i in range(8)])
        sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        halves = [((a, b, d), (b, c, d)) if other else ((a, b, c), (a, c, d)) for a, b, c, d in sides]
        return np.where(unit, high, low).astype(float), np.array(halves).reshape(-1, 3)

    def joined(parts):
        start = np.cumsum([0, *(len(p) for p, _ in parts)])
        return np.vstack([p for p, _ in parts]), np.vstack([f + s for (_, f), s in zip(parts, start)])

    cube = block((0, 0, 0), (1, 1, 1))
    post = trimesh.creation.cylinder(radius=0.3, height=1, sections=48)
    other = np.random.default_rng(8)
    corners = other.integers(0, 8, (100, 3))
    heap = [block(low, low + size, way) for low, size, way in zip(corners, other.integers(1, 4, (100, 3)), other.integers(0, 2, 100))]

    cases = {
        "ball, faces turned": (points, flipped),
        "ball, faces missing": (points, np.delete(faces, random.permutation(len(faces))[:150], axis=0)),
        "ball, duplicate faces": (points, np.vstack([faces, faces[:300, ::-1]])),
        "pierced ball": both(points, faces, small.vertices + [0.95, 0.1, 0.05], small.faces),
        "pierced torus": both(torus.vertices, torus.faces, small.vertices + [1.0, 0.1, 0.4], small.faces),
        "balls that cross": both(points, faces, points + [1.1, 0.1, 0.2], faces),
        "boxes glued at an edge": both(box.vertices, box.faces, box.vertices + [1, 1, 0], box.faces),
        "cubes side to side": joined([cube, block((1, 0, 0), (2, 1, 1), True)]),
        "cubes, part of a side": joined([cube, block((1, 0.5, 0.25), (2, 1.5, 1.25))]),
        "stack of slabs": joined([block((0, 0, 0.1 * i), (1, 1, 0.1 * (i + 1)), i % 2) for i in range(20)]),
        "boss on a plate": joined([block((-1, -1, -1), (1, 1, 0)), (post.vertices + [0, 0, 0.5], post.faces)]),
        "cube in a cube's corner": joined([block((0, 0, 0), (4, 4, 4)), cube]),
        "doubled ball": both(points, faces, points, faces),
        "cubes round an edge": joined([cube, block((1, 1, 0), (2, 2, 1)), block((0, 1, 1), (1, 2, 2))]),
        "heap of boxes on a grid": joined(heap),
        "noisy ball": (points + random.normal(scale=0.012, size=points.shape), faces),
    }
    files = []
    for name, (p, f) in cases.items():
        files.append(folder / f"{name}.ply")
        save(files[-1], p, f)
    shipped = Path(pyvista.examples.dir_path)
    return files + [shipped / name for name in ("airplane.ply", "nut.ply", "ant.ply") if (shipped / name).exists()]


def row(file, method, seconds, found):
    if found is None:
        return f"| {file} | {method} | – | – | – | – | – | – |"
    yes = "yes" if found["watertight"] else "no"
    return (
        f"| {file} | {method} | {yes} | {found['crossing']} | {found['lost']} of {found['faces']} | "
        f"{found['lost_components']} of {found['components']} | {found['distance']:.1e} | {seconds:.1f} |"
    )


def cell(r):
    """The result of one program on one file, as the text of a cell."""
    if r["found"] is None:
        return "–"
    faults = [] if r["found"]["watertight"] else ["open"]
    if r["found"]["crossing"]:
        faults.append(f"{r['found']['crossing']} cross")
    gone = f" ({r['found']['lost_components']})" if r["found"]["lost_components"] else ""
    return "; ".join([*filter(None, [", ".join(faults)]), f"{r['found']['lost']}{gone}", f"{r['seconds']:.1f} s"])


def table(rows):
    """A row for each file, a column for each program."""
    methods = [m for m in METHODS if m != "isomend, borders too" and any(r["method"] == m for r in rows)]
    lines = [f"| mesh | faces | {' | '.join(methods)} |", "|---|---:|" + "---|" * len(methods)]
    for file in dict.fromkeys(r["file"] for r in rows):
        own = {r["method"]: r for r in rows if r["file"] == file}
        faces = next((r["found"]["faces"] for r in own.values() if r["found"]), "–")
        lines.append(f"| {Path(file).stem} | {faces} | {' | '.join(cell(own[m]) for m in methods)} |")
    sums = []
    for method in methods:
        own = [r for r in rows if r["method"] == method and r["found"]]
        good = sum(r["found"]["watertight"] and r["found"]["crossing"] == 0 for r in own)
        lost, gone = (sum(r["found"][key] for r in own) for key in ("lost", "lost_components"))
        sums.append(f"{good} closed, none cross; {lost} lost, {gone} components; {sum(r['seconds'] for r in own):.1f} s")
    return "\n".join([*lines, f"| all | | {' | '.join(sums)} |"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--seconds", type=float, default=900, help="time limit of a program for a file")
    parser.add_argument("--only", action="append", choices=METHODS, help="program to run [default: all]; may be given several times")
    parser.add_argument("--docs", action="store_true", help="write a short table into docs/accuracy.md")
    parser.add_argument("--one", nargs=3, metavar=("METHOD", "IN", "OUT"), help=argparse.SUPPRESS)
    parser.add_argument("files", nargs="*", type=Path)
    args = parser.parse_args()
    if args.one:
        method, source, target = args.one
        if method.startswith("MeshFix"):
            by_meshfix(source, target, "all" in method)
        else:
            {"MeshLab": by_meshlab, "trimesh": by_trimesh}[method](source, target)
        return
    rows, methods = [], args.only or METHODS
    print("| file | program | watertight | intersecting | faces lost | components lost | distance | seconds |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for source in args.files or made(folder):
            for i, method in enumerate(methods):
                target = folder / f"out{i}.ply"
                target.unlink(missing_ok=True)
                seconds = run(method, args.isomend, source, target, args.seconds)
                found = None if seconds is None else measured(source, target)
                print(row(source.name, method, seconds, found), flush=True)
                rows.append({"file": source.name, "method": method, "seconds": seconds, "found": found})
    for method in methods:
        own = [r["found"] for r in rows if r["method"] == method and r["found"]]
        good = sum(f["watertight"] and f["crossing"] == 0 for f in own)
        print(f"{method}: {good} of {len(rows) // len(methods)} files watertight without self-intersections; "
              f"{sum(f['lost'] for f in own)} faces and {sum(f['lost_components'] for f in own)} components lost")
    if args.docs:
        renew("repair", "bench_repair.py", table(rows))
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
