"""Tests of counterparts on the page of `isomend view`, in Chromium: the other side with a plane that is searched, dragged or typed, a
template, texels. For view_test.py."""

import json
import os
import subprocess

import numpy as np

from view_layout import FAINT, SCROLLS, SEEN, SIZES, dark, overlapping, resize
from view_meshes import bust, textured_glb
from view_page import Server

TEXT = "document.querySelector('{}').textContent".format
FIELDS = "[...document.querySelectorAll('#like .numbers input')].map((e) => Number(e.value))"
SHOWN = "['shift', 'turn', 'turn-other'].map((name) => document.querySelector('#plane-' + name).checkVisibility())"
# The middle of a handle in the window.
HANDLE = "((name) => { const b = document.querySelector('#plane-' + name).getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })"
# The faces of the bump that is left, as face numbers.
OTHER_BUMP = """(() => { const { positions: p, faces, centre } = isomend.mesh(), away = (v) => Math.hypot(...[-34.5, 26, 27].map((x, k) => p[3 * v + k] + centre[k] - x)), on = [];
  for (let f = 0; f < faces.length / 3; f++) if ([0, 1, 2].every((k) => away(faces[3 * f + k]) < 13)) on.push(f); return on; })()"""


def handle(page, name):
    page.settled()
    return page.run(f"{HANDLE}({json.dumps(name)})")


def searched(page):
    """The plane is searched: the result is said, the plane found is shown and taken over."""
    page.job("fill")
    page.expect(not page.run("document.querySelector('#like').open"), "the group is not folded")
    page.expect(not page.run("document.querySelector('#texels-field').checkVisibility()"), "texels are offered without a texture")
    page.click_on("#like summary")
    page.fill_in("#like-kind", "mirror")
    page.expect(page.run(TEXT("#mend-text")).endswith("--like mirror"), "the command has no counterpart: " + page.run(TEXT("#mend-text")))
    page.run_command()
    page.until_done()
    page.reaches(1, "the hole is filled")
    page.expect(page.run(TEXT("#like-said")) == "Counterpart used for 1 of 1 hole.", "the result is said as " + page.run(TEXT("#like-said")))
    page.expect("Counterpart used" in page.run(TEXT("#summary")), "the history does not say what was used")
    page.expect(not any(page.run(SHOWN)) and page.run("document.querySelector('#plane-line').checkVisibility()"), "the plane found is not shown, or has handles")
    page.shot("found")
    page.click_on("#like-take")
    page.expect(abs(page.run(FIELDS)[3]) > 0.999, f"the plane taken over is {page.run(FIELDS)}")
    page.until(f"{SHOWN}.every((shown) => shown)", "the given plane has handles")
    page.click_on("#undo")
    page.reaches(0, "the step is undone")
    page.expect(page.run(TEXT("#like-said")) == "", "the result stays after undo")


def dragged(page):
    """Handles and numbers stay in step: by drags, arrow keys, and what is typed."""
    before = np.array(page.run(FIELDS))
    x, y = handle(page, "shift")
    page.drag([(x, y), (x + 15, y + 4), (x + 40, y + 10)])
    shifted = np.array(page.run(FIELDS))
    page.expect((shifted[:3] - before[:3]) @ before[3:] * np.sign(before[3]) > 1 and (shifted[3:] == before[3:]).all(), f"a drag shifts the plane from {before} to {shifted}")
    to = handle(page, "shift")
    page.expect(to[0] - x > 20, f"the handle goes from {x, y} to {to}")
    for name in ("turn", "turn-other"):
        x, y = handle(page, name)
        was = np.array(page.run(FIELDS))
        page.drag([(x, y), (x + 12, y + 6), (x + 30, y + 15)])
        now = np.array(page.run(FIELDS))
        page.expect(0.01 < np.linalg.norm(now[3:] - was[3:]) < 1 and abs(np.linalg.norm(now[3:]) - 1) < 1e-5, f"{name} turns the normal from {was[3:]} to {now[3:]}")
        page.run(f"document.querySelector('#plane-{name}').focus()")
        page.key("ArrowUp", modifiers=8)
        page.expect(np.linalg.norm(np.array(page.run(FIELDS))[3:] - now[3:]) > 0.01, f"the arrow keys do not move {name}")
    page.shot("dragged")
    command = page.run(TEXT("#mend-text"))
    shown = [float(x) for x in command.split("mirror:")[1].split(",")]
    page.expect(shown == page.run(FIELDS), f"the command has {shown}")
    page.fill_in("#plane-nx", "0")
    page.fill_in("#plane-ny", "0")
    page.fill_in("#plane-nz", "0")
    page.run_command()
    page.expect("must not be zero" in page.run(TEXT("#mend-trouble")), "a normal of zero is not refused")
    page.click_on("[data-across='0']")
    x, y = handle(page, "shift")
    page.fill_in("#plane-px", "-10")
    page.expect(handle(page, "shift") != [x, y], "a typed number does not move the plane")
    page.fill_in("#plane-px", "0")
    page.run_command()
    page.until_done()
    page.reaches(2, "the hole is filled in the given plane")
    page.expect(page.run(TEXT("#like-said")) == "Counterpart used for 1 of 1 hole.", "in the given plane: " + page.run(TEXT("#like-said")))


def kept(page, program, folder):
    """What was left is restored after the patch; the recipe makes the same bytes."""
    page.job("restore")
    faces = page.run(OTHER_BUMP)
    page.run(f"isomend.masks.takeFile(new File([{json.dumps(' '.join(map(str, faces)))}], 'bump.txt'))")
    page.until(f"isomend.mask().count === {len(faces)}", "the bump is marked")
    page.job("restore")
    page.fill_in("#like-kind", "mirror")
    page.click_on("[id='restore--grain']")
    page.run_command()
    page.until_done()
    page.reaches(3, "the bump is restored")
    page.expect("Counterpart used" in page.run(TEXT("#like-said")), "nothing is said after a restoration")
    page.shot("restored")
    page.tab("save")
    for kind, name in (("mesh", "whole.ply"), ("recipe", "whole.sh")):
        page.fill_in("#save-kind", kind)
        page.fill_in("#save-path", name)
        page.click_on("#save")
        page.until(TEXT("#saved") + f".includes('{name}')", f"{name} is saved")
    script, saved = (folder / "whole.sh").read_text(), (folder / "whole.ply").read_bytes()
    page.expect(" --like mirror:0," in script and " --like mirror " in script and " --grain" in script, f"the recipe is {script}")
    (folder / "whole.ply").unlink()
    (folder / "bin").mkdir()
    (folder / "bin" / "isomend").symlink_to(program)
    done = subprocess.run(["sh", "whole.sh"], cwd=folder, capture_output=True, text=True, env={**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}"})
    page.expect(done.returncode == 0 and (folder / "whole.ply").read_bytes() == saved, f"the recipe makes another file: {done.stderr[-500:]}")


def templates(page):
    """A template of the folder is used; one outside of it is refused; the group fits in light and dark at three sizes."""
    for _ in range(2):
        page.click_on("#undo")
        page.until("!isomend.steps.job", "undone")
    page.reaches(0, "both steps are undone")
    page.job("fill")
    page.fill_in("#like-kind", "file")
    for name, said in (("", "name of the template"), ("../cast.ply", "not below the folder"), ("none.ply", "no file")):
        page.fill_in("#like-file", name)
        page.run_command()
        page.until(TEXT("#mend-trouble") + f".includes({json.dumps(said)})", f"the template {name!r} is refused")
    page.fill_in("#like-file", "cast.ply")
    page.expect(page.run(TEXT("#mend-text")).endswith("--like cast.ply"), "the template is shown as " + page.run(TEXT("#mend-text")))
    page.click_on("#preview")
    page.until("isomend.steps.previews.length === 1 && !isomend.steps.job", "a preview is made")
    page.until(TEXT("#like-said") + ".includes('used for 1 of 1')", "the preview says what was used")
    page.shot("template")
    for width, height in SIZES:
        resize(page, width, height)
        for is_dark in (False, True):
            dark(page, is_dark)
            for kind in ("mirror", "plane", "file"):
                page.fill_in("#like-kind", kind)
                where = f"{width} x {height}, {'dark' if is_dark else 'light'}, {kind}"
                wrong = [page.run(SCROLLS), overlapping(page.run(SEEN)), page.run(FAINT)]
                page.expect(not any(wrong), f"{where}: {wrong}")
                page.shot(f"{width}_{'dark' if is_dark else 'light'}_{kind}")
    dark(page, False)
    resize(page, *SIZES[0])
    page.click_on("#defaults")
    page.expect("--like" not in page.run(TEXT("#mend-text")), "the defaults have a counterpart")


def texels(page, program, folder):
    """On a textured mesh texels can be left out."""
    mesh = folder / "textured.glb"
    textured_glb(mesh)
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.job("fill")
        page.click_on("#settings > summary")
        page.expect(page.run("document.querySelector('#texels').checkVisibility() && document.querySelector('#texels').checked"), "texels are not offered")
        page.shot("texels")
        page.click_on("#texels")
        page.expect(page.run(TEXT("#mend-text")).endswith("--no-texture"), "the command makes texels")
        page.run_command()
        page.until_done()
        page.reaches(1, "the holes are filled")
        page.expect(page.state()["states"][1]["command"][-1] == "--no-texture", "the step made texels")
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def like(page, program, folder):
    """All of it, on a body with a pair of bumps, one of which is missing."""
    mesh = folder / "bust.ply"
    bust(mesh)
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.click_on("#intro-close")
        searched(page)
        dragged(page)
        kept(page, program, folder)
        templates(page)
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    texels(page, program, folder)
