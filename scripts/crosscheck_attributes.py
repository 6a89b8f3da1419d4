# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pyvista==0.49.1", "scipy==1.17.1", "trimesh==5.2.0"]
# ///
"""Check with programs that share no code with isomend that attributes survive `isomend fill`.

    cargo build --release && python3 scripts/crosscheck_attributes.py [--isomend PROGRAM] [FILE.glb ...]

A coloured PLY, an OBJ with materials, a textured GLB with nested transforms, and VTK files with point and cell data are
made here, filled, and read again with trimesh or VTK: every value of the input must be unchanged. GLB files on the command
line are checked too. If node and the package gltf-validator (in .venv/node_modules) are installed, the Khronos validator must
find no errors in the GLB files. The exit code is 1 if a check fails."""

import argparse
import json
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np
import trimesh

from left_out import left_out

try:
    import pyvista as pv
except ImportError as error:
    pv = None
    left_out("VTK's checks", f"pyvista cannot be loaded ({error})")

ROOT = Path(__file__).resolve().parent.parent
VALIDATOR = ROOT / ".venv/node_modules/gltf-validator"
VALIDATE = """
const validator = require(process.argv[1]), fs = require('fs'), path = require('path');
const read = file => new Uint8Array(fs.readFileSync(file)), beside = path.dirname(process.argv[2]);
const externalResourceFunction = async uri => read(path.join(beside, decodeURIComponent(uri)));
validator.validateBytes(read(process.argv[2]), { externalResourceFunction }).then(report => {
  const errors = report.issues.messages.filter(m => m.severity === 0);
  console.log(JSON.stringify(errors.map(m => `${m.code} at ${m.pointer}: ${m.message}`)));
});
"""


def bowl():
    """A sphere without its top."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    keep = ball.triangles_center[:, 2] < 0.75
    bowl = trimesh.Trimesh(ball.vertices, ball.faces[keep], process=False)
    bowl.remove_unreferenced_vertices()
    bowl.vertices = np.asarray(bowl.vertices, np.float32).astype(float)
    return bowl


def fill(program, source, target):
    done = subprocess.run([program, "fill", source, "-o", target, "-q"], capture_output=True, text=True)
    return [f"exit {done.returncode}: {done.stderr.strip()[-200:]}"] if done.returncode else []


def check_ply(program, folder):
    mesh = bowl()
    n = len(mesh.vertices)
    rows = np.zeros(n, [("p", "<f4", 3), ("c", "u1", 4), ("quality", "<f8"), ("scan", "<i2")])
    rows["p"] = mesh.vertices
    rows["c"] = np.clip(128 + 100 * np.c_[mesh.vertices, np.ones(n)], 0, 255)
    rows["quality"], rows["scan"] = mesh.vertices[:, 0] / 3, np.arange(n) % 5
    faces = np.zeros(len(mesh.faces), [("n", "u1"), ("v", "<i4", 3), ("flags", "<u4")])
    faces["n"], faces["v"], faces["flags"] = 3, mesh.faces, np.arange(len(mesh.faces))
    names = ["float x", "float y", "float z"] + [f"uchar {c}" for c in ("red", "green", "blue", "alpha")]
    names += ["double quality", "short scan"]
    header = f"ply\nformat binary_little_endian 1.0\nelement vertex {n}\n"
    header += "".join(f"property {name}\n" for name in names)
    header += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nproperty uint flags\nend_header\n"
    source, target = folder / "in.ply", folder / "out.ply"
    source.write_bytes(header.encode() + rows.tobytes() + faces.tobytes())
    wrong = fill(program, source, target)
    if wrong:
        return wrong
    after = trimesh.load(target, process=False)
    raw = after.metadata["_ply_raw"]
    vertex, face = raw["vertex"]["data"], raw["face"]["data"]
    for name in ("quality", "scan"):
        if not np.array_equal(np.asarray(vertex[name]).reshape(-1)[:n], rows[name]):
            wrong.append(f"{name} changed")
    colours = np.asarray(after.visual.vertex_colors)
    if not np.array_equal(colours[:n], rows["c"]):
        wrong.append("colours changed")
    # On the missing cap x and y are nearly harmonic, so the continued colours are nearly these; z is not harmonic.
    ideal = 128 + 100 * np.asarray(after.vertices)[n:, :2]
    if np.abs(colours[n:, :2].astype(float) - ideal).max() > 12:
        wrong.append("colours of the patch do not continue the colours of the rim")
    marks = np.asarray(face["isomend_patch"]).reshape(-1)
    if not np.array_equal(marks, np.arange(len(after.faces)) >= len(faces)):
        wrong.append("the patch is not marked")
    if not np.array_equal(np.asarray(face["flags"]).reshape(-1)[: len(faces)], faces["flags"]):
        wrong.append("flags changed")
    return wrong


def check_vtk(program, folder, extension, binary):
    """Checks point and cell data, and which are active, as VTK reads them before and after."""
    mesh = bowl()
    n, m = len(mesh.vertices), len(mesh.faces)
    surface = pv.PolyData.from_regular_faces(np.asarray(mesh.vertices, np.float32), mesh.faces)
    surface.point_data.set_scalars(mesh.vertices[:, 2].copy(), "height")
    surface.point_data["heat of day"] = mesh.vertices[:, 0] / 3
    surface.point_data["scan"] = (np.arange(n) % 5).astype(np.int16)
    surface.point_data["paint"] = np.clip(128 + 100 * mesh.vertices, 0, 255).astype(np.uint8)
    surface.point_data["flow"] = mesh.vertices[:, ::-1].astype(np.float32)
    surface.point_data.active_normals = mesh.vertex_normals.astype(np.float32)
    surface.point_data.active_texture_coordinates = mesh.vertices[:, :2].astype(np.float32)
    surface.cell_data["id"] = np.arange(m)
    surface.cell_data.set_vectors(mesh.face_normals.copy(), "turn")
    source, target = folder / f"in.{extension}", folder / f"out.{extension}"
    surface.save(source, binary=binary)
    wrong = fill(program, source, target)
    if wrong:
        return wrong
    before, after = pv.read(source), pv.read(target)
    if not np.array_equal(before.points, after.points[:n]) or not np.array_equal(before.faces, after.faces[: 4 * m]):
        wrong.append("the surface changed")
    for kind, count in (("point_data", n), ("cell_data", m)):
        old, new = getattr(before, kind), getattr(after, kind)
        for name in old.keys():
            if name not in new or old[name].dtype != new[name].dtype or not np.array_equal(old[name], new[name][:count]):
                wrong.append(f"{name} changed")
        for what in ("scalars", "vectors", "normals", "texture_coordinates"):
            key = f"active_{what}_name"
            if getattr(old, key, None) != getattr(new, key, None):
                wrong.append(f"the active {what} are {getattr(new, key)}, not {getattr(old, key)}")
    if not np.array_equal(after.cell_data["isomend_patch"], np.arange(after.n_cells) >= m):
        wrong.append("the patch is not marked")
    ideal = after.points[n:, 0] / 3
    if np.abs(after.point_data["heat of day"][n:] - ideal).max() > 0.04:
        wrong.append("values of the patch do not continue the values of the rim")
    return wrong


def check_obj(program, folder):
    mesh = bowl()
    lines = ["mtllib skin.mtl"]
    lines += ["v {} {} {} {:.3f} 0.5 0.25".format(*p, abs(p[0])) for p in mesh.vertices]
    lines += ["vt {} {}".format(p[0], p[1]) for p in mesh.vertices]
    lines += ["vn {} {} {}".format(*p) for p in mesh.vertices]
    for part, faces in (("low", mesh.faces[::2]), ("high", mesh.faces[1::2])):
        lines += [f"g {part}", f"usemtl {part}"]
        lines += ["f " + " ".join(f"{v}/{v}/{v}" for v in face + 1) for face in faces]
    (folder / "skin.mtl").write_text("newmtl low\nKd 1 0 0\nnewmtl high\nKd 0 1 0\n")
    source, target = folder / "in.obj", folder / "out.obj"
    source.write_text("\n".join(lines) + "\n")
    wrong = fill(program, source, target)
    if wrong:
        return wrong
    pick = lambda path, word: [
        [float(t) if word in ("v", "vt", "vn") else t for t in line.split()[1:]]
        for line in path.read_text().splitlines()
        if line.split()[:1] == [word]
    ]
    for word in ("mtllib", "v", "vt", "vn", "f", "usemtl", "g"):
        before, after = pick(source, word), pick(target, word)
        if after[: len(before)] != before:
            wrong.append(f"'{word}' lines changed")
    old, new = (trimesh.load_scene(p, process=False, group_material=True) for p in (source, target))
    for part, mesh in old.geometry.items():
        kept = new.geometry[part]
        m = len(mesh.faces)
        if not np.array_equal(mesh.triangles, kept.triangles[:m]):
            wrong.append(f"trimesh finds other faces in {part}")
        if not np.array_equal(mesh.visual.uv[mesh.faces], kept.visual.uv[kept.faces[:m]]):
            wrong.append(f"trimesh finds other texture coordinates in {part}")
    if ["isomend_patch"] not in pick(target, "g"):
        wrong.append("the patch is no group")
    return wrong + check_materials(program, folder, source)


def check_materials(program, folder, source):
    """Checks colours, a texture and roughness of an OBJ file's materials after a conversion to GLB."""
    image = b"\x89PNG\r\n\x1a\n"
    rows = zlib.compress(b"\0\xff\0\0")
    for kind, data in ((b"IHDR", struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)), (b"IDAT", rows), (b"IEND", b"")):
        image += struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    (folder / "skin.png").write_bytes(image)
    (folder / "skin.mtl").write_text("newmtl low\nKd 1 0 0\nd 0.5\nNs 30\nnewmtl high\nKd 0 1 0\nmap_Kd skin.png\n")
    target = folder / "out-obj.glb"
    wrong = fill(program, source, target)
    if wrong:
        return wrong
    wrong += validate(target)
    scene = trimesh.load_scene(target, process=False)
    found = {mesh.visual.material.name: mesh.visual.material for mesh in scene.geometry.values()}
    low, high = found["low"], found["high"]
    if list(low.baseColorFactor) != [255, 0, 0, 128] or abs(low.roughnessFactor - 0.5) > 1e-6:
        wrong.append(f"trimesh finds the colour {low.baseColorFactor} and the roughness {low.roughnessFactor}")
    document, _ = chunks(target)
    if {"uri": "skin.png"} not in document["images"]:
        wrong.append("the texture is not named")
    return wrong


def chunks(path):
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def png():
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    head = struct.pack(">IIBBBBB", 2, 2, 8, 2, 0, 0, 0)
    pixels = zlib.compress(b"\0" + bytes([255, 0, 0, 0, 255, 0]) + b"\0" + bytes([0, 0, 255, 255, 255, 255]))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def make_glb(path, seam=False):
    """Two nodes use one textured mesh, whose texture has a seam through the hole or has none."""
    mesh = bowl()
    points, faces = np.asarray(mesh.vertices, "<f4"), mesh.faces.copy()
    uv = np.round(32767.5 * (points[:, :2] + 1)).astype("<u2")
    if seam:
        faces[mesh.triangles_center[:, 0] > 0] += len(points)
        points, uv = np.r_[points, points], np.r_[uv, uv // 2]
    n = len(points)
    normals = (points / np.linalg.norm(points, axis=1)[:, None]).astype("<f4")
    colours = np.clip(128 + 100 * np.c_[points, np.ones(n)], 0, 255).astype("u1")
    arrays = [
        (points, 5126, "VEC3", {"min": points.min(0).tolist(), "max": points.max(0).tolist()}),
        (normals, 5126, "VEC3", {}),
        (uv, 5123, "VEC2", {"normalized": True}),
        (colours, 5121, "VEC4", {"normalized": True}),
        (points[:, 0].copy(), 5126, "SCALAR", {}),
        (faces.astype("<u4").reshape(-1), 5125, "SCALAR", {}),
    ]
    data, views, accessors = b"", [], []
    for i, (array, component, kind, more) in enumerate(arrays):
        body = array.tobytes()
        target = 34963 if i == 5 else 34962
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(body), "target": target})
        accessors.append({"bufferView": i, "componentType": component, "count": len(array), "type": kind, **more})
        data += body + b"\0" * (-len(body) % 4)
    views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(png())})
    data += png() + b"\0" * (-len(png()) % 4)
    names = ["POSITION", "NORMAL", "TEXCOORD_0", "COLOR_0", "_DEPTH"]
    primitive = {"attributes": {k: i for i, k in enumerate(names)}, "indices": 5, "material": 0}
    root = {
        "asset": {"version": "2.0", "extras": {"of": "a test"}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [
            {"name": "root", "children": [1, 2], "scale": [0.01, 0.02, 0.01], "extras": {"a": [1, 2.5]}},
            {"name": "left", "mesh": 0, "translation": [-300, 0.1, 0], "rotation": [0, 0.6, 0, 0.8]},
            {"name": "right", "mesh": 0, "scale": [-1, 1, 1]},
        ],
        "meshes": [{"name": "bowl", "primitives": [primitive]}],
        "materials": [{"name": "skin", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071}],
        "images": [{"bufferView": 6, "mimeType": "image/png"}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
    path.write_bytes(head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def validate(path):
    if not shutil.which("node") or not VALIDATOR.is_dir():
        return []
    done = subprocess.run(["node", "-e", VALIDATE, str(VALIDATOR), str(path)], capture_output=True, text=True)
    if done.returncode:
        return [f"the validator fails: {done.stderr.strip()[-200:]}"]
    return json.loads(done.stdout)


def check_glb(program, source, folder):
    target = folder / f"out-{source.stem}.glb"
    wrong = fill(program, source, target) + (validate(target) if target.exists() else [])
    if wrong:
        return wrong
    before, data = chunks(source)
    after, new_data = chunks(target)
    if new_data[: len(data)] != data:
        wrong.append("the buffer does not begin as it did")
    for key in before:
        old, new = before[key], after.get(key)
        if key == "buffers":
            continue
        if key == "nodes":
            new = [{**node, "children": node.get("children", [])[: len(was.get("children", []))]} for node, was in zip(new, old)]
            new = [{k: v for k, v in node.items() if v != []} for node in new]
        elif isinstance(old, list) and isinstance(new, list):
            new = new[: len(old)]
        if key == "bufferViews":
            new, old = ([{"byteOffset": 0, **view} for view in views] for views in (new, old))
        if new != old:
            wrong.append(f"{key} changed")
    old, new = (trimesh.load(p, process=False) for p in (source, target))
    for name, mesh in old.geometry.items():
        kept = new.geometry[name]
        same = np.array_equal(mesh.vertices, kept.vertices) and np.array_equal(mesh.faces, kept.faces)
        uv = getattr(mesh.visual, "uv", None)
        same &= uv is None or np.array_equal(uv, kept.visual.uv)
        same &= np.array_equal(mesh.vertex_normals, kept.vertex_normals)
        same &= all(np.array_equal(v, kept.vertex_attributes[k]) for k, v in mesh.vertex_attributes.items())
        if not same:
            wrong.append(f"{name} changed")
    if not any(name.startswith("isomend_patch") for name in new.geometry):
        wrong.append("there is no patch")
    if source.stem == "seam" and len(after["images"]) != len(before["images"]) + 1:
        wrong.append("patches across a seam have no texels")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("files", nargs="*", type=Path, help="more GLB files with holes")
    arguments = parser.parse_args()
    if not shutil.which("node") or not VALIDATOR.is_dir():
        left_out("the glTF validator's checks", "they need node, and npm install --prefix .venv gltf-validator")
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        make_glb(folder / "made.glb")
        make_glb(folder / "seam.glb", seam=True)
        jobs = [("PLY", lambda: check_ply(arguments.isomend, folder)), ("OBJ", lambda: check_obj(arguments.isomend, folder))]
        for extension, binary in (("vtp", True), ("vtk", True), ("vtk", False)) if pv else ():
            job = lambda extension=extension, binary=binary: check_vtk(arguments.isomend, folder, extension, binary)
            jobs.append((f"{extension}{'' if binary else ', text'}", job))
        for path in [folder / "made.glb", folder / "seam.glb", *arguments.files]:
            jobs.append((path.name, lambda path=path: check_glb(arguments.isomend, path, folder)))
        for name, job in jobs:
            wrong = job()
            failures += bool(wrong)
            print(f"attributes of {name:12s} {'; '.join(wrong) or 'right'}", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
