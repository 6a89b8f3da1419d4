# /// script
# requires-python = ">=3.11"
# dependencies = ["matplotlib==3.11.2", "numpy==2.4.6", "pyvista==0.49.1"]
# ///
"""Draw data/mended.png, the README's picture: a scan, and its underside before a repair, after it, and with its expected errors.

    cargo build --release && python3 scripts/readme_picture.py SCAN.ply [OUT.png] [--isomend PROGRAM]

SCAN.ply is the toy dinosaur of OpenCV (Apache-2.0), parasaurolophus_low_normals2.ply of the Debian package opencv-doc, in the folder
examples/surface_matching/data of its documentation. No display is needed."""

import argparse
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv

ROOT = Path(__file__).resolve().parent.parent
# Directions to the viewer, and upward directions.
WHOLE = ((-0.25, -0.6, 1.0), (1, 0, 0.1))
UNDERSIDE = ((-1.0, -0.62, 0.35), (0.15, -0.5, 1))
SIZE = (440, 420)
GREY, PATCH, INSIDE = np.array((203, 206, 211)), np.array((240, 140, 50)), (92, 70, 54)
COMMAND = ["--debris", "0.01"]


def panel(plotter, mesh, view, colours):
    towards, up = (np.array(axis) for axis in view)
    side = np.cross(up, towards)
    axes = np.array([axis / np.linalg.norm(axis) for axis in (side, np.cross(towards, side))])
    seen = mesh.points @ axes.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    plotter.add_mesh(mesh, scalars=colours, rgb=True, smooth_shading=False, specular=0.12, ambient=0.12, culling="back")
    plotter.add_mesh(mesh.copy(), color=INSIDE, smooth_shading=False, lighting=False, culling="front")
    centre = np.array(mesh.center)
    centre = centre + ((low + high) / 2 - axes @ centre) @ axes
    plotter.camera.focal_point = centre
    plotter.camera.position = centre + towards * mesh.length
    plotter.camera.up = up
    plotter.camera.parallel_projection = True
    width, height = (high - low) / 2
    plotter.camera.parallel_scale = 1.04 * max(height, width * SIZE[1] / SIZE[0])
    for direction, intensity in ((towards - 0.8 * side + 0.9 * up, 0.8), (towards + side, 0.35)):
        light = pv.Light(position=centre + direction * mesh.length, focal_point=centre, intensity=intensity)
        light.positional = False
        plotter.renderer.add_light(light)
    plotter.enable_anti_aliasing("ssaa")


def colours_of(mesh, largest):
    """The colours of the mesh's faces with patches in orange, and with their expected errors, unknown ones in dark grey."""
    import matplotlib

    patch = np.asarray(mesh.cell_data["isomend_patch"]) > 0
    corners = np.asarray(mesh.point_data["isomend_sigma"])[mesh.regular_faces]
    error = np.where((corners < 0).all(axis=1), -1, np.maximum(corners, 0).mean(axis=1))
    marked = np.where(patch[:, None], PATCH, GREY).astype(np.uint8)
    shades = (matplotlib.colormaps["viridis"](np.clip(error / largest, 0, 1))[:, :3] * 255).astype(np.uint8)
    shades[error < 0] = (110, 110, 110)
    return marked, np.where(patch[:, None], shades, GREY).astype(np.uint8)


def drawn(before, after, largest):
    """The four panels as one picture."""
    marked, errors = colours_of(after, largest)
    plain = np.tile(GREY.astype(np.uint8), (before.n_cells, 1))
    panels = ((before, WHOLE, plain), (before, UNDERSIDE, plain), (after, UNDERSIDE, marked), (after, UNDERSIDE, errors))
    plotter = pv.Plotter(off_screen=True, shape=(1, 4), window_size=(4 * SIZE[0], SIZE[1]), border=False, lighting="none")
    plotter.set_background("white")
    for column, (mesh, view, colours) in enumerate(panels):
        plotter.subplot(0, column)
        panel(plotter, mesh, view, colours)
    return plotter.screenshot(return_img=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scan", type=Path)
    parser.add_argument("target", type=Path, nargs="?", default=ROOT / "data/mended.png")
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    arguments = parser.parse_args()
    import matplotlib

    matplotlib.use("agg")
    import matplotlib.pyplot as plt

    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder) / "whole.vtp"
        subprocess.run([arguments.isomend, "repair", arguments.scan, "-o", whole, *COMMAND, "-q"], check=True)
        before, after = pv.read(arguments.scan), pv.read(whole)
    # Pixels of the largest errors do not take the whole scale.
    sigma = np.asarray(after.point_data["isomend_sigma"])
    largest = float(np.percentile(sigma[sigma > 0], 98))
    image = drawn(before, after, largest)
    figure = plt.figure(figsize=(image.shape[1] / 100, image.shape[0] / 100 + 0.45))
    axes = figure.add_axes((0, 0, 1, image.shape[0] / 100 / figure.get_figheight()))
    axes.imshow(image, interpolation="nearest")
    axes.axis("off")
    for column, title in enumerate(("scan", "its underside", "repaired, patches in orange", "expected error")):
        figure.text((column + 0.5) / 4, 0.985, title, ha="center", va="top", fontsize=18)
    bar = figure.add_axes((0.9, 0.12, 0.06, 0.025))
    figure.colorbar(matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(0, largest), "viridis"), cax=bar, orientation="horizontal", ticks=[])
    figure.text(0.896, 0.132, "small", ha="right", va="center", fontsize=13)
    figure.text(0.964, 0.132, "large", ha="left", va="center", fontsize=13)
    figure.savefig(arguments.target, dpi=100)
    from PIL import Image

    Image.open(arguments.target).convert("RGB").save(arguments.target, optimize=True)
    print(f"{arguments.target}: {arguments.target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
