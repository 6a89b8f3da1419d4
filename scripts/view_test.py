# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy", "websocket-client==1.9.2"]
# ///
"""Test the page of `isomend view` in headless Chromium, with the actions of a user.

    cargo build --release && python3 scripts/view_test.py [--isomend PROGRAM] [--keep FOLDER] [--only NAME]

On data/scan.ply and on a textured GLB made here: choose two holes by clicks in the view, fill them, compare, undo, redo, preview,
paint and restore, cancel a long fill, save, and run the recipe on the command line, which must give the same bytes. Requests with a
wrong token, a foreign Host or Origin, and paths outside the folder must be refused. A mesh of a million triangles must be visible
within 3 seconds, a click within 200 milliseconds and a stroke of the brush within 100, or longer on a slower machine; the times are printed. A mesh of two
million triangles is shown coarse first. Two tabs show the same session. The page must also work at a width of 400 pixels, with keys and with touch. `--keep` keeps screenshots in a folder. Failed checks are listed at the
end, and the exit code is 1. If there is no Chromium the tests are left out, with a message; with CI=true this is a failure."""

import argparse
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

import numpy as np

from browser_test import MOST_WAIT, NAMES, ROOT, finish
from left_out import left_out
from view_choices import check_point, choices
from view_clicks import clicks
from view_creases import creases
from view_groups import in_programs
from view_like import like
from view_large import large
from view_masks import masks
from view_meshes import textured_glb
from view_page import HOLE, Page, Server, check_refusals
from view_print import printing
from view_tabs import huge, same_state, tabs
from view_tasks import tasks
from view_worked import worked


def check_holes(page):
    """Two holes are chosen by clicks in the view, and filled."""
    holes = page.state()["holes"]
    # Those that are joined are chosen together.
    single = [hole for hole in holes if not hole["joined"]]
    page.fill_in("#set-all", "open")
    for hole in (single[0]["id"], single[1]["id"]):
        page.run(f"isomend.holes.choose({hole})")
        page.settled()
        page.run("isomend.holes.choose(null)")
        page.click(*page.run(f"{HOLE}({hole})"))
        page.until(f"isomend.holes.chosen === {hole}", f"a click in the view chooses hole {hole}")
        page.key("i")
    for key in "j", "i":
        for hole in single[:2]:
            page.run(f"isomend.holes.choose({hole['id']}, false)")
            page.key(key)
        if key == "j":
            shown = page.run("isomend.holes.text()")
            page.expect(shown.endswith(f"--bridge {single[0]['id']}+{single[1]['id']}"), f"a bridge is shown as {shown}")
    wanted = f"--holes {single[0]['id']},{single[1]['id']}"
    page.expect(page.run("isomend.holes.text()") == wanted, f"the holes are not shown as {wanted}")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()
    page.shot("holes")
    page.fill_in("#narrower", str(single[1]["diameter"] * 0.999))
    few = page.run("document.querySelectorAll('#holes li').length")
    page.expect(0 < few < len(holes), f"filtered by size there are {few} of {len(holes)} holes")
    page.fill_in("#narrower", "")
    page.click_on("#fill-all")
    page.until_done()
    page.reaches(1, "the holes are filled")
    left = page.state()["holes"]
    page.expect(len(left) == len(holes) - 2, f"of {len(holes)} holes {len(left)} are left after filling two")


def check_compare(page):
    """Before and after are shown side by side and with a slider; undo and redo."""
    seen = {page.settled()["hash"]}
    for show in ("both", "slider", "before", "after"):
        page.click_on(f"[name=show][value={show}] + span")
        now = page.settled()
        page.expect(now["part"] > 0.02 and now["error"] == 0, f"{show}: {now}")
        page.expect(now["hash"] not in seen or show == "after", f"{show} looks like what was before")
        seen.add(now["hash"])
        page.shot(f"compare_{show}")
    page.click_on("#undo")
    page.reaches(0, "the step is undone")
    page.click_on("#redo")
    page.reaches(1, "the step is redone")


def check_colours(page):
    """Colours, edges and the section are drawn."""
    seen = {page.settled()["hash"]}
    def differs(what):
        now = page.settled()
        page.expect(now["hash"] not in seen and now["error"] == 0, f"the view is the same with {what}")
        seen.add(now["hash"])
        page.shot(what)

    for colour in page.run("[...document.querySelector('#colour').options].map((o) => o.value)")[1:]:
        page.fill_in("#colour", colour)
        page.until(f"isomend.display.coloured === {colour!r} || document.querySelector('#message.trouble')", f"{colour} is shown")
        if colour == "walls":
            page.until("isomend.viewer.sides.after.surface.colour.kind === 5", "the walls are measured, for which no other colouring waits")
        page.expect(page.run("isomend.viewer.sides.after.surface.colour.kind") > 0, f"no {colour}: " + page.run("document.querySelector('#message').textContent"))
        differs(f"colour_{colour.split(':')[0]}")
    page.fill_in("#colour", "plain")
    page.click_on("[name=wire] + span")
    differs("edges")
    page.fill_in("#section", "x")
    differs("section")
    page.fill_in("#section", "")
    page.click_on("[name=wire] + span")
    page.settled()


def check_defects(page):
    """Defects of the mesh are listed, and a click moves the view there and marks them."""
    page.tab("check")
    page.click_on("[name=aspect][value=defects] + span")
    page.until("!['', 'Checking…'].includes(document.querySelector('#verdict').textContent)", "the mesh is checked")
    listed = page.run("[...document.querySelectorAll('#defect-list button')].map((b) => b.textContent)")
    page.expect(any(re.fullmatch(r"boundary edges: [\d,]+", text) for text in listed), f"the defects are {listed}")
    before = page.settled()["hash"]
    page.click_on("#defect-list button")
    page.expect(page.settled()["hash"] != before, "a click on a defect shows nothing")
    page.expect(page.run("isomend.viewer.sides.after.mesh.facts.some((f) => f & 1 << 19)"), "no face is marked as a defect")
    page.shot("defects")
    page.tab("holes")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()


def check_files(page, folder):
    """The picture of the view and the report of a step are saved."""
    page.call("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder / "downloads"))
    page.click_on("#screenshot")
    deadline = time.monotonic() + MOST_WAIT
    while not (made := list((folder / "downloads").glob("*.png"))) and time.monotonic() < deadline:
        time.sleep(0.1)
    page.expect(made and made[0].read_bytes()[:4] == b"\x89PNG", "no screenshot is made")
    report = page.run("fetch('api/report/1').then((r) => r.text())")
    page.expect("<canvas" in report and "Holes" in report, "a step has no report")


def check_preview(page):
    """One hole is previewed with two settings, side by side; the first is accepted."""
    before = page.state()
    hole = before["holes"][0]["id"]
    page.tab("holes")
    page.run(f"isomend.holes.choose({hole})")
    page.key("i")
    page.job("fill")
    page.click_on("#preview")
    page.until_done()
    page.until("isomend.steps.previews.length === 1", "there is a preview")
    page.fill_in("#fill--finish", "none")
    page.click_on("#preview")
    page.until("!isomend.steps.job && isomend.steps.previews.length === 2 && isomend.viewer.options.show === 'both'", "there are two previews")
    page.settled()
    page.shot("previews")
    page.expect(page.state()["current"] == before["current"], "a preview is a step")
    first = page.run("isomend.steps.previews[0].id")
    page.click_on("#previews > div:first-child button")
    page.reaches(first, "the preview is taken")
    page.expect(not any(s.get("preview") for s in page.state()["states"]), "the other preview stays")
    page.click_on("#defaults")


def check_paint(page):
    """A painted region is restored, after strokes are undone and a mask is saved and loaded."""
    current = page.state()["current"]
    page.tab("paint")
    page.until("!!isomend.mask()", "the surface is prepared")
    page.click_on("[name=show][value=after] + span")
    page.click_on("[name=tool][value=brush] + span")
    page.settled()
    points = page.surface()
    middle = points[len(points) // 2]
    page.drag([[middle[0] + 3 * i, middle[1]] for i in range(8)])
    count = page.run("isomend.mask().count")
    page.expect(count > 5, f"{count} faces are painted")
    through = page.run("""(() => { const t = isomend.paint.target(), e = isomend.viewer.camera.eye; let n = 0;
        t.mask.on.forEach((on, f) => { if (on && t.topology.front(f, e) <= 0) n++; }); return n; })()""")
    page.expect(through == 0, f"{through} faces that look away are painted")
    page.drag([points[0], [points[0][0] + 5, points[0][1]]])
    more = page.run("isomend.mask().count")
    page.key("z", modifiers=2)
    page.expect(more > count == page.run("isomend.mask().count"), "a stroke is not undone")
    page.key("y", modifiers=2)
    page.expect(page.run("isomend.mask().count") == more, "a stroke is not redone")
    page.key("z", modifiers=2)
    page.click_on("#grow")
    grown = page.run("isomend.mask().count")
    page.fill_in("#grow-by", str(page.run("isomend.paint.radius") / 100))
    page.click_on("#shrink")
    shrunk = page.run("isomend.mask().count")
    page.expect(grown > count and 0 < shrunk < grown, f"{count} faces, grown {grown}, shrunk {shrunk}")
    page.shot("paint")
    page.fill_in("#mask-path", "mask.txt")
    page.click_on("#mask-save")
    page.until("[...document.querySelectorAll('#message, #paint-trouble')].some((e) => e.textContent.includes('mask'))", "the mask is saved")
    trouble = page.run("document.querySelector('#paint-trouble').textContent")
    page.expect(not trouble, f"no mask: {trouble}")
    page.click_on("#invert")
    page.expect(page.run("isomend.mask().count") == page.run("isomend.mask().on.length") - shrunk, "the mask is not inverted")
    page.click_on("#clear")
    page.expect(page.run("isomend.mask().count") == 0, "the mask is not cleared")
    page.click_on("#mask-load")
    page.until(f"isomend.mask().count === {shrunk}", "the mask is loaded")
    check_outlines(page, shrunk)
    page.job("restore")
    page.fill_in("#restore--keep-shape", "2")
    page.run_command()
    page.until("document.querySelector('#mend-trouble').textContent.includes('from 0 to 1')", "a wrong parameter is reported")
    page.fill_in("#restore--keep-shape", "0.2")
    page.run_command()
    page.until_done()
    page.until(f"isomend.model.state.current !== {current} || document.querySelector('#mend-trouble').textContent", "the region is restored")
    page.expect(page.state()["current"] != current, "no restoration: " + page.run("document.querySelector('#mend-trouble').textContent"))
    page.reaches(page.state()["current"], "the restored mesh is shown")
    page.shot("restored")


def check_changes(page):
    """The page's mesh, updated with the changes of each step, equals the program's mesh."""
    differs = page.run("""(async () => { const other = new isomend.model.constructor(), id = (await other.fetchState()).current;
        const [a, b] = await Promise.all([isomend.model.mesh(id), other.mesh(id)]), facts = (m) => m.facts.map((f) => f & 0x3ffff);
        const same = (x, y) => x.length === y.length && x.every((v, i) => v === y[i]);
        return ['positions', 'faces'].filter((k) => !same(a[k], b[k])).concat(same(facts(a), facts(b)) ? [] : ['facts']); })()""")
    page.expect(not differs, f"the page has other {differs} than the program")
    same_state(page, "after all steps")


def check_outlines(page, count):
    """Box, lasso and component add to the mask; each is undone."""
    x, y, width, height = page.view()
    box = [[x + 0.35 * width, y + 0.35 * height], [x + 0.5 * width, y + 0.5 * height], [x + 0.65 * width, y + 0.65 * height]]
    lasso = [[x + (0.5 + 0.15 * np.cos(t)) * width, y + (0.5 + 0.15 * np.sin(t)) * height] for t in np.linspace(0, 6, 12)]
    for tool, points in (("box", box), ("lasso", lasso), ("component", None)):
        page.click_on(f"[name=tool][value={tool}] + span")
        page.drag(points) if points else page.click(*page.surface()[0])
        found = page.run("isomend.mask().count")
        page.expect(found > count, f"{tool}: {found} faces, no more than {count}")
        page.shot(f"paint_{tool}")
        page.click_on("#unstroke")
        page.expect(page.run("isomend.mask().count") == count, f"{tool} is not undone")


def check_cancel(page):
    """A long fill is cancelled, and the mesh is unchanged."""
    before = page.state()
    page.tab("holes")
    page.fill_in("#set-all", "fill")
    page.job("fill")
    page.fill_in("#fill--voxel", str(before["holes"][0]["diameter"] / 120))
    page.fill_in("#fill--finish", "none")
    page.run_command()
    page.until("isomend.steps.job?.id > 0 || document.querySelector('#mend-trouble').textContent", "the run begins")
    page.expect(page.run("document.querySelector('#mend-trouble').textContent") == "", page.run("document.querySelector('#mend-trouble').textContent"))
    page.until("!isomend.steps.job || document.querySelector('#job-line').textContent !== '…'", "the run tells its progress")
    page.expect(page.run("isomend.steps.job !== null"), "the run has ended before it could be cancelled")
    page.shot("running")
    start = time.monotonic()
    page.click_on("#cancel")
    page.until("!isomend.steps.job", "the run is cancelled")
    print(f"  cancelled after {time.monotonic() - start:.2f} s")
    page.until("document.querySelector('#message').textContent.startsWith('Cancelled')", "the cancellation is reported")
    page.expect(page.state()["current"] == before["current"] and not page.state()["busy"], "a cancelled run leaves a step")
    page.click_on("#defaults")


def check_save(page, program, folder, mesh, name):
    """The saved file has the same bytes as the result of the recipe."""
    page.tab("history")
    page.shot("history")
    page.tab("save")
    page.until("document.querySelector('#recipe').textContent.includes('isomend')", "the recipe is shown")
    page.shot("save")

    def save(kind, path, overwrite=False):
        page.fill_in("#save-kind", kind)
        page.fill_in("#save-path", path)
        page.run(f"document.querySelector('#overwrite').checked = {json.dumps(overwrite)}")
        page.click_on("#save")
        page.until("document.querySelector('#saved').textContent || document.querySelector('#save-trouble').textContent", f"{path} is saved")
        return page.run("document.querySelector('#save-trouble').textContent")

    saved = folder / f"saved{mesh.suffix}"
    for kind, path in (("mesh", saved.name), ("report", "step.html"), ("recipe", "recipe.sh")):
        trouble = save(kind, path)
        page.expect(not trouble and (folder / path).stat().st_size > 100, f"{path}: {trouble}")
    for path in ("../out.ply", "/out.ply"):
        page.expect(save("mesh", path) and not (folder.parent / "out.ply").exists(), f"{path} is written")
    page.expect(not save("mesh", saved.name), "a file of this session is not written over")
    other = f"other{mesh.suffix}"
    (folder / other).write_text("of another program")
    page.expect("replace" in save("mesh", other) and (folder / other).read_text() == "of another program", "a file is written over")
    page.expect(not save("mesh", other, True), "a file is not written over")
    page.expect(not page.run("document.querySelector('#overwrite').checked"), "the next file may be written over without a question")
    page.fill_in("#save-path", "other.obj")
    page.expect(page.run("document.querySelector('#save-format').value") == "obj", "the list of formats names another one than the file")
    wanted = saved.read_bytes()
    script = (folder / "recipe.sh").read_text()
    redone = folder / "redo"
    redone.mkdir()
    for file in folder.iterdir():
        if file.is_file() and file.name != saved.name:
            shutil.copy(file, redone)
    tools = redone / "bin"
    tools.mkdir()
    (tools / "isomend").symlink_to(program)
    done = subprocess.run(["sh", "./recipe.sh"], cwd=redone, capture_output=True, text=True, env={**os.environ, "PATH": f"{tools}:{os.environ['PATH']}"})
    page.expect(done.returncode in (0, 3), f"the recipe ends with {done.returncode}: {done.stderr[-500:]}")
    made = [f for f in redone.iterdir() if f.is_file() and f.suffix == mesh.suffix and f.read_bytes() == wanted]
    page.expect(made, f"{name}: no file that the recipe makes has the saved bytes; it is\n{script}")


def check_keys(page):
    """Everything works with keys: tabs, cross, tools; the focus is visible, and every control has a name."""
    page.run("document.querySelector('#tab-holes').focus()")
    page.key("ArrowRight")
    page.expect(page.run("document.activeElement.id") == "tab-paint", "arrows do not go through the tabs")
    page.run("document.querySelector('#view').focus()")
    page.key("b")
    before = page.run("isomend.mask().count")
    page.key("Enter")
    page.expect(page.run("isomend.mask().count") > before, "Enter does not paint at the cross")
    page.expect(not page.run("document.querySelector('#cross').hidden"), "the cross is not seen")
    page.key("z", modifiers=2)
    page.key("o")
    page.key("Enter")
    for _ in range(5):
        page.key("ArrowRight", modifiers=1)
        page.key("ArrowDown", modifiers=1)
    page.key("Enter")
    page.expect(page.run("isomend.mask().count") > before, "a box by keys marks nothing")
    page.key("z", modifiers=2)
    nameless = page.run("""[...document.querySelectorAll('button, input, select, canvas, progress, a[href]')].filter((e) =>
        !(e.ariaLabel || e.textContent.trim() || e.title || e.labels?.length && [...e.labels].some((l) => l.textContent.trim()))).map((e) => e.outerHTML.slice(0, 80))""")
    page.expect(not nameless, f"without a name: {nameless}")
    page.key("t")


def check_small(page, server):
    """The page works at a width of 400 pixels, dark, with touch and with reduced motion."""
    page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}, {"name": "prefers-reduced-motion", "value": "reduce"}])
    page.call("Emulation.setTouchEmulationEnabled", enabled=True)
    page.start(server, width=400, height=800)
    page.settled()
    wide = page.run("document.documentElement.scrollWidth")
    page.expect(wide <= 400, f"at 400 pixels the page is {wide} wide")
    page.expect(page.run("document.documentElement.dataset.theme") == "dark", "the page is not dark")
    page.run("isomend.viewer.fly({ ...isomend.home(), reach: 0.5 * isomend.viewer.camera.reach })")
    page.expect(page.run("isomend.viewer.camera.reach / isomend.home().reach < 0.51"), "the camera flies although motion is not wanted")
    page.run("Object.assign(isomend.viewer.camera, isomend.home()); isomend.viewer.draw()")
    page.shot("small")
    before = page.run("JSON.stringify(isomend.viewer.camera.axes)")
    x, y, width, height = page.view()
    point = {"x": x + width / 2, "y": y + height / 2}
    page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[point])
    page.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{"x": point["x"] + 40, "y": point["y"] + 10}])
    page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.expect(page.run("JSON.stringify(isomend.viewer.camera.axes)") != before, "a finger does not turn the view")
    reach = page.run("isomend.viewer.camera.reach")
    page.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=[{**point, "id": 1}, {"x": point["x"] + 40, "y": point["y"], "id": 2}])
    page.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=[{**point, "id": 1}, {"x": point["x"] + 80, "y": point["y"], "id": 2}])
    page.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
    page.expect(page.run("isomend.viewer.camera.reach") < reach, "two fingers do not zoom")
    for name in ("paint", "print", "check", "history", "save"):
        page.tab(name)
        wide = page.run("document.documentElement.scrollWidth")
        page.expect(wide <= 400, f"with the tab {name} open the page is {wide} wide")
        page.shot(f"small_{name}")
    page.call("Emulation.setTouchEmulationEnabled", enabled=False)
    page.call("Emulation.setEmulatedMedia", features=[])


def session(page, program, folder, mesh, name):
    """All tests on one mesh."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.shot(f"{name}_open")
        page.expect(page.settled()["part"] > 0.03, "nothing is drawn")
        check_point(page)
        check_holes(page)
        check_compare(page)
        check_colours(page)
        check_defects(page)
        check_files(page, folder)
        check_preview(page)
        check_paint(page)
        check_changes(page)
        check_keys(page)
        check_cancel(page)
        check_save(page, program, folder, mesh, name)
        page.tell_troubles()
        check_refusals(page, server)
        page.start(server)
        page.expect(page.state()["current"] > 0, "another page does not show the session")
        if name == "scan":
            check_small(page, server)
    finally:
        code = server.stop()
    page.expect(code == 0, f"after Ctrl-C the program ends with {code}")


def scan(page, program, folder):
    session(page, program, folder, a_scan(folder), "scan")


def textured(page, program, folder):
    mesh = folder / "textured.glb"
    textured_glb(mesh)
    session(page, program, folder, mesh, "textured")


def a_scan(folder):
    return Path(shutil.copy(ROOT / "data/scan.ply", folder / "scan.ply"))


# The groups of tests, the longest ones first; each has its own browser, server and folder.
GROUPS = {
    "tasks": lambda page, program, folder: tasks(page, program, folder, a_scan(folder)),
    "worked": worked,
    "scan": scan,
    "textured": textured,
    "choices": lambda page, program, folder: choices(page, program, folder, a_scan(folder)),
    "clicks": clicks,
    "creases": creases,
    "like": like,
    "masks": lambda page, program, folder: masks(page, program, folder, a_scan(folder)),
    "print": printing,
    "tabs": lambda page, program, folder: tabs(page, program, folder, a_scan(folder)),
    "million": large,
    "huge": huge,
}
# The groups that measure times: they run alone, after the others.
ALONE = ["million", "huge"]


def run_group(name, chromium, program, base, keep, slow):
    """Runs a group of tests; returns what is wrong."""
    folder, profile = base / name / "files", base / name / "profile"
    folder.mkdir(parents=True)
    profile.mkdir()
    if keep:
        (keep / name).mkdir(parents=True, exist_ok=True)
    start = time.monotonic()
    page = Page(chromium, profile, keep and keep / name, slow, coarse=not keep and name not in ALONE)
    print(f"{name}:", flush=True)
    try:
        GROUPS[name](page, program, folder)
    except Exception as error:
        traceback.print_exc()
        page.expect(False, f"{type(error).__name__}: {error}")
        with contextlib.suppress(Exception):
            page.shot("failed")
    finally:
        page.close()
    print(f"{name}: {'WRONG' if page.wrong else 'right'} ({time.monotonic() - start:.0f} s)", flush=True)
    return page.wrong


def run_twice(name, chromium, program, base, keep, slow):
    """Runs a group of tests, and once more if something is wrong: other load of the machine makes single events late, a fault of the page
    shows both times. Returns what is wrong the last time."""
    wrong = run_group(name, chromium, program, base / "first", keep, slow)
    if wrong:
        print(f"{name}: once more", flush=True)
        wrong = run_group(name, chromium, program, base / "second", keep, slow)
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    parser.add_argument("--keep", type=Path, help="folder in which to keep screenshots")
    parser.add_argument("--only", choices=GROUPS)
    parser.add_argument("--slow", type=float, default=1, help="how many times as long the page's scripts take: shows what a test reads too early")
    arguments = parser.parse_args()
    chromium = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if not chromium:
        left_out("the checks of the page of `isomend view`", "there is no Chromium (on Debian: apt install chromium)")
        return 0
    names, failures = [arguments.only] if arguments.only else ALONE, []
    if not arguments.only:
        failures = in_programs(__file__, [name for name in GROUPS if name not in ALONE], sys.argv[1:])
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        for name in names:
            wrong = run_twice(name, chromium, arguments.isomend.resolve(), Path(temporary), arguments.keep, arguments.slow)
            failures += [(name, what) for what in wrong]
    return finish(failures)


if __name__ == "__main__":
    sys.exit(main())
