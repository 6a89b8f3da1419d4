# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy", "pillow==13.0.0", "websocket-client==1.9.2"]
# ///
"""Draw data/view_*.png, the pictures of docs/view.md: the page of data/scan.ply in headless Chromium.

    cargo build --release && python3 scripts/view_picture.py [--isomend PROGRAM]"""

import argparse
import base64
import io
import math
import shutil
import tempfile
from pathlib import Path

from PIL import Image

from browser_test import NAMES, ROOT
from view_page import HOLE, Page, Server


def reduced(image):
    """The picture in 256 colours: most by how often they occur, so that surfaces are smooth, the others far apart, so that small marks keep theirs."""
    often, apart = (image.quantize(count, method=method).getpalette()[:3 * count] for count, method in ((200, Image.Quantize.MEDIANCUT), (56, Image.Quantize.MAXCOVERAGE)))
    palette = Image.new("P", (1, 1))
    palette.putpalette(often + apart)
    return image.quantize(palette=palette, dither=Image.Dither.NONE)


def reduced_to(screenshot, target):
    """Saves a screenshot, as Chromium sends it, with a width of 1040 pixels."""
    seen = Image.open(io.BytesIO(base64.b64decode(screenshot))).convert("RGB")
    reduced(seen.resize((1040, round(1040 * seen.height / seen.width)), Image.LANCZOS)).save(target, optimize=True)
    print(f"{target.name}: {target.stat().st_size / 1000:.0f} kB")


def save(page, name):
    """Waits until the numbers are placed, and saves a screenshot."""
    page.settled()
    page.until("isomend.labels.settled", "the numbers are placed")
    reduced_to(page.call("Page.captureScreenshot")["data"], ROOT / f"data/view_{name}.png")


def draw(page):
    page.until("!!isomend.mask()", "the surface is prepared")
    page.click_on("#intro-close")
    page.run("isomend.holes.choose(6, false)")
    page.key("k")
    page.click(*page.run(f"{HOLE}(1)"))
    save(page, "holes")
    page.key("Escape")
    page.run("isomend.holes.choose(1)")
    page.settled()
    page.job("fill")
    for count, energy in enumerate(("willmore", "curvature-variation"), 1):
        page.fill_in("#fill--energy", energy)
        page.click_on("#preview")
        page.until(f"isomend.steps.previews.length === {count} && !isomend.steps.job && isomend.viewer.options.show === 'both'", "the preview is there")
        page.settled()
    page.run("scrollTo(0, 0)")
    save(page, "preview")
    page.click_on("#previews > div:first-child button")
    page.until("isomend.model.state.current === isomend.display.shown.after && !isomend.steps.previews.length && !!isomend.mask()", "the preview is taken")
    page.run("isomend.display.option('show', 'after'); isomend.viewer.fly(isomend.home()); scrollTo(0, 0)")
    page.tab("paint")
    page.click_on("[name=tool][value=brush] + span")
    page.fill_in("#brush", "7")
    page.settled()
    x, y, width, height = page.view()
    page.drag([[x + width * (0.44 + 0.01 * i), y + height * (0.66 + 0.05 * math.sin(i / 2))] for i in range(20)])
    save(page, "paint")
    page.run("document.querySelector('#clear').click()")
    page.fill_in("#unit", "mm")
    page.fill_in("#shading", "2")
    page.tab("measure")
    points = page.surface()
    for tool, count in (("distance", 2), ("thickness", 1)):
        page.click_on(f"[name=tool][value={tool}] + span")
        for i in range(count):
            page.click(*points[i * (len(points) - 1) // 2])
    page.click_on("#deviation")
    page.until("isomend.display.coloured === 'deviation'", "deviations are shown")
    page.fill_in("#colour", "plain")
    save(page, "measure")
    page.run("isomend.measure.clear()")
    page.fill_in("#shading", "0")
    page.tab("print")
    page.click_on("#run")
    page.until_done()
    page.until("document.querySelector('#result-line').textContent.includes('Printable')", "the mesh is printable")
    page.click_on("#outcome > summary")
    page.fill_in("#colour", "sigma")
    page.until("isomend.display.coloured === 'sigma'", "expected errors are shown")
    save(page, "result")
    page.tab("check")
    page.click_on("[name=aspect][value=walls] + span")
    page.until("isomend.viewer.sides.after.surface.colour.kind === 5", "the walls are measured")
    page.fill_in("#min-wall", "105")
    save(page, "walls")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        folder = Path(folder)
        mesh, profile = folder / "scan.ply", folder / "profile"
        shutil.copy(ROOT / "data/scan.ply", mesh)
        profile.mkdir()
        server = Server(arguments.isomend.resolve(), mesh, folder / "log.txt")
        page = Page(next(filter(None, map(shutil.which, NAMES))), profile, None)
        try:
            page.start(server, width=1280, height=800)
            draw(page)
        finally:
            page.close()
            server.stop()


if __name__ == "__main__":
    main()
