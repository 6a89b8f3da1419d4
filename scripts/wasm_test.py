# /// script
# requires-python = ">=3.11"
# dependencies = ["pillow==13.0.0", "websocket-client==1.9.2"]
# ///
"""Test the site that scripts/wasm.sh makes, in headless Chromium: the page of `isomend view` without a server program.

    scripts/wasm.sh DIR && python3 scripts/wasm_test.py DIR/site [--isomend PROGRAM] [--keep FOLDER] [--picture FILE]

The example is opened, filled, saved and downloaded: the bytes must be what the program writes. A step is cancelled, and the steps before it
come back. Another mesh is opened, and a file that is no mesh is refused. Nothing may be requested from other addresses, and no error
written to the console. `--keep` keeps screenshots; `--picture` makes data/browser.png. The exit code is 1 if a test fails. Without
Chromium the tests are left out, with a message; with CI=true this is a failure."""

import argparse
import base64
import functools
import http.server
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

from browser_test import NAMES, ROOT, Browser
from left_out import left_out

FRAME = "document.querySelector('#page').contentWindow"
READY = f"{FRAME}?.isomend?.model?.state && {FRAME}.document.documentElement.dataset.state === 'ready'"
DONE = f"!{FRAME}.isomend.steps.job && {FRAME}.isomend.model.state.current === {{}} && {FRAME}.isomend.display.shown.after !== null"


def save(site, target):
    """A screenshot once the numbers of the holes are placed, at most 256 colours."""
    # Only the picture takes Pillow.
    from view_picture import reduced_to

    site.until(f"{FRAME}.isomend.labels.settled && !{FRAME}.document.documentElement.dataset.pending", "the numbers are placed")
    reduced_to(site.call("Page.captureScreenshot")["data"], target)


class Files(http.server.SimpleHTTPRequestHandler):
    """The files of the site."""

    extensions_map = http.server.SimpleHTTPRequestHandler.extensions_map | {".js": "text/javascript", ".wasm": "application/wasm"}

    def log_message(self, *_):
        pass


class Site(Browser):
    """The site in the browser."""

    def __init__(self, chromium, folder, address, keep):
        super().__init__(chromium, folder, offline=False)
        self.address, self.keep, self.wrong = address, keep, []
        self.size(1280, 800)
        self.call("Page.navigate", url=address)
        self.until("document.readyState === 'complete'", "the site is loaded")

    def expect(self, right, what):
        if not right:
            self.wrong.append(what)
            print("    WRONG:", what)

    def shot(self, name):
        if self.keep:
            self.screenshot(self.keep / f"site_{name}.png")

    def drop(self, name, data):
        """Gives a file to the site, as if it were dropped on it."""
        text = base64.b64encode(data).decode()
        self.run(f"""(() => {{ const bytes = Uint8Array.from(atob({json.dumps(text)}), (c) => c.charCodeAt(0)), files = new DataTransfer();
            files.items.add(new File([bytes], {json.dumps(name)}));
            dispatchEvent(new DragEvent("drop", {{ dataTransfer: files, cancelable: true }})); }})()""")

    def fill(self):
        """Fills the chosen holes with the usual parameters."""
        self.run(f"{FRAME}.document.querySelector('#tab-print').click()")
        self.run(f"{FRAME}.document.querySelector('#run').click()")

    def save(self, path, overwrite):
        """Saves the mesh as the page does; returns the answer."""
        sent = json.dumps({"kind": "mesh", "path": path, "overwrite": overwrite})
        return json.loads(self.run(f"""(async () => JSON.stringify(await (await {FRAME}.fetch("api/save", {{ method: "POST",
            headers: {{ "Content-Type": "application/json" }}, body: {json.dumps(sent)} }})).json()))()"""))

    def fetched(self, path):
        """What the program answers to a request of the page."""
        return base64.b64decode(self.run(f"""(async () => {{ const bytes = new Uint8Array(await (await {FRAME}.fetch({json.dumps(path)})).arrayBuffer());
            let text = ""; for (const byte of bytes) text += String.fromCharCode(byte); return btoa(text); }})()"""))


def filled(site, program, folder, picture):
    """The example is filled as by the program, saved, and its report opened."""
    site.shot("start")
    site.run("document.querySelector('#example').click()")
    site.until(READY, "the example is shown")
    site.shot("example")
    site.fill()
    site.until(f"{FRAME}.isomend.steps.job !== null", "the step has begun")
    site.until(DONE.format(1), "the holes are filled")
    site.shot("filled")
    if picture:
        save(site, picture)
    own = site.fetched("api/download/1?format=ply&file=mesh")
    recipe = json.loads(site.fetched("api/recipe"))["shell"]
    shutil.copy(ROOT / "data/scan.ply", folder)
    (folder / "isomend").symlink_to(program.resolve())
    subprocess.run(["sh", "-c", recipe], cwd=folder, check=True, capture_output=True, env=os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"})
    site.expect(own == (folder / "scan_mended.ply").read_bytes(), f"the recipe gives other bytes than the page: {recipe}")
    report = site.fetched("api/report/1").decode()
    site.expect("<title>" in report, "there is no report")
    saved = site.save("whole.ply", False)
    site.expect(saved.get("error") is None, f"saving fails: {saved}")
    site.until("document.querySelector('#files').textContent.includes('whole.ply')", "the saved file can be downloaded")
    site.expect(site.save("whole.ply", True).get("error") is None, "a saved file cannot be replaced")
    state = json.loads(site.fetched("api/state"))
    site.expect(state["session"]["error"] is None, f"the session is not stored: {state['session']['error']}")
    site.shot("saved")


def cancelled(site):
    """A step is cancelled: the step before it is still there, with the same bytes."""
    before = site.fetched("api/download/1?format=ply&file=mesh")
    site.run(f"{FRAME}.document.querySelector('#tab-print').click()")
    site.run(f"{FRAME}.document.querySelector('input[value=repair]').click()")
    site.run(f"{FRAME}.document.querySelector('#run').click()")
    site.until(f"{FRAME}.isomend.steps.job !== null && {FRAME}.isomend.steps.job.share > 0", "the repair works")
    site.run(f"{FRAME}.document.querySelector('#cancel').click()")
    site.until(f"{READY} && {DONE.format(1)}", "the step before comes back")
    site.shot("cancelled")
    site.expect(site.fetched("api/download/1?format=ply&file=mesh") == before, "the step before has other bytes")


def opened(site):
    """Another mesh is opened in place of the first; what is no mesh is refused."""
    site.drop("notes.txt", b"nothing")
    site.until("document.querySelector('#notice').textContent.includes('no mesh')", "a text is refused")
    site.drop("bad.ply", b"ply\nformat ascii 1.0\nelement vertex 3\n")
    site.until("document.querySelector('#notice').textContent.includes('bad.ply')", "a damaged file is refused")
    site.expect(site.run("document.querySelector('#start').hidden"), "the start page covers the mesh")
    # Another mesh of the same name does not take the place of the first.
    site.drop("scan.ply", (ROOT / "data/slab.ply").read_bytes())
    site.until(f"{READY} && {FRAME}.isomend.model.state.file.name === 'scan (2).ply'", "the other scan.ply is shown")
    site.drop("torus.ply", (ROOT / "data/torus.ply").read_bytes())
    site.until(f"{READY} && {FRAME}.isomend.model.state.file.name === 'torus.ply'", "the torus is shown")
    site.expect(site.run(f"{FRAME}.isomend.model.state.current") == 0, "the torus has steps of another mesh")
    site.shot("torus")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("site", type=Path)
    parser.add_argument("--isomend", default=ROOT / "target/release/isomend", type=Path)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--picture", type=Path)
    arguments = parser.parse_args()
    chromium = next(filter(None, map(shutil.which, NAMES)), None)
    if not chromium:
        return left_out("the site in a browser: there is no Chromium")
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Files, directory=arguments.site))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        (folder / "profile").mkdir()
        site = Site(chromium, folder / "profile", f"http://127.0.0.1:{server.server_port}/", arguments.keep)
        try:
            for what, test in (("filled", lambda: filled(site, arguments.isomend, folder, arguments.picture)), ("cancelled", lambda: cancelled(site)), ("opened", lambda: opened(site))):
                before = len(site.wrong)
                test()
                print(f"{what}: {'right' if len(site.wrong) == before else 'WRONG'}")
        finally:
            site.shot("end")
            site.close()
    for trouble in site.troubles:
        site.expect(False, f"console: {trouble}")
    outside = [url for url in site.requests if not url.startswith((site.address, "data:", "about:", "blob:"))]
    site.expect(not outside, f"the site requests {outside[:3]}")
    return 1 if site.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
