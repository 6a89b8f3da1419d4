# /// script
# requires-python = ">=3.11"
# dependencies = ["meshio==5.3.5", "numpy==2.4.6", "pymeshlab==2025.7.post1", "pyvista==0.49.1", "scipy==1.17.1", "trimesh==5.2.0", "usd-core==26.11"]
# ///
"""Check that other programs read every format that isomend writes, with and without attributes.

    cargo build --release && python3 scripts/crosscheck_readers.py [--isomend PROGRAM] [--blender]

Meshes with and without normals, colours, texture coordinates and materials, some of them only on a part of the faces, are made here. Each
is filled and written in every format and form (text, binary). trimesh, meshio, VTK, MeshLab, OpenUSD and with --blender Blender (as the
Python module bpy) must read the same triangles at the same places; where a reader takes texture coordinates of PLY, they must be the written
ones, and Blender must read the texture coordinates, normals and colours of the input's faces. The exit code is 1 if a check fails."""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import trimesh

from blender_environment import python_with_blender
from left_out import left_out

ROOT = Path(__file__).resolve().parent.parent
# The formats that each program reads.
READ = {
    "trimesh": ["ply", "stl", "obj", "off", "glb", "gltf", "3mf"],
    # meshio reads neither poly data of VTK nor OFF with colours or normals.
    "meshio": ["ply", "stl", "obj"],
    "VTK": ["ply", "stl", "obj", "glb", "gltf", "vtk", "vtp"],
    "MeshLab": ["ply", "stl", "obj", "off", "glb", "gltf", "3mf"],
    "Blender": ["ply", "stl", "obj", "glb", "gltf", "usda", "usdz"],
    "OpenUSD": ["usda", "usdz"],
}
# What meshio misreads although it is valid: binary PLY with values of faces, text PLY with lists of numbers, OBJ with texture coordinates
# that are not as many as its points, and OBJ with colours.
MESHIO = {"ply": ("plain", "coloured", "values", "faces", "normals"), "obj": ("plain", "values", "faces", "normals")}
# Each written form: extension and further options.
FORMS = [(extension, ()) for extension in ("ply", "stl", "obj", "off", "glb", "gltf", "3mf", "vtk", "vtp", "usda", "usdz")]
FORMS += [(extension, ("--ascii",)) for extension in ("ply", "stl", "vtk")]
# Allowed distance of a corner: some readers keep 32-bit floats, and the meshes are about 1 in size.
NEAR = 1e-5
# Blender keeps colours in 8 bits, not evenly spaced, and normals in 16.
ROUNDED = 6e-3
BLENDER = """
import bpy, json, sys
import numpy as np
def back(values, kind):
    # Blender turns the axes of glTF; USD stages are turned by their objects only.
    return values[:, [0, 2, 1]] * [1, 1, -1] if kind in ('glb', 'gltf') else values
def read(name):
    kind = name.rsplit('.', 1)[1]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    if kind in ('glb', 'gltf'):
        bpy.ops.import_scene.gltf(filepath=name)
    elif kind == 'obj':
        bpy.ops.wm.obj_import(filepath=name, forward_axis='Y', up_axis='Z')
    elif kind == 'ply':
        bpy.ops.wm.ply_import(filepath=name)
    elif kind == 'stl':
        bpy.ops.wm.stl_import(filepath=name)
    else:
        bpy.ops.wm.usd_import(filepath=name)
    [mesh] = [thing.data for thing in bpy.data.objects if thing.type == 'MESH']
    mesh.calc_loop_triangles()
    loops = np.array([list(t.loops) for t in mesh.loop_triangles]).reshape(-1)
    vertices = np.array([loop.vertex_index for loop in mesh.loops])
    found = {'corners': back(np.array([v.co for v in mesh.vertices]), kind)[vertices[loops]]}
    if mesh.uv_layers:
        found['uv'] = np.array([d.uv for d in mesh.uv_layers[0].data])[loops]
    if mesh.has_custom_normals:
        found['normal'] = back(np.array([c.vector for c in mesh.corner_normals]), kind)[loops]
    if mesh.color_attributes:
        own = mesh.color_attributes[0]
        # Numbers of glTF and USD are taken as linear light.
        linear = kind in ('glb', 'gltf', 'usda', 'usdz')
        colours = np.array([(d.color if linear else d.color_srgb)[:3] for d in own.data])
        found['colour'] = (colours[vertices] if own.domain == 'POINT' else colours)[loops]
    return {what: values.reshape(-1, 3, values.shape[1]).tolist() for what, values in found.items()}
done = {}
for name in sys.argv[1:]:
    try:
        done[name] = read(name)
    except Exception as error:
        done[name] = f'{type(error).__name__}: {error}'
print('RESULT' + json.dumps(done))
"""


def bowl():
    """Points and faces of a sphere without its top."""
    ball = trimesh.creation.icosphere(subdivisions=2)
    bowl = trimesh.Trimesh(ball.vertices, ball.faces[ball.triangles_center[:, 2] < 0.75], process=False)
    bowl.remove_unreferenced_vertices()
    return np.asarray(bowl.vertices, np.float32).astype(float), bowl.faces


def obj(with_uv, with_normals, part):
    """An OBJ text; texture coordinates and normals stand on every face, or with `part` on every second one."""
    points, faces = bowl()
    lines = ["mtllib none.mtl"] + ["v %r %r %r" % tuple(p) for p in points.tolist()]
    lines += ["vt %r %r" % (0.5 + p[0] / 2, 0.5 + p[1] / 2) for p in points.tolist()]
    lines += ["vn %r %r %r" % tuple(p) for p in points.tolist()]
    for number, face in enumerate(faces + 1):
        bare = part and number % 2
        uv, normal = with_uv and not bare, with_normals and not bare
        if number == 10:
            lines.append("usemtl second")
        words = [f"{v}/{v if uv else ''}/{v if normal else ''}".rstrip("/") for v in face]
        lines.append("f " + " ".join(words))
    return "\n".join(lines) + "\n"


def ply(columns, face_columns=()):
    """A PLY text with further values of vertices and of faces: names, types and functions of the number."""
    points, faces = bowl()
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [f"property float {axis}" for axis in "xyz"] + [f"property {kind} {name}" for name, kind, _ in columns]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    head += [f"property {kind} {name}" for name, kind, _ in face_columns] + ["end_header"]
    rows = [" ".join([*map(repr, p), *(str(f(k)) for _, _, f in columns)]) for k, p in enumerate(points.tolist())]
    rows += [" ".join(["3", *map(str, face), *(str(f(k)) for _, _, f in face_columns)]) for k, face in enumerate(faces)]
    return "\n".join(head + rows) + "\n"


def inputs():
    colours = [(name, "uchar", lambda k: k % 256) for name in ("red", "green", "blue")]
    scan = [("scan", "int", lambda k: k), ("quality", "float", lambda k: k / 7)]
    yield "plain.ply", ply([])
    yield "coloured.ply", ply(colours)
    yield "values.ply", ply(scan, [("label", "int", lambda k: k % 3)])
    yield "faces.ply", ply([], colours)
    for name, options in {
        "uv": (True, False, False),
        "uv_part": (True, False, True),
        "normals": (False, True, False),
        "both": (True, True, False),
        "both_part": (True, True, True),
    }.items():
        yield f"{name}.obj", obj(*options)


def with_trimesh(path):
    scene = trimesh.load(path, process=False)
    return scene.to_mesh().triangles if isinstance(scene, trimesh.Scene) else scene.triangles


def with_meshio(path):
    import meshio

    mesh = meshio.read(path)
    blocks = [cells.data for cells in mesh.cells if cells.type == "triangle"]
    return mesh.points[np.concatenate(blocks)]


def is_for_meshio(path):
    """Whether meshio reads a file, if it is right; see MESHIO."""
    stems = MESHIO.get(path.suffix[1:])
    own = stems is None or path.name.split("_out")[0] in stems
    return own and (path.suffix != ".ply" or path.stem.endswith("_ascii"))


def with_vtk(path):
    import pyvista as pv

    mesh = pv.read(path)
    mesh = mesh.combine().extract_surface(algorithm=None) if isinstance(mesh, pv.MultiBlock) else mesh
    mesh = mesh.triangulate()
    return mesh.points[mesh.regular_faces]


def with_meshlab(path):
    import pymeshlab

    meshes = pymeshlab.MeshSet(verbose=False)
    meshes.load_new_mesh(str(path))
    corners = []
    for mesh in meshes:
        corners.append(mesh.transformed_vertex_matrix()[mesh.face_matrix()])
    return np.concatenate(corners)


def with_openusd(path):
    from pxr import Usd, UsdGeom

    # The stage must outlive its prims.
    stage = Usd.Stage.Open(str(path))
    corners = []
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            points = np.array(mesh.GetPointsAttr().Get())
            assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
            corners.append(points[np.array(mesh.GetFaceVertexIndicesAttr().Get()).reshape(-1, 3)])
            for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
                sizes = {"vertex": len(points), "uniform": len(corners[-1]), "faceVarying": 3 * len(corners[-1])}
                values = primvar.ComputeFlattened()
                assert len(values) == sizes[primvar.GetInterpolation()], primvar.GetName()
    return np.concatenate(corners)


READERS = {"trimesh": with_trimesh, "meshio": with_meshio, "VTK": with_vtk, "MeshLab": with_meshlab, "OpenUSD": with_openusd}


def difference(expected, found):
    """What is wrong with triangles that were read; nothing if they are the expected ones, each with any corner first."""
    found = np.asarray(found, float)
    if found.shape != expected.shape:
        return f"{len(found)} triangles instead of {len(expected)}"
    from scipy.spatial import cKDTree

    turned = np.concatenate([np.roll(found, k, axis=1).reshape(-1, 9) for k in range(3)])
    distance, _ = cKDTree(turned).query(expected.reshape(-1, 9))
    return "" if distance.max() < NEAR else f"a triangle is {distance.max():.1e} away"


def coordinates_of_ply(path):
    """What is wrong with the texture coordinates that trimesh reads from a PLY file of `uv.obj` and the like."""
    mesh = trimesh.load(path, process=False)
    uv = getattr(mesh.visual, "uv", None)
    if uv is None:
        return "trimesh finds no texture coordinates"
    # Half of the faces of `*_part` have none, and so have patches.
    expected = 0.5 + mesh.vertices[:, :2] / 2
    right = np.abs(uv - expected).max(axis=1) < NEAR
    return "" if right.sum() > len(right) / 3 else f"{right.sum()} of {len(right)} texture coordinates are right"


def expected_of(program, source, folder):
    """The triangles of a filled mesh, from a text that is read here."""
    target = folder / "expected.off"
    subprocess.run([program, "fill", source, "-o", target, "-q"], check=True, capture_output=True)
    rows = [line.split() for line in target.read_text().splitlines() if line.strip()]
    points, faces = int(rows[1][0]), int(rows[1][1])
    # Behind the coordinates and the corners other values may follow.
    values = np.array([row[:3] for row in rows[2 : 2 + points]], float)
    return values[np.array([row[1:4] for row in rows[2 + points :][:faces]], int)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--blender", action="store_true", help="read with Blender too; it is downloaded on first use")
    arguments = parser.parse_args()
    program = Path(arguments.isomend).resolve()
    readers = {}
    for name, read in READERS.items():
        module = {"VTK": "pyvista", "MeshLab": "pymeshlab", "OpenUSD": "pxr"}.get(name, name)
        try:
            __import__(module)
            readers[name] = read
        except ImportError as error:
            left_out(f"checks by {name}", f"{module} cannot be loaded ({error})")
    wrong, count = [], 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        written = []
        for name, text in inputs():
            source = folder / name
            source.write_text(text)
            expected = expected_of(program, source, folder)
            for extension, options in FORMS:
                target = folder / f"{source.stem}_out{''.join(options).replace('--', '_')}.{extension}"
                done = subprocess.run([program, "fill", source, "-o", target, "-q", *options], capture_output=True, text=True)
                if done.returncode:
                    wrong.append(f"{target.name}: exit {done.returncode}: {done.stderr.strip()[-200:]}")
                    continue
                written.append((target, expected))
        for target, expected in written:
            kind = target.suffix[1:]
            for name, read in readers.items():
                if kind not in READ[name] or name == "meshio" and not is_for_meshio(target):
                    continue
                count += 1
                try:
                    said = difference(expected, read(target))
                except (Exception, SystemExit) as error:  # Any failure of a reader is a result; meshio ends the program.
                    said = f"{type(error).__name__}: {str(error)[:200]}"
                if said:
                    wrong.append(f"{target.name} by {name}: {said}")
            if kind == "ply" and target.name.startswith(("uv", "both")) and "trimesh" in readers:
                count += 1
                said = coordinates_of_ply(target)
                wrong += [f"{target.name}: {said}"] if said else []
        if arguments.blender:
            count += by_blender(written, wrong)
    for line in wrong:
        print("FAILED", line)
    print(f"{count - len(wrong)} of {count} files were read by others as they were written")
    sys.exit(bool(wrong))


def values_by_blender(path, found):
    """What is wrong with the values of corners that Blender read; nothing if the faces of the input have their own."""
    kind, stem = path.suffix[1:], path.name.split("_out")[0]
    points, faces = bowl()
    corners = np.asarray(found["corners"])
    # Faces of the input, and their numbers.
    from scipy.spatial import cKDTree

    distance, number = cKDTree(points[faces].mean(axis=1)).query(corners.mean(axis=1))
    kept = distance < NEAR
    if stem.endswith("_part"):
        kept &= number % 2 == 0
    nearest = cKDTree(points).query(corners.reshape(-1, 3))[1].reshape(-1, 3)
    expected = {}
    # Blender reads texture coordinates of vertices from PLY, not of faces, and leaves normals of faces beside others without them.
    if stem.startswith(("uv", "both")) and kind not in ("ply", "stl"):
        expected["uv"] = 0.5 + corners[:, :, :2] / 2
    if stem in ("normals", "both") and kind != "stl":
        expected["normal"] = corners / np.linalg.norm(corners, axis=2, keepdims=True)
    if stem == "coloured" and kind != "stl":
        expected["colour"] = np.repeat((nearest % 256 / 255)[:, :, None], 3, axis=2)
    for what, values in expected.items():
        if what not in found:
            return f"no {what}"
        away = np.abs(np.asarray(found[what]) - values).max(axis=(1, 2))[kept]
        bad = int((away > ROUNDED).sum())
        if bad:
            return f"{what} of {bad} of {len(away)} faces are wrong, by up to {away.max():.3f}"
    return ""


def by_blender(written, wrong):
    """Reads with Blender; returns the number of checks."""
    python, reason = python_with_blender("numpy")
    if python is None:
        left_out("checks by Blender", reason)
        return 0
    own = {str(target): expected for target, expected in written if target.suffix[1:] in READ["Blender"]}
    done = subprocess.run([python, "-c", BLENDER, *own], capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
    if not lines:
        wrong.append(f"Blender: exit {done.returncode}: {done.stderr.strip()[-300:]}")
        return len(own)
    for name, found in json.loads(lines[0].removeprefix("RESULT")).items():
        path = Path(name)
        said = found if isinstance(found, str) else difference(own[name], found["corners"]) or values_by_blender(path, found)
        if said:
            wrong.append(f"{path.name} by Blender: {said}")
    return len(own)


if __name__ == "__main__":
    main()
