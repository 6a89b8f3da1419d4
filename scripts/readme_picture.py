# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy==2.4.6", "pyvista==0.49.1"]
# ///
"""Draw data/mended.png, the README's picture: data/scan.ply before and after, from the front and from the back.

    cargo build --release && python3 scripts/readme_picture.py [IN OUT.png]

Patches are orange. No display is needed."""

import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv

ROOT = Path(__file__).resolve().parent.parent
VIEWS = [(0.95, 1.6, 0.35), (-0.9, -1.5, 0.35)]


def panel(plotter, mesh, colours, towards, title):
    plotter.add_mesh(mesh, scalars=colours, rgb=True, show_edges=False, smooth_shading=False, specular=0.15, ambient=0.1,
                     backface_params={"color": (150, 140, 130)})
    centre = np.array(mesh.center)
    plotter.camera.focal_point = centre
    plotter.camera.position = centre + np.array(towards) * mesh.length
    plotter.camera.up = (0, 0, 1)
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 0.385 * mesh.length
    side = np.cross((0, 0, 1), towards)
    for direction, intensity in ((np.array(towards) - 0.8 * side + (0, 0, 0.9), 0.85), (np.array(towards) + side, 0.3)):
        light = pv.Light(position=centre + direction * mesh.length, focal_point=centre, intensity=intensity)
        light.positional = False
        plotter.renderer.add_light(light)
    plotter.add_text(title, font_size=13, color="black", position="upper_left")


def main():
    source = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "data/scan.ply"
    target = Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "data/mended.png"
    with tempfile.TemporaryDirectory() as folder:
        mended = Path(folder) / "mended.ply"
        subprocess.run([ROOT / "target/release/isomend", "fill", source, "-o", mended], check=True)
        before, after = pv.read(source), pv.read(mended)
    grey, orange = (196, 200, 206), (240, 140, 50)
    colours = np.tile(np.array(grey, np.uint8), (after.n_cells, 1))
    colours[before.n_cells :] = orange
    plotter = pv.Plotter(off_screen=True, shape=(1, 4), window_size=(1680, 600), border=False, lighting="none")
    plotter.set_background("white")
    for column, towards in enumerate(VIEWS):
        plotter.subplot(0, 2 * column)
        panel(plotter, before, colours[: before.n_cells], towards, "before" if column == 0 else "")
        plotter.subplot(0, 2 * column + 1)
        panel(plotter, after, colours, towards, "after" if column == 0 else "")
    plotter.screenshot(target)
    print(f"{target}: {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
