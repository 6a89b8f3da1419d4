"""The server of the page of `isomend view`, and a browser with a user's actions on the page. For view_test.py."""

import contextlib
import http.client
import json
import re
import signal
import subprocess
from urllib.parse import urlsplit

from browser_test import MOST_WAIT, PICTURE, Browser, Navigated


class Server:
    """`isomend view`, running with a mesh."""

    def __init__(self, program, mesh, log, *options):
        self.log = open(log, "w")
        self.process = subprocess.Popen([program, "view", mesh, "--no-browser", *options], stdout=subprocess.PIPE, stderr=self.log, text=True)
        line = self.process.stdout.readline()
        found = re.search(r"http://\S+", line)
        if not found:
            raise RuntimeError(f"`isomend view` prints {line!r} instead of an address")
        self.address = found.group()

    def stop(self):
        """Stops the program with Ctrl-C; returns its exit code."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(MOST_WAIT)
        self.log.close()
        return code


# The element to click so that an element can be clicked: the summary of a closed part around it, or the button of its pane; or nothing.
OPENS = """((query) => { const element = document.querySelector(query), pane = element?.closest(".pane[hidden]");
  if (pane) return `[data-pane=${pane.id.slice(5)}]`;
  const closed = [...document.querySelectorAll("details:not([open])")].find((part) => part.contains(element) && element.closest("summary") !== part.firstElementChild);
  return closed ? `#${closed.id} > summary` : null; })(%s)"""
# A point of the window at the rim of a hole.
HOLE = """((id) => { const { viewer, holes } = isomend, b = viewer.canvas.getBoundingClientRect(), panes = viewer.panes();
  const pane = panes[panes.length - 1], mesh = viewer.sides.after.mesh, rim = mesh.rims[mesh.rimIds.indexOf(id)];
  for (let i = 0; i < rim.length; i += 3) {
    const at = viewer.onPage(rim.subarray(i, i + 3), pane);
    if (at && holes.at(viewer.pick(...at)) === id) return [b.x + at[0], b.y + at[1]]; }
  return [0, 0]; })"""
# The pane of each command.
PANES = {"fill": "holes", "restore": "paint", "fair": "paint", "repair": "print"}


class Page(Browser):
    """The page, with a user's actions."""

    def __init__(self, program, folder, keep, slow=1, coarse=False):
        super().__init__(program, folder, offline=False, coarse=coarse)
        self.wrong, self.keep = [], keep
        # The browser's own brake: the page's scripts take `slow` times as long.
        self.call("Emulation.setCPUThrottlingRate", rate=slow)

    def note(self, message):
        """Records errors, except for requests that the tests expect to fail: refused ones, and values that only one of two meshes has."""
        entry = message.get("params", {}).get("entry", {})
        if message.get("method") == "Log.entryAdded" and re.search(r"/api/(save|step|folder|values/\d+|mask/load)\b", entry.get("url", "")):
            return
        super().note(message)

    def expect(self, right, what):
        if not right:
            self.wrong.append(what)
            print("    WRONG:", what, flush=True)

    def shot(self, name):
        if self.keep:
            self.screenshot(self.keep / f"view_{name}.png")

    def start(self, server, forget=True, **size):
        """Opens the page; unless `forget` is false, without the settings that an earlier test chose, such as the language."""
        self.troubles.clear()
        if forget:
            self.call("Network.clearBrowserCookies")
        self.open(server.address, **size)
        if self.run("document.documentElement.dataset.state") != "ready":
            raise RuntimeError(self.run("document.querySelector('#message').textContent"))

    def key(self, key, modifiers=0, code=None):
        named = {"Enter": 13, "Escape": 27, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Tab": 9}
        text = {"text": key} if len(key) == 1 and modifiers & 6 == 0 else {"text": "\r"} if key == "Enter" else {}
        self.calm()
        number = named.get(key, ord(key.upper()[0]))
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, code=code or key, windowsVirtualKeyCode=number, modifiers=modifiers, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, code=code or key, windowsVirtualKeyCode=number, modifiers=modifiers)

    def drag(self, points, modifiers=0):
        """Drags with the left button over points of the window."""
        self.calm()
        x, y = points[0]
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, button="left", buttons=1, clickCount=1, modifiers=modifiers)
        for x, y in points[1:]:
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, button="left", buttons=1, modifiers=modifiers)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, button="left", clickCount=1, modifiers=modifiers)

    def fill_in(self, query, value):
        self.calm()
        self.run(f"""(() => {{ const e = document.querySelector({json.dumps(query)}); e.value = {json.dumps(value)};
            e.dispatchEvent(new Event("input", {{ bubbles: true }})); e.dispatchEvent(new Event("change", {{ bubbles: true }})); }})()""")

    def click_on(self, query):
        """Clicks on an element, first on what hides it. A sheet of the toolbar is closed afterwards."""
        for _ in range(4):
            opens = self.run(OPENS % json.dumps(query))
            if not opens:
                break
            super().click_on(opens)
        super().click_on(query)
        if "summary" not in query:
            with contextlib.suppress(Navigated):
                self.run("void document.querySelectorAll('.flyout[open]').forEach((sheet) => { sheet.open = false; })")

    def job(self, kind):
        """Opens the pane of a command, and chooses the command."""
        self.tab(PANES[kind])
        if PANES[kind] == "paint":
            self.click_on(f"[name=kind][value={kind}] + span")

    def run_command(self):
        """Clicks the button that runs the command of the pane."""
        self.click_on("#fill-all" if self.run("isomend.steps.kind") == "fill" else "#run")

    def tab(self, name):
        if self.run(f"document.querySelector('#pane-{name}').hidden"):
            self.click_on(f"#tab-{name}")
        self.until(f"!document.querySelector('#pane-{name}').hidden", f"the tab {name} is open")

    def state(self):
        return self.run("isomend.model.fetchState()")

    def until_done(self):
        """Waits until a run has ended, and its result is shown."""
        self.until("!isomend.steps.job && isomend.display.shown.after !== null", "the run has ended")
        self.calm()

    def until_open(self, name, what):
        """Waits until the page of another file, named `name`, is ready."""
        self.until(f"document.documentElement?.dataset.state === 'ready' && isomend.model?.state?.file.name === '{name}'", what)
        self.calm()

    def reaches(self, state, what):
        self.until(f"isomend.model.state.current === {state} && isomend.display.shown.after === {state} && !!isomend.mask()", what)
        self.calm()

    def view(self):
        """The box of the view in the window: x, y, width, height."""
        return self.run("(() => { const b = document.querySelector('#view').getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; })()")

    def surface(self, spread=0.25):
        """Points of the window that are over the surface, not over a hole."""
        self.calm(PICTURE)
        return self.run(f"""(() => {{ const v = isomend.viewer, b = v.canvas.getBoundingClientRect(), points = [];
            for (let y = 0.5 - {spread}; y <= 0.5 + {spread}; y += 0.05) for (let x = 0.5 - {spread}; x <= 0.5 + {spread}; x += 0.05) {{
              const hit = v.pick(b.width * x, b.height * y); if (!hit.point) continue;
              if (isomend.paint.target().topology.front(hit.face, v.camera.eye) > 0) points.push([b.x + b.width * x, b.y + b.height * y]); }}
            return points; }})()""")

    def tell_troubles(self):
        for trouble in self.troubles:
            self.expect(False, f"console: {trouble}")
        outside = [url for url in self.requests if not url.startswith(("http://127.0.0.1", "data:", "about:", "blob:"))]
        self.expect(not outside, f"the page requests {outside[:3]}")


def check_refusals(page, server):
    """Requests that do not come from the page are refused."""
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
        connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=MOST_WAIT)
        connection.request(method, path, body, headers)
        answer = connection.getresponse()
        text = answer.read()
        page.expect(400 <= answer.status < 500 and b"root:" not in text, f"{what} is answered with {answer.status}")
        connection.close()
