# /// script
# requires-python = ">=3.11"
# dependencies = ["numpy", "pillow", "websocket-client==1.9.2"]
# ///
"""Use the page of `isomend view` in headless Chromium, as a user would.

    cargo build --release && python3 scripts/view_test.py [--isomend PROGRAM] [--keep FOLDER] [--only NAME]

On data/scan.ply and on a textured GLB made here: choose two holes by clicks in the view, fill them, compare, undo, redo, preview,
paint and restore, cancel a long fill, save, and run the recipe by the command line, which must give the same bytes. Requests with
a wrong token, a foreign Host or Origin, and paths out of the folder must be refused. A mesh of a million triangles must be seen
within 3 seconds, and a stroke of the brush be drawn within 100 milliseconds; both are printed. At a width of 400 pixels, by keys
and by touch it must work too. `--keep` leaves screenshots in a folder. Exits with 1 if anything is wrong. Where there is no
Chromium it says so, which is a failure with CI=true."""

import argparse
import http.client
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np

from browser_test import DRAWN, NAMES, ROOT, Browser
from left_out import left_out
from view_meshes import bumpy_ball, textured_glb

FIRST_PICTURE, STROKE = 3.0, 0.1
# Where a hole's middle is in the window.
HOLE = """((id) => { const { viewer, labels } = isomend, b = viewer.canvas.getBoundingClientRect(), panes = viewer.panes();
  const pane = panes[panes.length - 1], hole = labels.items.find((i) => i.hole.id === id && i.hole.side === pane.side).hole;
  const at = viewer.onPage(hole.centre, pane); return [b.x + at[0], b.y + at[1]]; })"""


class Server:
    """The program, serving a mesh."""

    def __init__(self, program, mesh, log):
        self.log = open(log, "w")
        self.process = subprocess.Popen([program, "view", mesh, "--no-browser"], stdout=subprocess.PIPE, stderr=self.log, text=True)
        line = self.process.stdout.readline()
        found = re.search(r"http://\S+", line)
        if not found:
            raise SystemExit(f"`isomend view` prints no address but {line!r}")
        self.address = found.group()

    def stop(self):
        """Ends the program by Ctrl-C; its exit code."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(60)
        self.log.close()
        return code


class Page(Browser):
    """The page, with what a user does on it."""

    def __init__(self, program, folder, keep):
        super().__init__(program, folder, offline=False)
        self.wrong, self.keep = [], keep

    def expect(self, right, what):
        if not right:
            self.wrong.append(what)
            print("    WRONG:", what)

    def shot(self, name):
        if self.keep:
            self.screenshot(self.keep / f"view_{name}.png")

    def start(self, server, **size):
        self.troubles.clear()
        self.open(server.address, **size)
        if self.run("document.documentElement.dataset.state") != "ready":
            raise RuntimeError(self.run("document.querySelector('#message').textContent"))

    def key(self, key, modifiers=0, code=None):
        named = {"Enter": 13, "Escape": 27, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9}
        text = {"text": key} if len(key) == 1 and modifiers & 6 == 0 else {"text": "\r"} if key == "Enter" else {}
        number = named.get(key, ord(key.upper()[0]))
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code or key, windowsVirtualKeyCode=number, modifiers=modifiers, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code or key, windowsVirtualKeyCode=number, modifiers=modifiers)

    def drag(self, points, modifiers=0):
        """Drags the left button over points of the window."""
        x, y = points[0]
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1, modifiers=modifiers)
        for x, y in points[1:]:
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="left", buttons=1, modifiers=modifiers)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, button="left", clickCount=1, modifiers=modifiers)

    def fill_in(self, query, value):
        self.run(f"""(() => {{ const e = document.querySelector({json.dumps(query)}); e.value = {json.dumps(value)};
            e.dispatchEvent(new Event("input", {{ bubbles: true }})); e.dispatchEvent(new Event("change", {{ bubbles: true }})); }})()""")

    def tab(self, name):
        self.click_on(f"#tab-{name}")
        self.until(f"!document.querySelector('#pane-{name}').hidden", f"the tab {name} is open")

    def state(self):
        return self.run("isomend.model.fetchState()")

    def at_rest(self):
        """Waits until a run has ended, and what it made is shown."""
        self.until("!isomend.steps.job && isomend.display.shown.after !== null", "the run has ended")
        self.settled()

    def reaches(self, state, what):
        self.until(f"isomend.model.state.current === {state} && isomend.display.shown.after === {state} && !!isomend.mask()", what)

    def view(self):
        """The view's box in the window."""
        return self.run("(() => { const b = document.querySelector('#view').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")

    def surface(self, spread=0.25):
        """Points of the window over the surface, not over a hole."""
        return self.run(f"""(() => {{ const v = isomend.viewer, b = v.canvas.getBoundingClientRect(), points = [];
            for (let y = 0.5 - {spread}; y <= 0.5 + {spread}; y += 0.05) for (let x = 0.5 - {spread}; x <= 0.5 + {spread}; x += 0.05) {{
              const hit = v.pick(b.width * x, b.height * y); if (!hit.point) continue;
              if (isomend.paint.target().topology.front(hit.face, v.camera.eye) > 0) points.push([b.x + b.width * x, b.y + b.height * y]); }}
            return points; }})()""")

    def tell_troubles(self):
        for trouble in self.troubles:
            self.expect(False, f"console: {trouble}")
        outside = [url for url in self.requests if not url.startswith(("http://127.0.0.1", "data:", "about:", "blob:"))]
        self.expect(not outside, f"the page asks for {outside[:3]}")


def check_holes(page):
    """Two holes are chosen by clicks in the view, and filled."""
    holes = page.state()["holes"]
    page.fill_in("#set-all", "open")
    for hole in (holes[0]["id"], holes[1]["id"]):
        page.run(f"isomend.holes.choose({hole})")
        page.settled()
        page.run("isomend.holes.choose(null)")
        page.click(*page.run(f"{HOLE}({hole})"))
        page.until(f"isomend.holes.chosen === {hole}", f"a click in the view chooses hole {hole}")
        page.key("i")
    wanted = f"--holes {holes[0]['id']},{holes[1]['id']}"
    page.expect(page.run("document.querySelector('#holes-text').textContent") == wanted, f"the holes are not told as {wanted}")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()
    page.shot("holes")
    page.fill_in("#narrower", str(holes[1]["diameter"] * 0.999))
    few = page.run("document.querySelectorAll('#holes li').length")
    page.expect(0 < few < len(holes), f"filtered by size there are {few} of {len(holes)} holes")
    page.fill_in("#narrower", "")
    page.click_on("#fill-all")
    page.at_rest()
    page.reaches(1, "the holes are filled")
    left = page.state()["holes"]
    page.expect(len(left) == len(holes) - 2, f"of {len(holes)} holes {len(left)} are left after filling two")


def check_compare(page):
    """Before and after, side by side and by a slider; undo and redo."""
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
    """Colours, edges, the section."""
    seen = {page.settled()["hash"]}

    def differs(what):
        now = page.settled()
        page.expect(now["hash"] not in seen and now["error"] == 0, f"the view is the same with {what}")
        seen.add(now["hash"])
        page.shot(what)

    for colour in page.run("[...document.querySelector('#colour').options].map((o) => o.value)")[1:]:
        page.fill_in("#colour", colour)
        page.until(f"isomend.viewer.sides.after.surface.colour.kind > 0 || document.querySelector('#message.trouble')", f"{colour} is shown")
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


def check_point(page):
    """A click tells the point and the ball."""
    x, y = page.surface()[0]
    page.run("isomend.point.copied = null")
    page.click(x, y, modifiers=1)
    page.until("!!isomend.point.copied", "the ball is copied")
    ball = page.run("isomend.point.copied")
    page.expect(re.fullmatch(r"--ball (-?[\d.e-]+,){3}[\d.e-]+", ball), f"the ball is {ball!r}")


def check_preview(page):
    """One hole with two settings, side by side; the first is taken."""
    before = page.state()
    hole = before["holes"][0]["id"]
    page.tab("holes")
    page.run(f"isomend.holes.choose({hole})")
    page.key("i")
    page.tab("mend")
    page.click_on("[name=kind][value=fill] + span")
    page.click_on("#preview")
    page.at_rest()
    page.until("isomend.steps.previews.length === 1", "there is a preview")
    page.fill_in("#fill--finish", "none")
    page.click_on("#preview")
    page.until("!isomend.steps.job && isomend.steps.previews.length === 2 && isomend.viewer.options.show === 'both'", "there are two previews")
    page.settled()
    page.shot("previews")
    page.expect(page.state()["current"] == before["current"], "a preview is a step")
    page.fill_in("#fill--finish", "auto")
    first = page.run("isomend.steps.previews[0].id")
    page.click_on("#previews > div:first-child button")
    page.reaches(first, "the preview is taken")
    page.expect(not any(s.get("preview") for s in page.state()["states"]), "the other preview stays")


def check_paint(page):
    """A painted region is restored, after strokes are undone and a mask is saved and loaded."""
    current = page.state()["current"]
    page.tab("paint")
    page.until("!!isomend.mask()", "the surface is prepared")
    page.click_on("[name=tool][value=brush] + span")
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
    page.click_on("#shrink")
    shrunk = page.run("isomend.mask().count")
    page.expect(grown > count and shrunk < grown, f"{count} faces, grown {grown}, shrunk {shrunk}")
    page.shot("paint")
    page.fill_in("#mask-path", "mask.txt")
    page.click_on("#mask-save")
    page.until("/mask is saved|mask.txt/.test(document.querySelector('#message').textContent + document.querySelector('#paint-trouble').textContent)", "the mask is saved")
    page.expect(page.run("document.querySelector('#paint-trouble').textContent") == "", "no mask: " + page.run("document.querySelector('#paint-trouble').textContent"))
    page.click_on("#invert")
    page.expect(page.run("isomend.mask().count") == page.run("isomend.mask().on.length") - shrunk, "the mask is not inverted")
    page.click_on("#clear")
    page.expect(page.run("isomend.mask().count") == 0, "the mask is not cleared")
    page.click_on("#mask-load")
    page.until(f"isomend.mask().count === {shrunk}", "the mask is loaded")
    check_outlines(page, shrunk)
    page.click_on("#to-restore")
    page.fill_in("#restore--keep-shape", "2")
    page.click_on("#run")
    page.until("document.querySelector('#mend-trouble').textContent.includes('from 0 to 1')", "a wrong parameter is told")
    page.fill_in("#restore--keep-shape", "0.2")
    page.click_on("#run")
    page.at_rest()
    page.until(f"isomend.model.state.current !== {current} || document.querySelector('#mend-trouble').textContent", "the region is restored")
    page.expect(page.state()["current"] != current, "no restoration: " + page.run("document.querySelector('#mend-trouble').textContent"))
    page.reaches(page.state()["current"], "the restored mesh is shown")
    page.shot("restored")


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
    """A long fill is cancelled, and the mesh is as it was."""
    before = page.state()["current"]
    page.tab("mend")
    page.click_on("[name=kind][value=fair] + span")
    page.run("isomend.mask()?.change(() => false)")
    page.fill_in("#fair--voxel", str(page.run("isomend.model.state.scene.radius") / 110))
    page.click_on("#run")
    page.until("isomend.steps.job?.id > 0 || document.querySelector('#mend-trouble').textContent", "the run begins")
    page.expect(page.run("document.querySelector('#mend-trouble').textContent") == "", page.run("document.querySelector('#mend-trouble').textContent"))
    time.sleep(0.4)
    page.shot("running")
    start = time.monotonic()
    page.click_on("#cancel")
    page.until("!isomend.steps.job", "the run is cancelled")
    print(f"  cancelled after {time.monotonic() - start:.2f} s")
    page.until("document.querySelector('#message').textContent.startsWith('Cancelled')", "the cancelling is told")
    page.expect(page.state()["current"] == before and not page.state()["busy"], "a cancelled run leaves a step")
    page.fill_in("#fair--voxel", "")
    page.click_on("[name=kind][value=fill] + span")


def check_save(page, program, folder, mesh, name):
    """What is saved has the bytes that the recipe gives."""
    page.tab("history")
    page.shot("history")
    page.tab("save")
    page.until("document.querySelector('#recipe').textContent.includes('isomend')", "the recipe is told")
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
    page.expect("replace" in save("mesh", saved.name), "a file is written over")
    page.expect(not save("mesh", saved.name, True), "a file is not written over")
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


def check_refusals(page, server):
    """What does not come from the page is refused."""
    parts = urlsplit(server.address)
    token = parts.path.strip("/")
    json_type = {"Content-Type": "application/json"}
    save = json.dumps({"path": "../stolen.ply", "overwrite": True, "kind": "mesh"})
    cases = [
        ("no token", "GET", "/api/state", {}, None),
        ("a wrong token", "GET", f"/{token[:-1]}{'A' if token[-1] != 'A' else 'B'}/api/state", {}, None),
        ("a foreign Host", "GET", f"/{token}/api/state", {"Host": "example.com"}, None),
        ("a foreign Origin", "POST", f"/{token}/api/undo", {"Origin": "http://example.com", **json_type}, "{}"),
        ("a path outside", "POST", f"/{token}/api/save", json_type, save),
        ("a way up in the address", "GET", f"/{token}/../../etc/passwd", {}, None),
    ]
    for what, method, path, headers, body in cases:
        connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=30)
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        text = answer.read()
        page.expect(400 <= answer.status < 500 and b"root:" not in text, f"{what} is answered with {answer.status}")
        connection.close()


def check_keys(page):
    """Everything by keys: tabs, cross, tools; the focus is seen, and every control has a name."""
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
    """400 pixels wide, dark, by touch and with reduced motion."""
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
    for name in ("paint", "mend", "history", "save"):
        page.tab(name)
        wide = page.run("document.documentElement.scrollWidth")
        page.expect(wide <= 400, f"with the tab {name} open the page is {wide} wide")
        page.shot(f"small_{name}")
    page.call("Emulation.setTouchEmulationEnabled", enabled=False)
    page.call("Emulation.setEmulatedMedia", features=[])


def session(page, program, folder, mesh, name):
    """All that a user does with a mesh."""
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
        check_preview(page)
        check_paint(page)
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


def large(page, program, folder):
    """A million triangles: the first picture and strokes, with their times."""
    mesh = folder / "million.ply"
    faces = bumpy_ball(mesh, 503)
    server = Server(program, mesh, folder / "log.txt")
    try:
        start = time.monotonic()
        page.start(server)
        seen = page.run("isomend.times")
        print(f"  {faces} triangles: first picture {seen['first'] / 1000:.2f} s after the page was asked for ({time.monotonic() - start:.2f} s with the browser's own)")
        page.expect(seen["first"] / 1000 < FIRST_PICTURE, f"the first picture takes {seen['first'] / 1000:.2f} s")
        page.until("!!isomend.mask() && !!isomend.viewer.sides.after.surface.order", "the surface is prepared")
        frames = page.run("""(() => { const v = isomend.viewer, gl = v.gl, frame = (fewer) => { const t = performance.now(); v.camera.orbit(0.04, 0.02);
            v.draw(fewer); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); return performance.now() - t; };
            for (let i = 0; i < 3; i++) frame(true); const moving = [1, 2, 3, 4, 5].map(() => frame(true)).sort((a, b) => a - b)[2];
            return { moving, thin: v.drewThin, coarse: v.coarse, whole: frame(false) }; })()""")
        what = ("fewer faces" if frames["thin"] else "all faces") + (" at half the resolution" if frames["coarse"] else "")
        print(f"  moving {frames['moving']:.0f} ms a frame ({what}), at rest {frames['whole']:.0f} ms")
        page.tab("paint")
        page.click_on("[name=tool][value=brush] + span")
        page.settled()
        x, y, width, height = page.view()
        page.run("isomend.paint.times = []")
        for row in range(4):
            page.drag([[x + width * (0.35 + 0.02 * i), y + height * (0.35 + 0.1 * row)] for i in range(15)])
        strokes = page.run("isomend.paint.times")
        drawn = page.run("""(() => { const p = isomend.paint, gl = isomend.viewer.gl, b = isomend.viewer.canvas, times = [];
            for (let i = 0; i < 15; i++) { const t = performance.now(); p.begin({ button: 0 }, [b.clientWidth * (0.4 + 0.01 * i), b.clientHeight * 0.55]).end({}, false);
              gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); times.push(performance.now() - t); } return times; })()""")
        page.expect(page.run("isomend.mask().count") > 1000, "the strokes mark next to nothing")
        print(f"  {len(strokes)} touches of the brush: median {np.median(strokes):.0f} ms, longest {max(strokes):.0f} ms; until drawn median {np.median(drawn):.0f} ms")
        page.expect(np.median(drawn) / 1000 < STROKE and np.median(strokes) / 1000 < STROKE, "a stroke of the brush takes too long")
        page.shot("million")
        page.tell_troubles()
    finally:
        server.stop()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    parser.add_argument("--keep", type=Path, help="a folder for screenshots")
    parser.add_argument("--only", choices=["scan", "textured", "million"])
    arguments = parser.parse_args()
    chromium = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if not chromium:
        left_out("the checks of the page of `isomend view`", "there is no Chromium (on Debian: apt install chromium)")
        return 0
    program, failed = arguments.isomend.resolve(), 0
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        base = Path(temporary)
        for name in ("scan", "textured", "million"):
            if arguments.only not in (None, name):
                continue
            folder, profile = base / name / "files", base / name / "profile"
            folder.mkdir(parents=True)
            profile.mkdir()
            keep = arguments.keep and arguments.keep / name
            if keep:
                keep.mkdir(exist_ok=True)
            page = Page(chromium, profile, keep)
            print(f"{name}:")
            try:
                if name == "million":
                    large(page, program, folder)
                else:
                    mesh = folder / ("scan.ply" if name == "scan" else "textured.glb")
                    shutil.copy(ROOT / "data/scan.ply", mesh) if name == "scan" else textured_glb(mesh)
                    session(page, program, folder, mesh, name)
            except RuntimeError as error:
                page.shot("failed")
                page.expect(False, str(error))
            finally:
                page.close()
            print(f"{name}: {'WRONG' if page.wrong else 'as it should be'}")
            failed += bool(page.wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
