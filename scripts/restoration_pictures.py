# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pillow==13.0.0", "pymeshlab==2025.7.post1", "pyvista==0.49.1"]
# ///
"""Draw the pictures of docs/restoration.md and docs/formats.md: data/piece.png, implant.png, counterpart.png, grain.png,
expected.png, texels.png.

    cargo build --release && python3 scripts/restoration_pictures.py [--isomend PROGRAM] [--out DIR] [NAME...]

The bust is made by bust.py. The vase is a surface of revolution, painted in
four charts of one texture. The script makes both, damages them, and calls isomend. No display is needed."""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pymeshlab
import pyvista as pv
from bust import ball, bump, bust, join
from PIL import Image, ImageDraw, ImageFont, ImageOps

ROOT = Path(__file__).resolve().parent.parent
GREY, ORANGE, BACK, BREAK = (205, 207, 211), (240, 140, 50), (150, 140, 130), (226, 84, 72)
COLOURS, STRIP = 256, 26  # of a file; pixels above a panel, for its title
CROWN = (0.75, -0.9, 0.65)


def surface(f, edge, turn=0.0):
    """A mesh of an implicit function's zero set with edges of that length; the grid is turned by an angle about z."""
    c, s = np.cos(turn), np.sin(turn)
    frame = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    coarse = np.stack(np.meshgrid(*[np.linspace(-1.95, 1.35, 44)] * 3, indexing="ij"), -1) + (0.3, 0.3, 0)
    values = np.kron(f(coarse @ frame), np.ones((3, 3, 3)))
    near = np.nonzero(np.abs(values) < 0.2)
    step = 1.1 / 43
    start = coarse[0, 0, 0] - step
    values[near] = f((start + np.stack(near, -1) * step) @ frame)
    grid = pv.ImageData(dimensions=values.shape, spacing=[step] * 3, origin=start)
    grid["f"] = values.ravel(order="F")
    found = grid.contour([0.0], scalars="f").triangulate().connectivity("largest")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(found.points, float) @ frame, found.faces.reshape(-1, 4)[:, :0:-1]))
    meshes.meshing_isotropic_explicit_remeshing(iterations=6, targetlen=pymeshlab.PureValue(edge), featuredeg=180.0)
    v, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    for _ in range(3):  # Newton steps onto the zero set
        slope = np.stack([(f(v + e) - f(v - e)) / 2e-4 for e in 1e-4 * np.eye(3)], -1)
        v = v - np.clip(f(v) / np.maximum((slope**2).sum(-1), 0.05), -0.03, 0.03)[:, None] * slope
    return v, faces


def without(v, faces, *balls):
    """The mesh without the faces in the balls, each a centre and a radius."""
    inside = np.any([np.linalg.norm(v - at, axis=1) < radius for at, radius in balls], axis=0)
    used, index = np.unique(faces[~inside[faces].all(axis=1)], return_inverse=True)
    return v[used], index.reshape(-1, 3)


def save(path, v, faces, marked=None):
    """Writes a PLY file; marked vertices are red."""
    colours = None if marked is None else np.where(marked[:, None], (255, 0, 0), 200).astype(np.uint8)
    pv.PolyData.from_regular_faces(v.astype(np.float32), faces).save(path, texture=colours)


def isomend(program, *words):
    subprocess.run([program, *map(str, words), "-q"], check=True)


def panel(layers, towards, middle, scale, size, title):
    """A picture of layers, each a mesh with the options of add_mesh; `scale` is half the height that is seen."""
    plotter = pv.Plotter(off_screen=True, window_size=[2 * x for x in size], lighting="none")
    plotter.set_background("white")
    for mesh, options in layers:
        plotter.add_mesh(mesh, **{"ambient": 0.12, "specular": 0.12, "show_scalar_bar": False, "backface_params": {"color": BACK}} | options)
    towards = np.array(towards) / np.linalg.norm(towards)
    side = np.cross((0, 0, 1), towards)
    plotter.camera_position = [np.array(middle) + 9 * towards, middle, (0, 0, 1)]
    plotter.camera.parallel_projection, plotter.camera.parallel_scale = True, scale
    for direction, intensity in ((towards - 1.0 * side + (0, 0, 0.9), 0.8), (towards + 1.2 * side, 0.45)):
        plotter.renderer.add_light(pv.Light(position=np.array(middle) + 9 * direction, focal_point=middle, intensity=intensity))
    image = Image.fromarray(plotter.screenshot(return_img=True)).resize(size, Image.Resampling.LANCZOS)
    plotter.close()
    whole = ImageOps.expand(image, (0, STRIP, 0, 0), "white")
    ImageDraw.Draw(whole).text((size[0] / 2, STRIP / 2), title, "black", ImageFont.load_default(16), anchor="mm")
    return whole


def sheet(path, images):
    """Panels side by side."""
    whole = Image.fromarray(np.hstack([np.asarray(image) for image in images]))
    whole.quantize(COLOURS, dither=Image.Dither.NONE, kmeans=2).save(path, optimize=True)
    print(f"{path}: {whole.size}, {path.stat().st_size / 1000:.0f} kB", flush=True)


def plain(mesh, colour=GREY):
    return mesh, {"color": colour}


def painted(mesh, cells, colour):
    """A mesh of which some cells, or vertices, have another colour; `cells` is a mask."""
    return mesh, {"scalars": np.where(cells[:, None], colour, GREY).astype(np.uint8), "rgb": True}


def piece(program, folder, target):
    """A break that is painted red, the whole with stripes, and the piece alone."""
    at = np.array([0.42, -0.68, 0.76])

    def chipped(p):
        rough = sum(0.012 * np.sin(k * (p @ np.array(d)) + k) for k, d in ((14, (1, 0.4, 0.2)), (19, (-0.3, 1, 0.5)), (23, (0.2, -0.5, 1))))
        return np.maximum(bust(p), 0.36 - np.linalg.norm(p - at, axis=-1) + rough)

    v, f = surface(chipped, 0.03)
    marked = bust(v) < -0.01
    save(folder / "scan.ply", v, f, marked)
    words = "restore", folder / "scan.ply", "-o", folder / "whole.ply", "--colour", "ff0000", "--grow", 0.04
    isomend(program, *words, "--piece", folder / "piece.stl", "--mark", "hatch")
    scan, whole, alone = (pv.read(folder / name) for name in ("scan.ply", "whole.ply", "piece.stl"))
    views = CROWN, (0.0, 0.0, -0.1), 1.25, (210, 270)
    layers = painted(scan, marked, BREAK), (whole, {"scalars": "RGB", "rgb": True})
    images = [panel([x], *views, title) for x, title in zip(layers, ("break, painted", "--mark hatch"))]
    views = ((-0.1, -1.0, 1.0), "--piece"), ((-1.0, 0.5, -0.3), "its inside")
    sheet(target, images + [panel([plain(alone, ORANGE)], towards, alone.center, 0.42, (210, 270), title) for towards, title in views])


def implant(program, folder, target):
    """A hole through a shell: the break, the shell closed on both sides, and the implant from outside and from within."""

    def shell(p):
        outer = ball(p, (0, 0.06, 0.2), (0.7, 0.84, 0.86)) - 0.02 * bump(np.abs(p[..., :1]) * (1, 0, 0) + p * (0, 1, 1), (0.4, -0.3, 0.8), 0.4)
        inner = ball(p, (0, 0.06, 0.17), (0.61, 0.75, 0.75))
        return np.maximum(np.maximum(outer, -inner), -0.3 - p[..., 2])

    def broken(p):
        rough = sum(0.012 * np.sin(k * (p @ np.array(d)) + k) for k, d in ((14, (1, 0.4, 0.2)), (19, (-0.3, 1, 0.5)), (23, (0.2, -0.5, 1))))
        return -join(-shell(p), np.linalg.norm(p - at, axis=-1) - 0.4 - rough, 0.03)

    at = np.array([0.42, -0.3, 0.82])
    save(folder / "skull.ply", *surface(broken, 0.022))
    words = "restore", folder / "skull.ply", "-o", folder / "whole.vtp", "--ball", "0.42,-0.3,0.82,0.48", "--apart"
    isomend(program, *words, "--piece", folder / "implant.stl", "--clearance", 0.01)
    scan, whole, alone = (pv.read(folder / name) for name in ("skull.ply", "whole.vtp", "implant.stl"))
    views = CROWN, (0.0, 0.0, 0.25), 0.95, (210, 250)
    layers = plain(scan), painted(whole, whole.cell_data["isomend_patch"] > 0, ORANGE)
    images = [panel([x], *views, title) for x, title in zip(layers, ("break", "--apart"))]
    views = (CROWN, "--piece"), ((-0.75, 0.6, -0.9), "its inside")
    sheet(target, images + [panel([plain(alone, ORANGE)], towards, alone.center, 0.52, (210, 250), title) for towards, title in views])


def counterpart(program, folder, target):
    """An ear that is broken off: open, filled smoothly, filled with the shape of the other side, and as it was."""
    v, f = surface(bust, 0.028, 0.5)
    save(folder / "scan.ply", *without(v, f, ((0.72, 0.03, 0.02), 0.4)))
    for name, words in (("smooth", ()), ("like", ("--like", "mirror"))):
        isomend(program, "fill", folder / "scan.ply", "-o", folder / f"{name}.ply", *words)
    scan, *whole = (pv.read(folder / f"{name}.ply") for name in ("scan", "smooth", "like"))
    layers = [plain(scan)] + [painted(mesh, np.arange(mesh.n_cells) >= scan.n_cells, ORANGE) for mesh in whole]
    layers.append(plain(pv.PolyData.from_regular_faces(v, f)))
    views = (1.0, -0.45, 0.15), (0.1, 0.02, -0.1), 1.12, (210, 280)
    sheet(target, [panel([x], *views, title) for x, title in zip(layers, ("hole", "fill", "--like mirror", "as it was"))])


def grain(program, folder, target):
    """A rough surface with a hole, filled without and with roughness."""
    random = np.random.default_rng(5)
    waves = [(random.normal(size=3), random.uniform(0, 6.3)) for _ in range(60)]
    waves = [(w / np.linalg.norm(w) * 6.3 / random.uniform(0.06, 0.25), phase) for w, phase in waves]

    v, f = surface(lambda p: bust(p) + 0.0022 * sum(np.cos(p @ w + phase) for w, phase in waves), 0.02)
    v = v + 0.0025 * random.normal(size=(len(v), 1)) * pv.PolyData.from_regular_faces(v, f).point_normals
    at = np.array([0.45, -0.42, -1.4])
    save(folder / "scan.ply", *without(v, f, (at, 0.3)))
    for name, words in (("smooth", ()), ("rough", ("--grain",))):
        isomend(program, "fill", folder / "scan.ply", "-o", folder / f"{name}.ply", *words)
    layers = [plain(pv.read(folder / f"{name}.ply")) for name in ("scan", "smooth", "rough")]
    views = (0.5, -0.8, 0.45), at + (0, 0, 0.06), 0.42, (280, 250)
    sheet(target, [panel([x], *views, title) for x, title in zip(layers, ("hole", "fill", "fill --grain"))])


def expected(program, folder, target):
    """Expected errors of patches, and where twice these are within a tolerance."""
    v, f = surface(bust, 0.03)
    holes = ((0.3, -0.55, 0.85), 0.34), ((0.43, -0.62, -0.22), 0.17), ((0.27, -0.8, 0.12), 0.16), ((0.2, -0.35, -1.35), 0.25), ((0.74, 0.05, 0), 0.3)
    save(folder / "scan.ply", *without(v, f, *holes))
    isomend(program, "fill", folder / "scan.ply", "-o", folder / "whole.vtp")
    whole = pv.read(folder / "whole.vtp")
    patch = whole.cell_data["isomend_patch"] > 0
    error = whole.point_data["isomend_sigma"][whole.faces.reshape(-1, 4)[:, 1:]].mean(axis=1)
    rest, new, limit = whole.extract_cells(~patch), whole.extract_cells(patch), 0.03
    colours = np.where((2 * error[patch] <= limit)[:, None], (120, 178, 120), (205, 60, 60)).astype(np.uint8)
    layers = {"cmap": "YlOrRd", "clim": (0, limit), "scalars": error[patch]}, {"scalars": colours, "rgb": True}
    titles = f"expected error: yellow 0, red {limit}", f"within --tolerance {limit}: green, beyond: red"
    views = (0.55, -1.0, 0.2), (0, 0, -0.35), 1.6, (350, 400)
    sheet(target, [panel([plain(rest), (new, look)], *views, title) for look, title in zip(layers, titles)])


def paint(turn, height):
    """The colours of the vase, by the angle in turns and the height from 0 to 1."""
    clay, black, white = np.array([[196, 98, 52], [44, 36, 34], [236, 214, 178.0]])
    wave = np.abs(height - 0.52 - 0.07 * np.sin(12 * np.pi * turn))
    dots = np.hypot((12 * turn + 0.5) % 1 - 0.5, 7 * (height - 0.83))
    # Each is painted over the ones before, where its value is positive; values are about in heights.
    layers = [(black, 0.0125 - np.abs(height - at)) for at in (0.3125, 0.7325)] + [(black, np.abs(height - 0.505) - 0.425)]
    layers += [(black, 0.08 + 0.2 * np.abs(np.cos(12 * np.pi * turn)) - height), (black, 0.045 - wave), (white, 0.012 - wave), (black, (0.34 - dots) / 7)]
    image = np.broadcast_to(clay, (*turn.shape, 3))
    for colour, value in layers:
        part = 1 / (1 + np.exp(-np.clip(250 * value, -40, 40)))[..., None]
        image = image * (1 - part) + colour * part
    return image


def vase(folder):
    """Writes the vase with holes, vase.obj, with its texture of four charts beside each other."""
    columns, rows, side, gap = 40, 110, 256, 0.02
    height = np.linspace(0, 1, rows + 1)
    radius = 0.34 + 0.3 * np.sin(np.pi * np.clip(0.1 + 0.86 * height, 0, 1)) ** 1.6 + 0.1 * np.exp(-(((height - 1) / 0.07) ** 2))
    angle = 2 * np.pi * np.arange(4 * columns) / (4 * columns)
    around = np.stack([np.cos(angle), np.sin(angle), 0 * angle], 1)
    v = (radius[:, None, None] * around + 1.5 * height[:, None, None] * (0, 0, 1)).reshape(-1, 3)
    holes = ((0.0, 0.54, 0.13), (0.0, 0.3, 0.1), (0.99, 0.85, 0.11), (0.985, 0.13, 0.09))
    middles = [v[round(h * rows) * len(angle) + round(t * len(angle)) % len(angle)] for t, h, _ in holes]
    inside = np.any([np.linalg.norm(v - middle, axis=1) < hole[2] for middle, hole in zip(middles, holes)], axis=0)
    head, lines = ["mtllib vase.mtl"] + ["v {:.6f} {:.6f} {:.6f}".format(*p) for p in v], ["usemtl clay"]
    i, j = (x.ravel() for x in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    for chart in range(4):
        across = (chart + gap + (1 - 2 * gap) * np.arange(columns + 1) / columns) / 4
        head += [f"vt {x:.6f} {gap + (1 - 2 * gap) * y:.6f}" for y in height for x in across]
        for corners in (((0, 0), (0, 1), (1, 1)), ((0, 0), (1, 1), (1, 0))):
            at = [(i + a) * len(angle) + (chart * columns + j + b) % len(angle) for a, b in corners]
            texel = [(chart * (rows + 1) + i + a) * (columns + 1) + j + b for a, b in corners]
            kept = ~inside[np.stack(at)].all(axis=0)
            lines += ["f {}/{} {}/{} {}/{}".format(*k) for k in (np.stack([x for p in zip(at, texel) for x in p], 1)[kept] + 1).tolist()]
    (folder / "vase.obj").write_text("\n".join([*head, *lines, ""]))
    (folder / "vase.mtl").write_text("newmtl clay\nKd 1 1 1\nmap_Kd vase.png\n")
    x, y = np.meshgrid((np.arange(4 * side) + 0.5) / side, 1 - (np.arange(2 * side) + 0.5) / (2 * side))
    x, y = np.floor(x) / 4 + ((x % 1) - gap) / (1 - 2 * gap) / 4, (y - gap) / (1 - 2 * gap)
    Image.fromarray(paint(x, y).round().astype(np.uint8)).save(folder / "vase.png")


def textured(path):
    """The layers of an OBJ file: one for each material, with its texture."""
    values, faces = {"v": [], "vt": []}, {}
    for kind, *words in (line.split() for line in path.read_text().splitlines() if line):
        if kind == "usemtl":
            corners = faces.setdefault(words[0], [])
        elif kind in values:
            values[kind].append([float(x) for x in words[: 4 - len(kind)]])
        elif kind == "f":
            corners += [[int(i or 1) - 1 for i in (w + "/").split("/")[:2]] for w in words]
    layers = []
    for name, corners in faces.items():
        place, texel = np.array(corners).T
        mesh = pv.PolyData.from_regular_faces(np.array(values["v"])[place], np.arange(len(place)).reshape(-1, 3))
        mesh.active_texture_coordinates = np.array(values["vt"])[texel]
        image = path.with_name("vase.png" if name == "clay" else f"{path.stem}_isomend.png")
        layers.append((mesh, {"texture": pv.read_texture(image), "ambient": 0.3}) if image.exists() else plain(mesh, (170, 170, 172)))
    return layers


def texels(program, folder, target):
    """A painted vase with holes across the seams of its texture, filled without texels and with."""
    vase(folder)
    for name, words in (("plain", ("--no-texture",)), ("whole", ())):
        isomend(program, "fill", folder / "vase.obj", "-o", folder / f"{name}.obj", "--max-diameter", 0.5, *words)
    views = (1, 0.25, 0.15), (0, 0, 0.74), 0.86, (270, 340)
    titles = {"vase": "holes across seams", "plain": "fill --no-texture", "whole": "fill"}
    sheet(target, [panel(textured(folder / f"{name}.obj"), *views, title) for name, title in titles.items()])


def main():
    pictures = {p.__name__: p for p in (piece, implant, counterpart, grain, expected, texels)}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help="the pictures [default: all]")
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--out", type=Path, default=ROOT / "data", help="folder for the pictures")
    arguments = parser.parse_args()
    for name in arguments.names or pictures:
        with tempfile.TemporaryDirectory() as folder:
            pictures[name](arguments.isomend.resolve(), Path(folder), arguments.out / f"{name}.png")


if __name__ == "__main__":
    main()
