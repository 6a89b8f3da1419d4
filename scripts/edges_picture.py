# /// script
# requires-python = ">=3.11"
# dependencies = [
#   "gmsh==4.15.2", "libigl==2.6.3", "meshlib==3.1.4.297", "numpy==2.4.6", "pillow==13.0.0", "pymeshfix==0.18.1",
#   "pymeshlab==2025.7.post1", "pyvista==0.49.1",
# ]
# ///
"""Draw data/edges.png: six holes of scripts/shapes_with_edges.py, each open, with a smooth patch, and with sharp edges continued.

    cargo build --release && uv run scripts/edges_picture.py [--isomend PROGRAM] [--out FILE.png]

(or in any virtual environment with the packages of the first lines). A row has two holes, each with the hole, the patch with
`--sharp off`, and the patch with default options. Patches are orange, edges of triangles are drawn, and shading is flat. No display
is needed."""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv
import shapes_with_edges as shapes
from PIL import Image

ROOT = shapes.ROOT
# Names of holes, with the direction to the camera in the solid's own axes.
CHOSEN = {
    "box-5-corner-clean": (0.75, 0.9, 0.8),
    "tee-2-curved-clean": (0.55, 0.8, 0.75),
    "slotted-plate-2-two-clean": (-0.9, -0.55, 0.75),
    "stairs-5-mixed-clean": (0.9, 1.0, 0.75),
    "shaft-5-curved-scanned": (1.0, 0.35, -0.6),
    "angle-1-concave-scanned": (0.7, -0.45, 1.0),
}
PANEL = 270, 240  # pixels
COLOURS = 96
GREY, ORANGE, BACK, LINES = "#d3d6da", "#f0943c", "#8fa9c8", "#3a3d42"


def panel(hole, v, f, patch, towards):
    """A picture of the mesh round the hole."""
    plotter = pv.Plotter(off_screen=True, window_size=[2 * side for side in PANEL], lighting="none")
    plotter.set_background("white")
    for faces, colour in ((f[~patch], GREY), (f[patch], ORANGE)):
        if len(faces):
            mesh = pv.PolyData.from_regular_faces(v, faces)
            plotter.add_mesh(mesh, color=colour, show_edges=True, edge_color=LINES, line_width=1.2, smooth_shading=False, ambient=0.5,
                             diffuse=0.62, backface_params={"color": BACK, "ambient": 0.7, "diffuse": 0.2})
    direction = shapes.data.TURN @ np.array(towards) / np.linalg.norm(towards)
    up = shapes.data.TURN @ np.array([0, 0, 1.0])
    right = np.cross(up, direction)
    above = np.cross(direction, right)
    middle = hole.points.mean(axis=0)
    plotter.camera.focal_point = middle
    plotter.camera.position = middle + 12 * hole.diameter * direction
    plotter.camera.up = up
    plotter.camera.parallel_projection = True
    plotter.camera.parallel_scale = 0.82 * hole.diameter
    for place, intensity in ((0.5 * direction - 0.5 * right + above, 0.7), (0.6 * direction + right - 0.2 * above, 0.45)):
        light = pv.Light(position=middle + 12 * hole.diameter * place, focal_point=middle, intensity=intensity)
        light.positional = False
        plotter.renderer.add_light(light)
    plotter.enable_anti_aliasing("ssaa")
    image = Image.fromarray(plotter.screenshot(return_img=True))
    plotter.close()
    return image.resize(PANEL, Image.Resampling.LANCZOS)


def row(hole, program, folder, towards):
    """The hole, its smooth patch and its patch with sharp edges."""
    shapes.data.write_ply(folder / "in.ply", hole.v, hole.f)
    views = [(hole.v, hole.f)]
    views += [shapes.by_isomend(program, hole, folder, options)[:2] for options in (("--sharp", "off"), ())]
    return [panel(hole, v, f, np.arange(len(f)) >= len(hole.f), towards) for v, f in views]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--out", type=Path, default=ROOT / "data/edges.png", help="file for the picture")
    arguments = parser.parse_args()
    wanted = "|".join({name.rsplit("-", 3)[0].replace("-", " ") for name in CHOSEN})
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for hole in shapes.holes(f"^({wanted})$"):
            if hole.name in CHOSEN:
                rows[hole.name] = row(hole, arguments.isomend.resolve(), Path(folder), CHOSEN[hole.name])
    gap = 24  # pixels between the two holes of a row
    sheet = Image.new("RGB", (6 * PANEL[0] + gap, len(CHOSEN) // 2 * PANEL[1]), "white")
    for number, name in enumerate(CHOSEN):
        for column, image in enumerate(rows[name]):
            left = (number % 2) * (3 * PANEL[0] + gap) + column * PANEL[0]
            sheet.paste(image, (left, number // 2 * PANEL[1]))
    sheet.quantize(COLOURS, dither=Image.Dither.NONE).save(arguments.out, optimize=True)
    print(f"{arguments.out}: {arguments.out.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main()
