"""Tests of whole tasks on the page of `isomend view`, in Chromium, with mouse and keys: printing, restoring, measuring, a part with sharp
edges, cancelling and continuing, two tabs, keys only, small windows. Pixels and boxes are tested for what must be visible. For
view_test.py."""

import base64
import json
import os
import re
import shutil
import subprocess

import numpy as np

from browser_test import ROOT
from view_layout import STAND, check_keyboard, check_layout, check_rows, dark, resize
from view_meshes import open_cube
from view_page import Server


# The actions that the rows of the holes show.
ROWS = "[...document.querySelectorAll('#holes select')].map((e) => e.value)"


def colour_at(page, x, y):
    """The mean colour of a few pixels of the view at a point of the window."""
    page.settled()
    return page.run(f"""(() => {{ const v = isomend.viewer, gl = v.gl, b = v.canvas.getBoundingClientRect(), ratio = v.canvas.width / v.canvas.clientWidth, p = new Uint8Array(100);
        v.draw(); gl.readPixels(({x} - b.x) * ratio - 2, v.canvas.height - ({y} - b.y) * ratio - 2, 5, 5, gl.RGBA, gl.UNSIGNED_BYTE, p);
        return [0, 1, 2].map((k) => p.filter((_, i) => i % 4 === k).reduce((sum, x) => sum + x, 0) / 25); }})()""")


def is_orange(colour):
    return colour[0] - colour[2] > 60


def begin(page, server, **size):
    page.start(server, **({"width": 1280, "height": 800} | size))
    page.until("!!isomend.mask()", "the surface is prepared")


def look(page):
    """Before the first step: a sentence says what to do; layout, rows, keys, views."""
    page.expect(page.run("document.querySelector('#intro').checkVisibility()"), "nothing says what to do first")
    page.shot("first")
    first = page.run("JSON.stringify(isomend.viewer.camera.axes)")
    page.click_on("#intro-close")
    check_layout(page)
    stand = check_rows(page)
    check_keyboard(page)
    seen = {page.settled()["hash"]}
    for view in ("front", "back", "left", "right", "top", "bottom", "isometric"):
        page.click_on(f"[data-view={view}]")
        now = page.settled()
        page.expect(now["hash"] not in seen and now["part"] > 0.05 and now["error"] == 0, f"{view}: {now}")
        seen.add(now["hash"])
    axis = page.run("(() => { const b = document.querySelector('#gizmo g.z:last-child circle, #gizmo g.z circle').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
    page.click(*axis)
    page.settled()
    page.expect(abs(page.run("isomend.viewer.camera.axes[2][2]")) > 0.99, "a click on an axis does not look along it")
    perspective = page.settled()["hash"]
    page.click_on("#parallel")
    page.expect(page.settled()["hash"] != perspective, "orthographic looks like before")
    page.click_on("#roll-left")
    page.settled()
    page.click_on("#parallel")
    page.click_on("#reset")
    page.settled()
    page.expect(page.run("JSON.stringify(isomend.viewer.camera.axes)") == first, "the first view is not found again")
    for shading in ("1", "2", "3", "4"):
        page.fill_in("#shading", shading)
        if shading == "4":
            page.until("!!isomend.viewer.sides.after.surface.ambient", "the ambient light is computed")
            page.expect(page.run("Math.min(...isomend.viewer.sides.after.surface.ambient) < 200"), "no part of the surface is in shadow")
        now = page.settled()
        page.expect(now["hash"] not in seen and now["error"] == 0, f"shading {shading}: {now}")
        seen.add(now["hash"])
        page.shot(f"shading_{shading}")
    page.fill_in("#light", "90")
    page.expect(page.settled()["hash"] not in seen, "the light does not move")
    page.fill_in("#light", "0")
    page.fill_in("#shading", "0")
    return stand


def measuring(page):
    """A distance, an angle and a thickness are measured with a unit; the outline of the section is saved as SVG."""
    page.fill_in("#unit", "mm")
    points = page.surface()
    for tool, count in (("distance", 2), ("angle", 3), ("thickness", 1)):
        page.click_on(f"[name=tool][value={tool}] + span")
        for i in range(count):
            page.click(*points[i * (len(points) - 1) // 3])
    shown = page.run("[...document.querySelectorAll('#measures b')].map((b) => b.textContent)")
    page.expect(len(shown) == 3 and shown[0].endswith(" mm") and shown[1].endswith("°") and shown[2].endswith(" mm"), f"measured: {shown}")
    page.expect(float(shown[2].split()[0]) > 1, f"the thickness is {shown[2]}: a face beside the point is not the opposite side")
    a, b = page.run("isomend.measure.items[0].points")
    page.expect(abs(float(shown[0].split()[0]) / np.linalg.norm(np.subtract(a, b)) - 1) < 1e-3, "the distance is not the points' distance")
    page.expect("mm" in page.run("document.querySelector('#ruler').textContent"), "the scale bar has no unit")
    page.expect(page.run("document.querySelectorAll('#measure-marks text').length") >= 2, "the measures are not drawn")
    page.shot("measure")
    page.click_on("#measure-clear")
    page.fill_in("#section", "z")
    page.settled()
    page.click_on("#outline")
    page.until("!!isomend.measure.lastSvg", "the outline is made")
    svg = page.run("isomend.measure.lastSvg")
    page.expect(re.search(r'width="[\d.]+mm"', svg) and svg.count(",") > 20, f"the outline is {svg[:120]}")
    page.shot("outline")
    page.fill_in("#section", "")
    page.fill_in("#unit", "")
    page.key("t")


def filling(page, stand):
    """A hole is filled: the patch is orange and nothing moves; plain shading shows no patch; the error band has colours and a histogram."""
    page.tab("holes")
    hole = page.run("isomend.holes.list[0].id")
    page.click_on("#holes li:first-child .hole")
    page.settled()
    middle = page.run(f"""(() => {{ const v = isomend.viewer, b = v.canvas.getBoundingClientRect(), h = isomend.holes.list[0], at = v.onPage(h.centre.map((x, k) => x - isomend.mesh().centre[k]), v.panes()[0]);
        return [b.x + at[0], b.y + at[1] + 40]; }})()""")
    page.expect(not is_orange(colour_at(page, *middle)), f"hole {hole} is orange before it is filled")
    page.click_on("#fill-chosen")
    page.until_done()
    page.reaches(1, "the hole is filled")
    page.settled()
    moved = [name for (name, *a), (_, *b) in zip(stand, page.run(STAND)) if a != b]
    page.expect(not moved, f"a step moves {moved}")
    page.expect(is_orange(colour_at(page, *middle)), "the patch is not orange")
    page.shot("filled")
    page.fill_in("#shading", "1")
    page.expect(not is_orange(colour_at(page, *middle)), "plain shading shows the patch")
    page.fill_in("#shading", "0")
    page.expect(not page.run("document.querySelector('#intro').checkVisibility()"), "the first sentence stays after a step")
    page.tab("measure")
    page.click_on("#deviation")
    page.until("isomend.display.coloured === 'deviation'", "deviations are shown")
    page.expect(page.run("isomend.band.values.some((x) => x < 0) || isomend.band.values.some((x) => x > 0)"), "no vertex deviates")
    page.fill_in("#band-high", "0.001")
    page.until("document.querySelectorAll('#histogram .out').length > 0", "the histogram shows what is outside")
    page.shot("band")
    page.fill_in("#band-high", "")
    page.fill_in("#reference", "scan.ply")
    page.click_on("#deviation")
    page.until("document.querySelector('#measure-trouble').textContent || isomend.band.values?.filter((x) => x === 0).length > 3000", "deviations from a file are shown")
    page.fill_in("#reference", "")
    page.fill_in("#colour", "plain")
    page.run("isomend.viewer.fly(isomend.home())")


def printing(page, folder):
    """The preset makes the mesh printable; the check says that it is sound; the mesh is downloaded."""
    page.job("fill")
    page.click_on("#presets [value=cap]")
    shown = page.run("document.querySelector('#mend-text').textContent")
    rows = page.run(ROWS)
    page.expect("--flat" in shown and "fill" not in rows, f"flat caps are shown as {shown}, with rows {set(rows)}")
    page.click_on("#presets [value=continue]")
    page.expect("flat" not in page.run(ROWS), "the preset before leaves flat caps")
    page.job("repair")
    page.click_on("#presets [value=print]")
    shown = page.run("document.querySelector('#mend-text').textContent")
    page.expect("--close-borders" in shown and "--drop-inside" in shown, f"the preset is shown as {shown}")
    current = page.state()["current"]
    page.run_command()
    page.until("/^\\d+:\\d\\d/.test(document.querySelector('#job-time').textContent)", "the time is shown")
    page.until_done()
    page.until(f"isomend.model.state.current !== {current}", "the mesh is repaired")
    page.tab("check")
    page.until("!['', 'Checking…'].includes(document.querySelector('#verdict').textContent)", "the mesh is checked")
    verdict = page.run("document.querySelector('#verdict').textContent")
    page.expect(verdict.startswith("Printable"), f"it is not printable: {verdict}")
    page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder / "kept"))
    page.tab("save")
    page.fill_in("#save-kind", "mesh")
    page.fill_in("#save-format", "stl")
    page.click_on("#download")
    page.until("document.querySelector('#saved').textContent.includes('.stl')", "the mesh is downloaded")
    volume = page.run("isomend.measure.sizes() || isomend.open('measure') || document.querySelector('#sizes').textContent")
    page.expect("not closed" not in volume, f"no volume is shown: {volume}")


def masks(page):
    """Masks have names; a click marks one side of a cube, up to its creases; presets restore; a dropped list of faces becomes the mask."""
    page.key("u")
    page.expect(page.run("isomend.tab") == "paint", "a tool does not open its tab")
    page.click(*page.surface(0.4)[0])
    one = page.run("isomend.mask().count")
    page.expect(100 < one < 0.3 * page.run("isomend.mask().on.length"), f"up to creases {one} faces are marked")
    page.fill_in("#mask-name", "side")
    page.click_on("#mask-keep")
    page.until("document.querySelectorAll('#masks li').length === 1", "the mask has a name")
    page.click_on("#clear")
    page.click_on("#masks button")
    page.until(f"isomend.mask().count === {one}", "a mask with a name is shown again")
    page.shot("mask")
    page.run("isomend.masks.takeFile(new File(['0\\n1\\n2\\n'], 'a.txt'))")
    page.until("isomend.mask().count === 3", "a file of faces is taken")
    page.key("z", modifiers=2)
    page.expect(page.run("isomend.mask().count") == one, "a file of faces is not undone")
    page.job("restore")
    page.click_on("#presets [value=keep]")
    page.expect("--keep-shape 0.5" in page.run("document.querySelector('#mend-text').textContent"), "the preset keeps no shape")
    page.tab("paint")
    page.click_on("#clear")


def going_on(page, program, mesh, folder):
    """A run is cancelled; the program ends and continues with the step that was not saved; two tabs show the same."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        begin(page, server)
        masks(page)
        page.click_on("[name=folds] + span")
        page.expect(page.run("isomend.viewer.sides.after.segments.length / 7") >= 100, "creases are not drawn")
        page.shot("creases")
        page.tab("holes")
        page.click_on("#fill-all")
        page.until_done()
        page.reaches(1, "the holes are filled")
        page.job("fair")
        page.fill_in("[id='fair--voxel']", "0.04")
        page.run_command()
        page.until("!document.querySelector('#ask').hidden", "it is asked whether all is meant")
        page.click_on("#ask-yes")
        page.until("isomend.steps.job?.id > 0", "the run begins")
        page.click_on("#cancel")
        page.until("!isomend.steps.job", "the run is cancelled")
        page.expect(page.state()["current"] == 1, "a cancelled run leaves a step")
        # A page that is open when its program ends would report errors.
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    server = Server(program, mesh, folder / "log.txt", "--resume")
    try:
        begin(page, server)
        page.until("isomend.model.state.current === 1 && isomend.display.shown.after === 1", "the step is made again")
        page.run("window.other = new isomend.model.constructor(); fetch('api/undo', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: '{}' })")
        page.until("isomend.model.state.current === 0 && isomend.display.shown.after === 0", "what another tab does is seen")
        page.tell_troubles()
    finally:
        server.stop()


# The faces of a dent in a sphere: faces with a vertex nearer than 0.96 to the centre.
DENT = """(() => { const { positions: p, faces, centre } = isomend.mesh(), size = (v) => Math.hypot(...[0, 1, 2].map((k) => p[3 * v + k] + centre[k]));
  const on = []; for (let f = 0; f < faces.length / 3; f++) if ([0, 1, 2].some((k) => size(faces[3 * f + k]) < 0.96)) on.push(f); return on; })()"""


def handing_over(page, program, folder):
    """A dent is restored; unit, tolerance, mark, patches and piece are handed over, and the recipe makes the same files."""
    mesh = folder / "painted.ply"
    shutil.copy(ROOT / "data" / "painted.ply", mesh)
    server = Server(program, mesh, folder / "log.txt")
    text = "document.querySelector('{}').textContent".format
    try:
        begin(page, server)
        page.tab("save")
        off = page.run("[...document.querySelectorAll('#deliver :is(input, select, button):disabled')].map((e) => e.id)")
        page.expect(off == ["tolerance", "mark", "patch-paint", "mark-colour", "patches-file", "piece-file"] and page.run(text("#deliver-hint")), f"before a step {off} are off")
        faces = page.run(DENT)
        page.run(f"isomend.masks.takeFile(new File([{json.dumps(' '.join(map(str, faces)))}], 'dent.txt'))")
        page.until(f"isomend.mask().count === {len(faces)}", "the dent is marked")
        page.tab("paint")
        page.click_on("#grow")
        page.job("restore")
        page.run_command()
        page.until_done()
        page.reaches(1, "the dent is restored")
        page.tab("save")
        page.until(text("#deliver-said") + ".includes('New surface')", "the figures of the patch are shown")
        page.expect(not page.run("document.querySelectorAll('#deliver :disabled').length"), "a restored mesh cannot be handed over")
        page.fill_in("#deliver-unit", "mm")
        page.expect(page.run("document.querySelector('#unit').value === 'mm' && document.querySelector('#deliver .unit').textContent === 'mm'"), "the unit is not the same everywhere")
        page.fill_in("#tolerance", "-1")
        page.until(text("#deliver-trouble") + ".includes('positive')", "a wrong tolerance is refused")
        page.fill_in("#tolerance", "0.5")
        page.fill_in("#mark", "colour")
        page.fill_in("#mark-colour", "#0a64ff")
        page.click_on("#patches-file")
        page.click_on("#piece-file")
        page.until(text("#deliver-said") + ".includes('within 0.5 mm on 100')", "the share within the tolerance is shown")
        page.expect("mm²" in page.run(text("#deliver-said")), "the new area has no unit")
        page.expect(not page.run(text("#deliver-trouble")), "all is right, but: " + page.run(text("#deliver-trouble")))
        options = "--patches painted_mended_patches.ply --piece painted_mended_piece.stl --mark colour=0a64ff --tolerance 0.5 --unit mm"
        page.until(text("#recipe") + f".includes({json.dumps(options)})", f"the recipe has {options}")
        page.fill_in("#colour", "sigma")
        page.until("isomend.display.coloured === 'sigma'", "expected errors are shown")
        page.expect(page.run("document.querySelector('#scale-said').checkVisibility() && document.querySelector('#scale-said').textContent.includes('mm²')"), "the legend names no new surface")
        page.expect(", mm" in page.run(text("#scale-name")), "the legend has no unit")
        check_layout(page, ["save"], [False])
        page.tab("save")
        page.fill_in("#save-path", "whole.ply")
        page.click_on("#save")
        page.until(text("#saved") + ".includes('whole_piece.stl')", "mesh, patches and piece are saved")
        names = ["whole.ply", "whole_patches.ply", "whole_piece.stl"]
        saved = [(folder / name).read_bytes() for name in names]
        page.fill_in("#save-kind", "recipe")
        page.fill_in("#save-path", "whole.sh")
        page.click_on("#save")
        page.until(text("#saved") + ".includes('whole.sh')", "the recipe is saved")
        for name in names:
            (folder / name).unlink()
        (folder / "bin").mkdir()
        (folder / "bin" / "isomend").symlink_to(program)
        done = subprocess.run(["sh", "whole.sh"], cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"})
        page.expect(done.returncode == 0 and [(folder / name).read_bytes() for name in names] == saved, f"the recipe makes other files: {done.stderr[-500:]}")
        page.fill_in("#save-kind", "mesh")
        downloads = folder / "handed"
        page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(downloads))
        page.click_on("#download")
        page.until(text("#saved") + ".includes('_piece.stl')", "the piece is downloaded")
        page.fill_in("#tolerance", "0.000001")
        page.until(text("#deliver-trouble") + ".includes('patches 1')", "patches that are not within the tolerance are listed")
        german_figures(page)
        page.tell_troubles()
        # A page that is open when its program ends would report errors.
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def opening(page, folder):
    """A dropped mesh is sent and opened on a new page; going back shows the first mesh."""
    text = (folder / "scan.ply").read_bytes()
    page.leave(f"isomend.opener.send([new File([Uint8Array.from(atob('{base64.b64encode(text).decode()}'), (c) => c.charCodeAt(0))], 'sent.ply')])")
    page.until_open("sent.ply", "what was dropped is opened")
    page.until("!!isomend.mask()", "the surface is prepared")
    page.expect((folder / "sent.ply").read_bytes() == text and page.state()["current"] == 0, "the opened mesh is not the dropped one")
    page.tab("save")
    page.until("document.querySelectorAll('#files option').length > 1", "the files of the folder are offered")
    page.shot("files")
    page.leave("history.back()")
    page.until_open("scan.ply", "back leads to the first file")
    page.expect(page.state()["current"] > 0, "the first session is lost")


def german(page):
    """The page in German, and back: numbers keep their digits, and a running preview is shown when it has ended."""
    page.job("restore")
    page.click_on("#presets [value=keep]")
    page.job("repair")
    page.fill_in("[id='repair--min-wall']", "0.0123456789")
    page.run("isomend.steps.run('repair', { preview: true })")
    page.fill_in("#language", "de")
    page.until("document.documentElement?.dataset.state === 'ready' && document.documentElement.lang === 'de'", "the page is German")
    page.until("!isomend.steps.job && isomend.steps.previews.length === 1", "a preview that ran at the change of the language is shown")
    kept = page.run("[document.querySelector('[id=\"repair--min-wall\"]').value, isomend.steps.previews[0].settings?.values.min_wall, isomend.steps.previews[0].label]")
    page.expect(kept[:2] == ["0,0123456789"] * 2 and "--min-wall 0.0123456789" in kept[2], f"the change of the language leaves {kept}")
    page.expect(page.run("isomend.steps.presets.chosen.restore.name") == "keep", "the change of the language loses a preset")
    page.run("isomend.steps.presets.follow('restore')")
    page.expect(page.run("isomend.steps.presets.chosen.restore.name") == "keep", "a decimal comma counts as another value than the preset's")
    page.click_on("#previews > div:first-child button:nth-of-type(2)")
    page.until("!isomend.steps.previews.length && !!isomend.mask()", "the preview is dropped")
    text = page.run("document.body.innerText")
    points = page.run("[...document.querySelectorAll('input[inputmode=decimal]')].filter((e) => /\\d\\.\\d/.test(e.value)).map((e) => e.id)")
    page.expect(not points, f"fields with a decimal point in German: {points}")
    page.expect("Löcher" in text and "Holes" not in text and "{" not in text, "the page is not in German")
    # The English page has the same colours.
    check_layout(page, themes=())


def german_figures(page):
    """The figures of the new surface in German: words and decimal commas."""
    page.fill_in("#language", "de")
    page.until("document.documentElement?.dataset.state === 'ready' && document.documentElement.lang === 'de'", "the page is German")
    page.tab("save")
    page.until("document.querySelector('#deliver-said').textContent.includes('Ergänzt')", "the figures are shown in German")
    shown = page.run("document.querySelector('#deliver-said').textContent")
    page.expect(re.search(r"\d,\d", shown) and not re.search(r"\d\.\d", shown), f"the figures in German are {shown!r}")
    check_layout(page, ["save"], ())


def tasks(page, program, folder, mesh):
    """All tasks, on a scan and on a cube."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        dark(page, False)
        begin(page, server)
        stand = look(page)
        measuring(page)
        filling(page, stand)
        printing(page, folder)
        resize(page, 1024, 700)
        page.tab("history")
        page.shot("history")
        opening(page, folder)
        german(page)
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    handing_over(page, program, folder)
    cube = folder / "cube.ply"
    open_cube(cube)
    going_on(page, program, cube, folder)
