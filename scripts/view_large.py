"""Times of the page of `isomend view` with a mesh of a million triangles: the first picture, clicks until they are seen, and strokes of the brush.
For view_test.py."""

import numpy as np

from browser_test import PICTURE
from view_meshes import bumpy_ball
from view_page import Server

# Seconds: upper bounds of the times, on a machine that needs REFERENCE for the work below; on a slower one they grow in proportion.
# A click is to be seen within 0.1 s; here the processor draws the picture, which takes up to twice as long.
FIRST_PICTURE, STROKE, CLICK = 3.0, 0.1, 0.2
# Seconds of the page's two kinds of work on the machine of these bounds, two quiet cores of 2023: computing, drawing.
REFERENCE = 0.030, 0.150
# Measurements of each time until it is within its bound: other programs slow single ones.
ROUNDS = 8
# Seconds of a fixed amount of work in the page: 2 million reads in random order; 100,000 triangles without the page's own code.
WORK = """(() => { const n = 1 << 21, values = new Float64Array(n), order = new Uint32Array(n);
  for (let i = 0, x = 1; i < n; i++) { x = Math.imul(x, 1664525) + 1013904223 | 0; order[i] = (x >>> 0) % n; values[i] = i; }
  const gl = new OffscreenCanvas(512, 512).getContext("webgl2"), program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, `void main() { int i = gl_VertexID / 3, k = gl_VertexID % 3;
      gl_Position = vec4(vec2(i % 400, i / 400) / 200.0 - 1.0 + vec2(k == 1, k == 2) * 0.01, 0.5, 1.0); }`],
      [gl.FRAGMENT_SHADER, "precision highp float; out vec4 colour; void main() { colour = vec4(sqrt(gl_FragCoord.x) * 0.04); }"]]) {
    const shader = gl.createShader(type); gl.shaderSource(shader, "#version 300 es\\n" + source); gl.compileShader(shader); gl.attachShader(program, shader); }
  gl.linkProgram(program); gl.useProgram(program);
  const compute = () => { let sum = 0; for (let i = 0; i < n; i++) sum += Math.sqrt(values[order[i]]); return sum; };
  const draw = () => { gl.drawArrays(gl.TRIANGLES, 0, 300_000); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); };
  const seconds = [compute, draw].map((work) => { work(); const start = performance.now(); work(); return (performance.now() - start) / 1000; });
  gl.getExtension("WEBGL_lose_context").loseContext();
  return seconds; })()"""
FRAMES = """(() => { const v = isomend.viewer, gl = v.gl, frame = (fewer) => { const t = performance.now(); v.camera.orbit(0.04, 0.02);
    v.draw(fewer); gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); return performance.now() - t; };
  for (let i = 0; i < 3; i++) frame(true); const moving = [1, 2, 3, 4, 5].map(() => frame(true)).sort((a, b) => a - b)[2];
  return { moving, thin: v.drewThin, coarse: v.coarse, whole: frame(false) }; })()"""
# Collects the milliseconds from each event of a mouse button until the page is painted after it, by the browser's own measure.
WATCH = """void (window.painted ??= (new PerformanceObserver((list) => { for (const { interactionId, duration } of list.getEntries()) if (interactionId) painted.push(duration); })
  .observe({ type: "event", durationThreshold: 16 }), []))"""
# Milliseconds of 15 strokes, each from the press of the button until it is drawn.
DRAWN_STROKES = """(() => { const p = isomend.paint, gl = isomend.viewer.gl, b = isomend.viewer.canvas, times = [];
  for (let i = 0; i < 15; i++) { const t = performance.now(); p.begin({ button: 0 }, [b.clientWidth * (0.4 + 0.01 * i), b.clientHeight * 0.72]).end({}, false);
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); times.push(performance.now() - t); } return times; })()"""


def slowness(page):
    """How many times longer this machine takes for a fixed amount of work than the one of the bounds; at least 1."""
    return max(1, *(seconds / reference for seconds, reference in zip(page.run(WORK), REFERENCE)))


def soon_enough(page, measured, bound, what):
    """Measures a time in seconds until it is within its bound, at most ROUNDS times."""
    seen = []
    for _ in range(ROUNDS):
        before, seconds = slowness(page), measured()
        slow = max(before, slowness(page))
        seen.append(f"{seconds:.3f} s of {bound * slow:.3f} s")
        if seconds < bound * slow:
            break
    else:
        page.expect(False, f"{what} takes too long: {', '.join(seen)}")
    print(f"  {what}: {', '.join(seen)}", flush=True)


def seen(page, *places):
    """The longest time, in seconds, until a click is seen, of clicks at these points of the window. The first is made while nothing is drawn, each
    further one while the full picture is drawn."""
    page.run(WATCH)
    page.calm()
    for number, (x, y) in enumerate(places):
        if number:
            page.until("isomend.viewer.still.end !== null", "the full picture is being drawn")
        page.run("painted.length = 0")
        page.click(x, y)
    page.calm()
    # The browser tells a time once the frame is shown, and none below 16 ms.
    return page.run("new Promise((tell) => requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(() => tell(Math.max(16, ...painted))))))") / 1000


def check_clicks(page):
    """A click is seen soon, also one while the full picture is being drawn: in a coarse picture first."""
    page.tab("holes")
    rows = [page.run(f"(() => {{ const b = document.querySelector('#holes li:nth-child({n}) .hole').getBoundingClientRect(); return [b.x + 20, b.y + b.height / 2]; }})()") for n in (1, 2)]
    soon_enough(page, lambda: seen(page, rows[0]), CLICK, "a click on a hole's row until it is seen")
    soon_enough(page, lambda: seen(page, rows[1], rows[0]), CLICK, "a click while the full picture is drawn")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()
    x, y, width, height = page.view()
    soon_enough(page, lambda: seen(page, (x + 0.3 * width, y + 0.3 * height)), CLICK, "a click on the surface")
    for name, tab in (("the tab Make printable", "#tab-print"), ("the tab Fill holes", "#tab-holes")):
        at = page.run(f"(() => {{ const b = document.querySelector('{tab}').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()")
        soon_enough(page, lambda at=at: seen(page, at), CLICK, f"a click on {name}")


def colour_at(page, x, y):
    """The colour of the pixel of the view at a point of the window, as it was drawn last."""
    page.calm(PICTURE)
    return page.run(f"""(() => {{ const v = isomend.viewer, gl = v.gl, b = v.canvas.getBoundingClientRect(), p = new Uint8Array(4);
        gl.readPixels({x} - b.x, v.canvas.height - ({y} - b.y), 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p); return [...p]; }})()""")


def check_drawn_over(page):
    """While the button is down only the marked faces are drawn; the picture is the same as when everything is drawn."""
    x, y, width, height = page.view()
    at = [x + width * 0.5, y + height * 0.3]
    plain = colour_at(page, *at)
    page.call("Input.dispatchMouseEvent", type="mousePressed", x=at[0], y=at[1], button="left", buttons=1, clickCount=1)
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=at[0] + 5, y=at[1], button="left", buttons=1)
    marked = colour_at(page, *at)
    page.call("Input.dispatchMouseEvent", type="mouseReleased", x=at[0] + 5, y=at[1], button="left", clickCount=1)
    page.run("isomend.viewer.draw()")
    page.expect(marked != plain, "the brush leaves no mark while the button is down")
    page.expect(colour_at(page, *at) == marked, "a mark has another colour once everything is drawn again")
    page.key("z", modifiers=2)
    page.settled()
    page.expect(colour_at(page, *at) == plain, "a mark stays when its stroke is undone")


def large(page, program, folder):
    """Measures the times of the first picture and of strokes with a million triangles."""
    mesh = folder / "million.ply"
    print(f"  {bumpy_ball(mesh, 503)} triangles")
    server = Server(program, mesh, folder / "log.txt")
    try:
        def first():
            page.start(server)
            return page.run("isomend.times.first") / 1000

        soon_enough(page, first, FIRST_PICTURE, "first picture after the request of the page")
        page.until("!!isomend.mask() && !!isomend.viewer.sides.after.surface.order", "the surface is prepared")
        frames = page.run(FRAMES)
        what = ("fewer faces" if frames["thin"] else "all faces") + (" at half the resolution" if frames["coarse"] else "")
        print(f"  moving {frames['moving']:.0f} ms a frame ({what}), still {frames['whole']:.0f} ms")
        check_clicks(page)
        page.tab("paint")
        page.click_on("[name=tool][value=brush] + span")
        page.settled()
        x, y, width, height = page.view()

        def strokes():
            page.run("isomend.paint.times = []")
            for row in range(4):
                page.drag([[x + width * (0.35 + 0.02 * i), y + height * (0.35 + 0.1 * row)] for i in range(15)])
            # Other load of the machine slows single strokes, so the 25th percentile counts.
            return np.percentile(page.run("isomend.paint.times"), 25) / 1000

        check_drawn_over(page)
        soon_enough(page, strokes, STROKE, "a touch of the brush")
        soon_enough(page, lambda: np.percentile(page.run(DRAWN_STROKES), 25) / 1000, STROKE, "a stroke of the brush until it is drawn")
        page.expect(page.run("isomend.mask().count") > 1000, "the strokes mark next to nothing")
        page.shot("million")
        page.tell_troubles()
    finally:
        server.stop()
