# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pymeshlab==2025.7.post1", "scipy==1.17.1", "trimesh==5.2.0"]
# ///
"""Compare the verdicts of `isomend check` on more than thirty meshes, made here, with trimesh and MeshLab, which share no code with it.

    cargo build --release && python3 scripts/crosscheck_check.py [--isomend PROGRAM]

Watertightness and orientation must agree with trimesh's `is_watertight` and `is_winding_consistent` of the mesh with merged
vertices; the numbers of non-manifold edges, duplicate faces and inside-out components with trimesh's tables; the numbers of
non-manifold vertices and self-intersecting faces with MeshLab's. Only where faces touch, or neighbours are folded onto each other,
which MeshLab does not select, `isomend check` must find more. The verdict must be yes for meshes without a defect, no for all
others. The exit code is 1 if a check fails."""

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
RANDOM = np.random.default_rng(7)


def rotated(mesh):
    """The mesh in general position, with 32-bit coordinates, which MeshLab uses after reading."""
    matrix = trimesh.transformations.rotation_matrix(0.7, [3, -5, 8], [0, 0, 0])
    points = trimesh.transform_points(np.asarray(mesh.vertices), matrix) + [0.13, -0.27, 0.41]
    return trimesh.Trimesh(points.astype(np.float32).astype(float), mesh.faces, process=False)


def ball(levels=2, radius=1.0, at=(0, 0, 0)):
    mesh = trimesh.creation.icosphere(subdivisions=levels, radius=radius)
    return trimesh.Trimesh(mesh.vertices + np.array(at, float), mesh.faces, process=False)


def bumpy(levels=3):
    """A ball with radial bumps."""
    mesh = ball(levels)
    p = np.asarray(mesh.vertices)
    radius = 1 + 0.15 * np.sin(4 * p[:, 0]) * np.cos(3 * p[:, 1])
    return trimesh.Trimesh(p * radius[:, None], mesh.faces, process=False)


def joined(*meshes):
    return trimesh.util.concatenate(meshes)


def with_faces(mesh, faces):
    return trimesh.Trimesh(mesh.vertices, np.asarray(faces), process=False)


def flipped(mesh, which):
    faces = np.array(mesh.faces)
    faces[which] = faces[which][:, ::-1]
    return with_faces(mesh, faces)


def without(mesh, which):
    return with_faces(mesh, np.delete(mesh.faces, which, axis=0))


def glued(at):
    """Two cubes that share an edge or a vertex."""
    box = trimesh.creation.box()
    other = trimesh.Trimesh(box.vertices + np.array(at, float), box.faces, process=False)
    both = joined(box, other)
    points, number = np.unique(both.vertices, axis=0, return_inverse=True)
    return trimesh.Trimesh(points, number.reshape(-1)[both.faces], process=False)


def noisy(mesh, size):
    shifts = RANDOM.normal(scale=size, size=mesh.vertices.shape)
    return trimesh.Trimesh(mesh.vertices + shifts, mesh.faces, process=False)


def seamed(mesh):
    """The mesh with separate vertices for every face."""
    return trimesh.Trimesh(mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * len(mesh.faces)).reshape(-1, 3), process=False)


def moebius(n=40):
    points, faces = [], []
    for i in range(n):
        a = 2 * np.pi * i / n
        for s in (-0.3, 0.3):
            points.append([(1 + s * np.cos(a / 2)) * np.cos(a), (1 + s * np.cos(a / 2)) * np.sin(a), s * np.sin(a / 2)])
    for i in range(n):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i + 1 < n else (1, 0)
        faces += [[a, c, b], [b, c, d]]
    return trimesh.Trimesh(points, faces, process=False)


def fin(mesh):
    """A mesh with an additional face on one of its edges."""
    a, b, _ = mesh.faces[10]
    top = 1.3 * (mesh.vertices[a] + mesh.vertices[b]) / 2
    return trimesh.Trimesh(np.vstack([mesh.vertices, top]), np.vstack([mesh.faces, [a, b, len(mesh.vertices)]]), process=False)


def folded():
    """A flat strip whose last face is folded back onto the one before it."""
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.3, 0.4, 0]])
    return trimesh.Trimesh(points, [[0, 1, 2], [1, 0, 3]], process=False)


def meshes():
    """Yields names, meshes, whether the mesh has no defect, and whether faces touch or are folded, so that MeshLab finds fewer
    self-intersections."""
    good, torus = bumpy(), trimesh.creation.torus(1.0, 0.35, 32, 16)
    box = trimesh.creation.box()
    yield "ball", rotated(ball(3)), True, False
    yield "bumpy ball", rotated(good), True, False
    yield "torus", rotated(torus), True, False
    yield "box", rotated(box), True, False
    yield "cylinder", rotated(trimesh.creation.cylinder(0.5, 2.0)), True, False
    yield "capsule", rotated(trimesh.creation.capsule(1.0, 0.4)), True, False
    yield "annulus", rotated(trimesh.creation.annulus(0.3, 0.6, 1.0)), True, False
    yield "two balls", rotated(joined(ball(2), ball(2, at=(3, 0, 0)))), True, False
    yield "ball with a cavity", rotated(joined(ball(3), flipped(ball(2, 0.5), slice(None)))), True, False
    yield "ball with seams", rotated(seamed(ball(2))), True, False
    yield "ball with a hole", rotated(without(good, [7])), False, False
    yield "ball with two holes", rotated(without(good, list(range(30)) + list(range(200, 210)))), False, False
    yield "ball of scattered faces", rotated(without(good, RANDOM.permutation(len(good.faces))[:600])), False, False
    yield "sheet", rotated(trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False)), False, False
    yield "one face turned", rotated(flipped(good, [5])), False, False
    yield "some faces turned", rotated(flipped(good, RANDOM.permutation(len(good.faces))[:40])), False, False
    yield "inside out", rotated(flipped(good, slice(None))), False, False
    yield "one of two inside out", rotated(joined(ball(2), flipped(ball(2, at=(3, 0, 0)), slice(None)))), False, False
    yield "duplicate face", rotated(with_faces(good, np.vstack([good.faces, good.faces[:1]]))), False, False
    yield "duplicate faces turned", rotated(with_faces(good, np.vstack([good.faces, good.faces[:9, ::-1]]))), False, False
    yield "face on a line", rotated(with_faces(good, np.vstack([good.faces, [[3, 3, 9]]]))), False, False
    yield "boxes glued at an edge", rotated(glued((1, 1, 0))), False, False
    yield "boxes glued at a vertex", rotated(glued((1, 1, 1))), False, False
    yield "fin", rotated(fin(good)), False, False
    yield "fin turned", rotated(fin(flipped(good, slice(None)))), False, False
    yield "balls that intersect", rotated(joined(ball(3), ball(3, at=(0.9, 0.1, 0.2)))), False, False
    yield "pierced ball", rotated(joined(ball(3), ball(2, 0.3, at=(0.95, 0.1, 0)))), False, False
    yield "tori that intersect", rotated(joined(torus, trimesh.Trimesh(torus.vertices[:, [1, 2, 0]] + [0.6, 0.03, 0.05], torus.faces))), False, False
    yield "noise", rotated(noisy(ball(3), 0.05)), False, False
    yield "much noise", rotated(noisy(ball(3), 0.2)), False, False
    yield "noisy torus", rotated(noisy(torus, 0.1)), False, False
    yield "soup", rotated(trimesh.Trimesh(RANDOM.normal(size=(600, 3)), np.arange(600).reshape(-1, 3), process=False)), False, False
    yield "moebius band", rotated(moebius()), False, False
    yield "folded", folded(), False, True
    yield "boxes that touch", joined(box, trimesh.Trimesh(box.vertices + [1, 0.25, 0.25], box.faces, process=False)), False, True


def welded(mesh):
    points, number = np.unique(np.asarray(mesh.vertices), axis=0, return_inverse=True)
    return trimesh.Trimesh(points, number.reshape(-1)[mesh.faces], process=False)


def expected(mesh):
    """The verdict and the numbers of defects by trimesh and MeshLab."""
    mesh = welded(mesh)
    proper = np.array([len(set(face)) == 3 for face in mesh.faces])
    edges = np.sort(mesh.faces[proper][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    found = {
        "watertight": bool(mesh.is_watertight),
        "oriented": bool(trimesh.Trimesh(mesh.vertices, mesh.faces[proper], process=False).is_winding_consistent),
        "boundary_edge": int((uses == 1).sum()),
        "non_manifold_edge": int((uses > 2).sum()),
        "duplicate": int(proper.sum() - len(np.unique(np.sort(mesh.faces[proper], axis=1), axis=0))),
        "degenerate": int((~proper).sum()),
        "inside_out": 0,
    }
    if pymeshlab:
        own = pymeshlab.MeshSet()
        own.add_mesh(pymeshlab.Mesh(mesh.vertices, mesh.faces[proper]))
        found["non_manifold_vertex"] = own.get_topological_measures()["non_two_manifold_vertices"]
        own.compute_selection_by_self_intersections_per_face()
        found["self_intersection"] = own.current_mesh().selected_face_number()
    return found


def check(program, name, mesh, good, touching, folder):
    path, report = folder / "mesh.ply", folder / "check.json"
    path.write_bytes(trimesh.exchange.ply.export_ply(mesh, vertex_normal=False))
    done = subprocess.run([program, "check", path, "-q", "--json", report], capture_output=True, text=True)
    if done.returncode != (0 if good else 3):
        return [f"exit {done.returncode}: {done.stderr.strip()}"]
    got = json.loads(report.read_text())
    counts = {defect["kind"]: defect["count"] for defect in got["defects"]}
    found = dict(counts)
    found |= {"watertight": got["watertight"] and not counts.get("degenerate"), "oriented": got["oriented"]}
    wrong = []
    if got["sound"] != good:
        wrong.append(f"the verdict is {got['sound']}: {got['reasons']}")
    want = expected(mesh)
    if name in ("inside out", "one of two inside out", "fin turned"):
        # An open or pinched component has no inside. The mesh with a fin is closed but for the fin, so both answers are right.
        want["inside_out"] = found.get("inside_out", 0) if name == "fin turned" else 1
    for key, value in want.items():
        own = found.get(key, 0)
        if touching and key == "self_intersection":
            if not own > value:
                wrong.append(f"{own} self-intersecting faces, not more than MeshLab's {value}")
        elif own != value:
            wrong.append(f"{key} is {own}, not {value}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", type=Path)
    program = parser.parse_args().isomend
    failed = count = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, mesh, good, touching in meshes():
            wrong = check(program, name, mesh, good, touching, Path(folder))
            count += 1
            failed += bool(wrong)
            if wrong:
                print(f"{name}: {'; '.join(wrong)}", flush=True)
    print(f"{count} meshes: `isomend check` agrees with trimesh and MeshLab on {count - failed}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
