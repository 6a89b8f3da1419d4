# /// script
# requires-python = ">=3.11"
# dependencies = ["websocket-client==1.9.2"]
# ///
"""Test the pages that --report writes: open them in headless Chromium, without a network, and use them.

    cargo build --release && python3 scripts/browser_test.py [--isomend PROGRAM] [--keep FOLDER]

For a fill, a restoration and a fairing: the page must become ready, draw something, change the view when a hole is clicked and when
an option is switched, list every hole, number the visible holes, show and copy the point under a click, request nothing from outside,
and write no error to the console. The page of `isomend inspect`, which has one mesh, must do the same. `--keep` keeps the pages and
screenshots in a folder. The exit code is 1 if a test fails. If there is no Chromium the tests are left out, with a message; with
CI=true this is a failure."""

import argparse
import base64
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import urllib.request
from pathlib import Path

import websocket

from left_out import left_out

ROOT = Path(__file__).resolve().parent.parent
NAMES = ("chromium", "chromium-browser", "google-chrome")
# The picture of the view: the part of its pixels that is not background, the number of hues, and a hash of all pixels.
DRAWN = """(() => {
  const viewer = window.isomend.viewer, gl = viewer.gl;
  viewer.draw();
  const w = gl.drawingBufferWidth, h = gl.drawingBufferHeight, pixels = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const words = new Uint32Array(pixels.buffer), [red, green, blue] = pixels;
  let drawn = 0, hash = 0;
  const hues = new Set();
  for (let i = 0; i < words.length; i++) {
    const word = words[i], r = word & 255, g = word >> 8 & 255, b = word >> 16 & 255;
    hash = (Math.imul(hash, 31) + word) | 0;
    if (word === words[0]) continue;
    if (Math.abs(r - red) > 12 || Math.abs(g - green) > 12 || Math.abs(b - blue) > 12) drawn++;
    const top = Math.max(r, g, b), range = top - Math.min(r, g, b);
    if (range > 50) {
      const sector = top === r ? (g - b) / range : top === g ? 2 + (b - r) / range : 4 + (r - g) / range;
      hues.add(Math.floor(4 * sector + 24) % 24);
    }
  }
  return { part: drawn / (w * h), hues: hues.size, hash, error: gl.getError() };
})()"""
# Kinds of unfinished work that the page tells (activity.js): what changes the picture, and everything but a run of the program.
PICTURE = ("flight", "frame", "motion")
ACTIONS = (*PICTURE, "request", "worker")
# Whether a page is loaded and has no unfinished work of the given kinds.
CALM = """((kinds) => { const root = document.documentElement, { state, pending = "" } = root?.dataset ?? {};
  return document.readyState === "complete" && state === "ready" && !pending.split(" ").some((kind) => kinds.includes(kind)); })(%s)"""
# Where an element can be clicked: its middle, or why it cannot be. The next click sets `window.hit`: whether it was on the element.
TARGET = """((query) => {
  const element = document.querySelector(query), name = (e) => e ? e.tagName + (e.id && "#" + e.id) : "nothing";
  if (!element) return "it does not exist";
  if (element.matches(":disabled")) return "it is disabled";
  element.scrollIntoView({ block: "center" });
  const b = element.getBoundingClientRect(), at = [b.x + b.width / 2, b.y + b.height / 2], met = document.elementFromPoint(...at);
  // A label and the input in it are one.
  const label = (e) => e.closest("label") ?? e.labels?.[0] ?? e, own = (e) => Boolean(e) && (element.contains(e) || label(e) === label(element));
  if (!b.width || !own(met)) return `${name(met)} is at its place`;
  window.hit = "nothing";
  addEventListener("click", (event) => { window.hit = own(event.target) ? "hit" : name(event.target); }, { capture: true, once: true });
  return at; })(%s)"""
# Options of the browser where nobody looks at the pictures and no time is measured: the processor draws, which takes most of the time of a test.
COARSE = ["--webgl-antialiasing-mode=none", "--disable-gpu-compositing"]
# Upper bound of a wait, in seconds: a wait that takes longer has failed.
MOST_WAIT = 300
# What the browser says where the page of a script is gone before the script has ended.
NAVIGATED = ("navigated or closed", "context was destroyed", "Cannot find context", "Cannot find default execution context", "Promise was collected")


class Navigated(RuntimeError):
    """The browser went to another page while a script ran."""


class Browser:
    """Chromium with one page, controlled through its debugging protocol. With `coarse` it draws a quarter as many pixels along each side, without
    antialiasing."""

    def __init__(self, program, folder, offline=True, coarse=False):
        self.coarse, self.scale = coarse, 0.25 if coarse else 1
        command = [program, "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle",
                   "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars", "--no-first-run",
                   "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-pings",
                   # On a slow machine a picture may take longer than the 10 s after which Chromium restarts its drawing process.
                   "--disable-gpu-watchdog", "--disable-background-timer-throttling", "--disable-renderer-backgrounding",
                   "--remote-debugging-port=0", "--remote-allow-origins=*", f"--user-data-dir={folder}", *(COARSE if coarse else []), "about:blank"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port = folder / "DevToolsActivePort"
        deadline = time.monotonic() + MOST_WAIT
        while not (port.exists() and port.read_text().count("\n")):
            if time.monotonic() > deadline or self.process.poll() is not None:
                self.close()
                raise SystemExit("Chromium does not start")
            time.sleep(0.1)
        address = f"127.0.0.1:{port.read_text().split()[0]}"
        local = urllib.request.build_opener(urllib.request.ProxyHandler({}))
        pages = json.load(local.open(f"http://{address}/json", timeout=MOST_WAIT))
        target = next(p for p in pages if p["type"] == "page")
        self.socket = websocket.create_connection(target["webSocketDebuggerUrl"], timeout=MOST_WAIT, http_no_proxy=["*"])
        self.count, self.troubles, self.requests = 0, [], []
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        if offline:
            self.call("Network.emulateNetworkConditions", offline=True, latency=0, downloadThroughput=0, uploadThroughput=0)

    def call(self, method, **parameters):
        self.count += 1
        self.socket.send(json.dumps({"id": self.count, "method": method, "params": parameters}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.count:
                if "error" in message:
                    kind = Navigated if any(said in str(message["error"]) for said in NAVIGATED) else RuntimeError
                    raise kind(f"{method}: {message['error']}")
                return message["result"]
            self.note(message)

    def note(self, message):
        """Records the page's errors and requests."""
        what, detail = message.get("method"), message.get("params", {})
        if what == "Runtime.exceptionThrown":
            self.troubles.append(detail["exceptionDetails"].get("exception", {}).get("description", "exception"))
        elif what == "Runtime.consoleAPICalled" and detail["type"] in ("error", "warning", "assert"):
            self.troubles.append(" ".join(str(a.get("value", a)) for a in detail["args"]))
        elif what == "Log.entryAdded" and detail["entry"]["level"] == "error":
            self.troubles.append(detail["entry"]["text"])
        elif what == "Network.requestWillBeSent":
            self.requests.append(detail["request"]["url"])

    def run(self, script):
        done = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in done:
            raise RuntimeError(f"{script[:60]}: {done['exceptionDetails']}")
        return done["result"].get("value")

    def leave(self, script):
        """Runs a script that makes the browser go to another page, which may happen before or after the script's answer."""
        with contextlib.suppress(Navigated):
            self.run(f"void ({script})")

    def until(self, script, what):
        def true():
            # While the browser goes to another page, no script runs.
            with contextlib.suppress(Navigated):
                return self.run(script)

        deadline = time.monotonic() + MOST_WAIT
        while not true():
            if time.monotonic() > deadline:
                raise RuntimeError(f"after {MOST_WAIT} s it is not true that {what}; {self.described()}")
            time.sleep(0.02)

    def described(self):
        """The state that the page tells, for messages."""
        return self.run("""(() => { const { state, pending } = document.documentElement.dataset;
            return `the page is ${state}, pending: ${pending || "nothing"}, ${window.isomend?.viewer?.frames} frames drawn; it says: ${document.body.innerText.slice(0, 300)}`; })()""")

    def calm(self, kinds=ACTIONS):
        """Waits until the page has no unfinished work of these kinds."""
        self.until(CALM % json.dumps(kinds), f"the page has no unfinished {', '.join(kinds)}")

    def size(self, width, height):
        """Gives the window a size in pixels of the page."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=self.scale, mobile=False)

    def open(self, page, width=1280, height=900):
        self.size(width, height)
        # The page before may have the same address, and be ready.
        self.run("window.isLeft = true")
        self.call("Page.navigate", url=page if isinstance(page, str) else page.as_uri())
        self.until("!window.isLeft && document.readyState === 'complete' && !!document.documentElement.dataset.state", "the page is ready")

    def click(self, x, y, modifiers=0):
        for kind in ("mousePressed", "mouseReleased"):
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1, modifiers=modifiers)

    def click_on(self, query):
        """Clicks on the element of a selector once the page is calm and the element can be clicked. A click that something else gets, because
        the page has changed between its two events, is made again."""
        why, deadline = None, time.monotonic() + MOST_WAIT
        while time.monotonic() < deadline:
            self.calm()
            at = self.run(TARGET % json.dumps(query))
            if isinstance(at, list):
                self.click(*at)
                try:
                    why = self.run("window.hit ?? 'hit'")
                except Navigated:
                    return
                if why == "hit":
                    return
                why += " got the click"
            else:
                why = at
            time.sleep(0.02)
        raise RuntimeError(f"{query} cannot be clicked: {why}; {self.described()}")

    def settled(self):
        """Waits until all that changes the picture has ended; returns the picture as DRAWN does."""
        self.calm(PICTURE)
        return self.run(DRAWN)

    def screenshot(self, path):
        path.write_bytes(base64.b64decode(self.call("Page.captureScreenshot")["data"]))

    def close(self):
        self.process.terminate()
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def finish(failures):
    """Prints one line for each failed check, at the end of the output, which scripts/test.sh repeats; returns the exit code."""
    for name, what in failures:
        print(f"FAILED {name}: {' '.join(what.split())[:400]}", flush=True)
    return 1 if failures else 0


def check(browser, page, keep):
    """Tests a page; returns a list of what is wrong."""
    wrong = []
    browser.troubles.clear()
    browser.requests.clear()
    browser.open(page)
    if browser.run("document.documentElement.dataset.state") != "ready":
        return [browser.run("document.querySelector('#message').textContent")]

    def expect(right, what):
        if not right:
            wrong.append(what)

    first = browser.settled()
    expect(first["part"] > 0.05, f"only {first['part']:.1%} of the view is drawn")
    expect(first["error"] == 0, f"WebGL error {first['error']}")
    holes = browser.run("JSON.parse(document.querySelector('#data').textContent).holes.map(h => h.id)")
    listed = browser.run("document.querySelectorAll('#holes button').length")
    expect(holes and listed == len(holes), f"{listed} of {len(holes)} holes are listed")
    if keep:
        browser.screenshot(keep / f"{page.stem}.png")

    seen = {first["hash"]}

    def changes(what):
        now = browser.settled()
        expect(now["hash"] not in seen, f"the view is the same after {what}")
        expect(now["part"] > 0.05, f"only {now['part']:.1%} is drawn after {what}")
        seen.add(now["hash"])

    wanted = holes[-1] if len(holes) < 3 else holes[1]
    browser.click_on(f"#holes button[data-hole='{wanted}']")
    browser.until(f"document.querySelector(\"#holes button[data-hole='{wanted}']\").getAttribute('aria-pressed') === 'true'",
                  "the hole is chosen")
    changes(f"clicking hole {wanted}")
    if keep:
        browser.screenshot(keep / f"{page.stem}_hole.png")
    known = browser.run("isomend.viewer.mesh.error > 0 && !document.querySelector('#errors').hidden")
    errors = [("[name=colour][value=error] + span", "expected errors")] if known else []
    for query, what in (("[name=wire] + span", "switching edges on"), ("[name=colour][value=curvature] + span", "curvature"),
                        ("[name=colour][value=distance] + span", "distance"), *errors, ("[name=flat] + span", "flat shading"),
                        ("[name=show][value=before] + span", "showing the mesh before"),
                        ("[name=show][value=after] + span", "showing the mesh after"), ("#theme", "the other theme")):
        browser.click_on(query)
        changes(what)
        if what in ("curvature", "distance", "expected errors"):
            browser.run("isomend.viewer.options.rims = false")
            hues = browser.run(DRAWN)["hues"]
            expect(hues >= (1 if what == "curvature" else 3), f"{what} shows {hues} hues")
            browser.run("isomend.viewer.options.rims = true")
        if keep:
            browser.screenshot(keep / f"{page.stem}_{what.split()[-1]}.png")
    browser.run("document.querySelector('#view').focus()")
    browser.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowLeft", code="ArrowLeft")
    changes("an arrow key")

    # From the start view a click hits the patch of the first hole that has one.
    region = browser.run("""(() => { window.isomend.choose(null); const d = JSON.parse(document.querySelector('#data').textContent);
        document.querySelector('[name=show][value=after]').click(); return d.holes.find(h => h.region && !h.open)?.id ?? 0; })()""")
    if region:
        browser.run(f"window.isomend.choose({region})")
        browser.settled()
        browser.run("window.isomend.choose(null)")
        x, y = browser.run("""(() => { const v = window.isomend.viewer, c = v.canvas; c.scrollIntoView({block: 'center'});
            const m = v.mesh, b = c.getBoundingClientRect();
            for (let y = 0.5; y < 0.95; y += 0.02) for (const s of [1, -1]) for (let x = 0; x < 0.4; x += 0.02) {
              const p = [b.width * (0.5 + s * x), b.height * y]; if (v.pick(...p).region) return [b.x + p[0], b.y + p[1]]; }
            return [-1, -1]; })()""")
        expect(x >= 0, "no patch is under any point of the view")
        browser.click(x, y)
        browser.settled()
        expect(browser.run("document.querySelectorAll('#holes [aria-pressed=true]').length") == 1,
               "a click on a patch chooses no hole")
    check_labels(browser, expect)
    check_point(browser, expect)
    outside = [url for url in browser.requests if not url.startswith(("file:", "data:", "about:"))]
    expect(not outside, f"the page requests {outside[:3]}")
    wrong.extend(f"console: {trouble}" for trouble in browser.troubles)
    return wrong


# The numbers shown, and the positions on the page of the rims of their holes.
LABELS = """(() => { const { labels, viewer } = window.isomend;
  return [...document.querySelectorAll('#labels .label:not([hidden])')].map((l) => Number(l.textContent)); })()"""


def check_labels(browser, expect):
    """Tests that numbers are placed at the holes, and hidden if a hole is seen from behind."""
    browser.run("window.isomend.choose(null); document.querySelector('[name=show][value=before]').click()")
    largest = browser.run("JSON.parse(document.querySelector('#data').textContent).holes[0].id")
    browser.run(f"window.isomend.choose({largest})")
    browser.settled()
    rest = "window.isomend.labels.settled"
    browser.until(rest, "the numbers are placed")
    shown = browser.run(LABELS)
    expect(largest in shown, f"from before hole {largest} the numbers are {shown}")
    off = browser.run(f"""(() => {{ const l = [...document.querySelectorAll('#labels .label:not([hidden])')].find(l => l.textContent == {largest});
        if (!l) return 1e9;
        const a = l.getBoundingClientRect(), b = document.querySelector('#view').getBoundingClientRect();
        return Math.hypot(a.x + a.width / 2 - b.x - b.width / 2, a.y + a.height / 2 - b.y - b.height / 2); }})()""")
    expect(off < 3, f"the number of the hole in the middle is {off} pixels away from there")
    browser.run("document.querySelector('[name=rims]').click()")
    browser.settled()
    browser.until(rest, "the numbers are placed")
    expect(not browser.run(LABELS), "numbers are shown without rims")
    browser.run("document.querySelector('[name=rims]').click()")
    # Look from behind at holes until one is wholly covered by surface: through another hole its number would be seen.
    for hole in browser.run("JSON.parse(document.querySelector('#data').textContent).holes.slice(0, 16).map(h => [h.id, h.diameter])"):
        browser.run(f"window.isomend.choose({hole[0]})")
        browser.settled()
        hidden = browser.run(f"""(() => {{ const v = window.isomend.viewer, c = v.camera; v.flight = null;
            const p = c.centre, back = c.axes[2].map(x => -x);
            c.axes = [c.axes[0].map(x => -x), c.axes[1], back]; c.reach = v.mesh.radius; v.refresh();
            const along = v.camera.axes[2], w = v.canvas.clientWidth, h = v.canvas.clientHeight;
            const reach = 0.5 * {hole[1]} / (2 * c.reach) * Math.min(w, h);
            const covers = (x, y) => {{ const hit = v.pick(w / 2 + x * reach, h / 2 + y * reach);
              return Boolean(hit.point) && hit.point.reduce((s, x, i) => s + (x - p[i]) * along[i], 0) > 0.5 * {hole[1]}; }};
            const steps = [-1, -0.5, 0, 0.5, 1];
            return steps.every(x => steps.every(y => x * x + y * y > 1 || covers(x, y))); }})()""")
        browser.settled()
        browser.until(rest, "the numbers are placed")
        if hidden:
            shown = browser.run(LABELS)
            expect(hole[0] not in shown, f"from behind hole {hole[0]} the numbers are {shown}")
            return True
    return False


def check_point(browser, expect):
    """Tests that a click on the surface shows and copies the point under it, or with Alt a ball round this point."""
    def place():
        """A point of the window over the mesh's own surface, and the point of the mesh there."""
        browser.run("document.querySelector('#view').scrollIntoView({block: 'center'})")
        browser.settled()
        return browser.run("""(() => { const v = window.isomend.viewer, b = v.canvas.getBoundingClientRect();
            const o = JSON.parse(document.querySelector('#data').textContent).scene.origin;
            for (let y = 0.5; y < 0.95; y += 0.03) for (let x = 0.3; x < 0.7; x += 0.03) {
              const hit = v.pick(b.width * x, b.height * y);
              if (hit.point && !hit.region) return [b.x + b.width * x, b.y + b.height * y, hit.point.map((p, i) => p + o[i])]; }
            return [-1, -1, []]; })()""")

    x, y, wanted = place()
    if x < 0:
        expect(False, "no surface is under any point of the view")
        return
    browser.run("window.isomend.point.copied = null")
    browser.click(x, y)
    browser.until("document.querySelector('#point-at').textContent.includes(',')", "the point is shown")
    expect(browser.run("window.isomend.point.copied") is None, "a click without the copy button copies the point")
    browser.click_on("#copy-point")
    browser.until("!!window.isomend.point.copied", "the point is copied")
    shown = browser.run("document.querySelector('#point-at').textContent")
    numbers = [float(n) for n in shown.split(",")]
    size = browser.run("window.isomend.viewer.mesh.radius")
    expect(len(numbers) == 3 and all(abs(a - b) < 1e-4 * size for a, b in zip(numbers, wanted)),
           f"the point is {shown}, not {wanted}")
    expect(browser.run("window.isomend.point.copied") == shown, "the copy is not what is shown")
    expect("copied: " + shown == browser.run("document.querySelector('#copied').textContent"), "the copied text is not shown")
    browser.run("window.isomend.point.copied = null")
    browser.click_on("#copy-ball")
    browser.until("!!window.isomend.point.copied", "the ball is copied")
    ball = browser.run("window.isomend.point.copied")
    expect(ball.startswith(f"--ball {shown},") and abs(float(ball.split(",")[3]) / (size / 10) - 1) < 0.01, f"the ball is {ball}")
    browser.run("document.querySelector('#ball-radius').value = '0'; window.isomend.point.copied = null")
    browser.click_on("#copy-ball")
    expect("positive" in browser.run("document.querySelector('#copied').textContent"), "a radius of 0 is taken")
    browser.run("document.querySelector('#ball-radius').value = '2.5'")
    x, y, _ = place()
    browser.click(x, y, modifiers=1)
    browser.until("!!window.isomend.point.copied", "the ball is copied")
    ball = browser.run("window.isomend.point.copied")
    shown = browser.run("document.querySelector('#point-at').textContent")
    expect(ball == f"--ball {shown},2.5", f"with Alt the ball is {ball}")


def check_inspection(browser, page, keep):
    """Tests the page of `isomend inspect`; returns a list of what is wrong."""
    wrong = []
    browser.troubles.clear()
    browser.open(page)
    if browser.run("document.documentElement.dataset.state") != "ready":
        return [browser.run("document.querySelector('#message').textContent")]

    def expect(right, what):
        if not right:
            wrong.append(what)

    expect(browser.settled()["part"] > 0.05, "nothing is drawn")
    visible = "getComputedStyle(document.querySelector('%s')).display !== 'none'"
    expect(not browser.run(visible % "fieldset.change"), "before and after are offered")
    expect(not browser.run(visible % ".regions"), "regions are shown")
    for key in ("2", "3", "c", "c"):
        browser.call("Input.dispatchKeyEvent", type="keyDown", key=key)
    expect(browser.run("window.isomend.viewer.options.show") == "before", "a key shows the other side")
    expect(check_labels(browser, expect), "no hole can be looked at from behind")
    if keep:
        browser.screenshot(keep / f"{page.stem}_behind.png")
    check_point(browser, expect)
    wrong.extend(f"console: {trouble}" for trouble in browser.troubles)
    return wrong


def make_pages(program, folder):
    """Makes the pages of all commands, one of them for a file name with HTML in it."""
    scan = folder / "a <b>'\"</script>& scan.ply"
    scan.parent.mkdir()
    shutil.copy(ROOT / "data/scan.ply", scan)
    runs = {
        "fill": ["fill", scan, "-o", folder / "mended.ply"],
        "restore": ["restore", ROOT / "data/sphere.ply", "-o", folder / "restored.ply", "--ball", "0,0,-1,0.4"],
        "fair": ["fair", ROOT / "data/sphere.ply", "-o", folder / "faired.ply", "--ball", "0,0,-1,0.5"],
        "whole": ["fair", ROOT / "data/sphere.ply", "-o", folder / "whole.ply", "--strength", "1"],
    }
    for name, arguments in runs.items():
        page = folder / f"{name}.html"
        subprocess.run([program, *arguments, "--report", page, "-q"], check=True)
        yield page
    page = folder / "inspect.html"
    arguments = ["inspect", ROOT / "data/sphere.ply", "--report", page]
    subprocess.run([program, *arguments], check=True, stdout=subprocess.DEVNULL)
    yield page


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    parser.add_argument("--keep", type=Path, help="folder in which to keep the pages and screenshots")
    arguments = parser.parse_args()
    chromium = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if not chromium:
        left_out("the report's checks in a browser", "there is no Chromium (on Debian: apt install chromium)")
        return 0
    failures = []
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        keep = arguments.keep
        if keep:
            keep.mkdir(parents=True, exist_ok=True)
        pages = list(make_pages(arguments.isomend.resolve(), Path(folder)))
        profile = Path(folder) / "profile"
        profile.mkdir()
        browser = Browser(chromium, profile, coarse=not arguments.keep)
        try:
            for page in pages:
                start = time.monotonic()
                try:
                    wrong = (check_inspection if page.stem == "inspect" else check)(browser, page, keep)
                except Exception as error:
                    traceback.print_exc()
                    wrong = [f"{type(error).__name__}: {error}"]
                word = "right" if not wrong else "WRONG"
                print(f"report of {page.stem}: {word} ({page.stat().st_size} bytes, {time.monotonic() - start:.0f} s)", flush=True)
                failures += [(f"report of {page.stem}", what) for what in wrong]
                if keep:
                    shutil.copy(page, keep)
        finally:
            browser.close()
    return finish(failures)


if __name__ == "__main__":
    sys.exit(main())
