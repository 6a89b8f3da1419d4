# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pillow==13.0.0", "pyvista==0.49.1", "scikit-image==0.26.0"]
# ///
"""Draw data/generated.png: a double-skinned body cut open, before and after `isomend repair --solid`.

    cargo build --release && uv run scripts/generated_picture.py [--isomend PROGRAM] [--out FILE.png]

The body is a ball with a rod through it; its skins are the surface where the distance to the body's surface is one and a tenth of a
voxel, with three pinholes. Patches are orange. No display is needed."""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv
from PIL import Image
from skimage.measure import marching_cubes

ROOT = Path(__file__).resolve().parent.parent
NODES = 72
PANEL = 400, 400  # pixels
COLOURS = 96
GREY, ORANGE, CUT = "#d3d6da", "#f0943c", "#8fa9c8"
PINHOLES = np.array([[0.6, 0.0, 0.12], [-0.5, 0.25, -0.2], [0.0, -0.25, 0.9]])
TOWARDS = np.array([-0.35, -1.0, 0.3])


def double_skin():
    """Vertices and faces of the body's two skins."""
    x = np.linspace(-1.3, 1.3, NODES)
    p = np.stack(np.meshgrid(x, x, x, indexing="ij"), -1)
    h = x[1] - x[0]
    rod = np.maximum(np.hypot(p[..., 0], p[..., 1]) - 0.25, np.abs(p[..., 2]) - 1.0)
    sheet = np.abs(np.minimum(rod, np.linalg.norm(p, axis=-1) - 0.6))
    for centre in PINHOLES:
        sheet = np.maximum(sheet, 3.2 * h - np.linalg.norm(p - centre, axis=-1))
    v, f, _, _ = marching_cubes(sheet, 1.1 * h)
    return v * h + x[0], f


def panel(v, f, patch):
    """A picture of a solid with its front half cut away; the cut is filled."""
    plotter = pv.Plotter(off_screen=True, window_size=[2 * side for side in PANEL], lighting="none")
    plotter.set_background("white")
    for faces, colour in ((f[~patch], GREY), (f[patch], ORANGE)):
        if len(faces):
            mesh = pv.PolyData.from_regular_faces(v, faces).clip(normal="y", origin=(0, 0, 0), invert=False)
            plotter.add_mesh(mesh, color=colour, smooth_shading=False, ambient=0.45, diffuse=0.65)
    whole = pv.PolyData.from_regular_faces(v, f)
    section = whole.slice(normal="y", origin=(0, 0, 0)).strip()
    plotter.add_mesh(section.triangulate_contours(), color=CUT, lighting=False)
    direction = TOWARDS / np.linalg.norm(TOWARDS)
    plotter.camera.position = 8 * direction
    plotter.camera.focal_point = (0, 0, 0)
    plotter.camera.up = (0, 0, 1)
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 1.12
    for place, intensity in ((direction + np.array([0.7, 0, 0.8]), 0.75), (direction - np.array([0.9, 0, 0.1]), 0.4)):
        light = pv.Light(position=8 * place, focal_point=(0, 0, 0), intensity=intensity)
        light.positional = False
        plotter.renderer.add_light(light)
    plotter.enable_anti_aliasing("ssaa")
    image = Image.fromarray(plotter.screenshot(return_img=True))
    plotter.close()
    return image.resize(PANEL, Image.Resampling.LANCZOS)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--out", type=Path, default=ROOT / "data/generated.png", help="file for the picture")
    options = parser.parse_args()
    v, f = double_skin()
    with tempfile.TemporaryDirectory() as folder:
        before, after = Path(folder) / "before.ply", Path(folder) / "after.ply"
        pv.PolyData.from_regular_faces(v, f).save(before)
        subprocess.run([options.isomend, "repair", before, "-o", after, "--solid", "--quiet"], check=True)
        solid = pv.read(after)
    w, g = np.asarray(solid.points), solid.regular_faces
    known = {tuple(p) for p in v.astype(np.float32)}
    patch = np.array([any(tuple(w[i].astype(np.float32)) not in known for i in corners) for corners in g])
    picture = Image.new("RGB", (2 * PANEL[0], PANEL[1]), "white")
    picture.paste(panel(v, f, np.zeros(len(f), bool)), (0, 0))
    picture.paste(panel(w, g, patch), (PANEL[0], 0))
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(options.out, optimize=True)


if __name__ == "__main__":
    main()
