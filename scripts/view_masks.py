"""Tests of the smoothing brush, of named masks across steps, and of the folder of files on the page of `isomend view`, in Chromium. For
view_test.py."""

import json

from view_layout import check_layout
from view_page import Server

# The point of the window over the surface that is farthest from all rims.
INNER = """((points) => { const v = isomend.viewer, b = v.canvas.getBoundingClientRect(), rims = v.sides.after.mesh.rims; let best = [-1];
  for (const [x, y] of points) { const { point } = v.pick(x - b.x, y - b.y); let least = Infinity;
    for (const rim of rims) for (let i = 0; i < rim.length; i += 3) least = Math.min(least, Math.hypot(...point.map((p, k) => p - rim[i + k])));
    if (least > best[0]) best = [least, x, y]; }
  return best; })"""
# The number of faces that are drawn as a stroke of the smoothing brush.
STROKE = "isomend.viewer.sides.after.mesh.facts.filter((fact) => fact >>> 28 & 1).length"
# Keeps what the program tells of its runs back until `release()`, so that a run lasts as long as a test needs.
# The held events are heard at once, as they come: an event between them would be heard too early.
HOLD = """(() => { const { steps } = isomend, hear = steps.hear.bind(steps), held = [];
  steps.hear = async (...event) => { held.push(event); };
  window.release = () => { delete steps.hear; return Promise.all(held.map((event) => hear(...event))); }; })()"""
TROUBLE = "document.querySelector('#paint-trouble').textContent"
ROWS = "[...document.querySelectorAll('#masks li span')].map((e) => e.textContent).filter((text) => !text.startsWith('last region'))"


def inner(page):
    """A point of the window far from all rims, and its distance from them."""
    page.settled()
    distance, x, y = page.run(f"{INNER}({json.dumps(page.surface(0.3))})")
    return distance, x, y


def check_smoothing(page):
    """A stroke smooths the faces under it as one step; mask and strokes stay; a second stroke is refused meanwhile; undo takes it back."""
    page.tab("paint")
    distance, x, y = inner(page)
    page.run(f"isomend.setBrush({0.2 * distance})")
    page.key("b")
    page.drag([[x - 6, y], [x, y]])
    marked = page.run("isomend.mask().count")
    page.expect(marked > 3, f"{marked} faces are marked")
    said = "document.querySelector('#mask-said').textContent"
    page.expect("Reached" not in page.run(said), "a stroke far from all rims is said to reach one")
    page.click_on("#invert")
    page.expect("Reached" in page.run(said), "marks at all rims are said to reach none: " + page.run(said))
    page.click_on("#unstroke")
    page.fill_in("#mask-name", "spot")
    page.click_on("#mask-keep")
    page.until(f"{ROWS}.length === 1", "the mask has a name")
    # The key is the tool; the pointer shows its circle.
    page.key("z")
    page.expect(page.run("isomend.tool === 'fair' && isomend.tab === 'paint'"), "Z is not the smoothing brush")
    page.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    page.expect(page.run("Number(document.querySelector('#overlay circle').getAttribute('r'))") > 2, "the smoothing brush has no circle")
    page.fill_in("#smoother-edges", "0")
    page.expect(page.run("document.querySelector('#smoother-edges').ariaInvalid") == "true", "a strength of 0 is not refused")
    page.fill_in("#smoother-edges", "3,5")
    page.run(f"isomend.setBrush({0.3 * distance})")
    page.run(HOLD)
    page.drag([[x, y], [x + 8, y], [x + 16, y + 2]])
    page.expect(page.run("isomend.mask().count") == marked, "the smoothing brush changes the mask")
    stroke = page.run(f"isomend.steps.job && {STROKE}")
    page.expect(stroke and stroke > marked, f"while it runs, {stroke} faces are shown as the stroke")
    page.shot("smoothing")
    page.drag([[x - 20, y], [x - 24, y]])
    page.expect(page.run(f"isomend.steps.job && {TROUBLE}.includes('running')"), "a second stroke is not refused: " + page.run(TROUBLE))
    page.run("release()")
    page.until_done()
    page.reaches(1, "the stroke is smoothed: " + page.run(TROUBLE))
    page.expect(page.run(STROKE) == 0 and page.run("isomend.model.meshes.get(0).then((m) => m.facts.some((fact) => fact >>> 28 & 1))") is False, "the stroke stays visible")
    command = page.state()["states"][1]["command"]
    page.expect(command[0] == "fair" and "--strength" in command, f"the command is {command}")
    page.expect(page.run("document.querySelectorAll('#history li').length") == 2, "a stroke is not one line of the history")
    now = page.run("isomend.mask().count")
    page.expect(0.6 * marked <= now <= 1.6 * marked, f"of {marked} marked faces there are {now}")
    page.shot("smoothed")
    page.click_on("#unstroke")
    page.expect(page.run("isomend.mask().count") == 0, "the stroke of the mask before the step is not undone")
    page.click_on("#restroke")
    page.expect(page.run("isomend.mask().count") == now, "the stroke of the mask before the step is not redone")
    # With the smoothing brush, undo is for steps.
    page.key("z", modifiers=2)
    page.reaches(0, "the smoothing is undone")
    page.until(f"isomend.mask().count === {marked}", "the mask is as before the step")
    page.key("y", modifiers=2)
    page.reaches(1, "the smoothing is redone")
    page.expect(page.run("isomend.tool") == "fair", "a step changes the tool")


def check_one_side(page):
    """With *only what faces me*, a stroke or a box over a hole marks nothing of the inner side that is seen through it."""
    page.tab("paint")
    page.expect(page.run("document.querySelector('#facing').checked"), "the tick is not set at first")
    wide = page.run("isomend.holes.list.find((hole) => !hole.outer_boundary).id")
    page.run(f"isomend.holes.choose({wide})")
    page.settled()
    rim = page.run(f"""(() => {{ const {{ viewer }} = isomend, {{ mesh }} = viewer.sides.after, rim = mesh.rims[mesh.rimIds.indexOf({wide})], points = [];
      const b = viewer.canvas.getBoundingClientRect();
      for (let i = 0; i < rim.length; i += 3) {{ const [x, y] = viewer.onPage([rim[i], rim[i + 1], rim[i + 2]], viewer.panes()[0]); points.push([b.x + x, b.y + y]); }}
      return points; }})()""")
    left, right = min(rim), max(rim)
    top, bottom = min(y for _, y in rim), max(y for _, y in rim)
    inner = "(() => { const { topology, mask } = isomend.paint.target(), { eye } = isomend.viewer.camera; let n = 0; for (let f = 0; f < mask.on.length; f++) n += mask.on[f] && topology.front(f, eye) < 0; return n; })()"
    through = [[left[0] - 12 + (right[0] - left[0] + 24) * k / 24, left[1] + (right[1] - left[1]) * k / 24] for k in range(25)]
    for tool, points in (("b", through), ("o", [[left[0] - 12, top - 12], [right[0] + 12, bottom + 12]])):
        page.key(tool)
        page.expect(page.run("document.querySelector('#facing').checkVisibility()"), f"the tick is not shown with the tool {tool}")
        page.drag(points)
        page.expect(page.run("isomend.mask().count") > 0, f"the tool {tool} marks nothing round a hole")
        page.expect(page.run(inner) == 0, f"the tool {tool} marks {page.run(inner)} faces seen from inside")
        page.click_on("#clear")


def check_named(page):
    """A named mask is there after steps, says what is gone, and comes back with undo; it is there in another tab too."""
    whole = page.run(ROWS)
    page.expect(len(whole) == 1 and whole[0].startswith("spot (") and "gone" not in whole[0], f"after smoothing the masks are {whole}")
    page.click_on("#clear")
    page.click_on("#masks button")
    page.until("isomend.mask().count > 0", "a named mask is shown after a step")
    page.job("restore")
    page.run_command()
    page.until_done()
    page.reaches(2, "the mask is restored: " + page.run("document.querySelector('#mend-trouble').textContent"))
    page.tab("paint")
    rows = page.run(ROWS)
    page.expect(len(rows) == 1 and "gone" in rows[0], f"after the faces are replaced the masks are {rows}")
    page.shot("mask_gone")
    page.click_on("#undo")
    page.reaches(1, "the restoration is undone")
    page.expect(page.run(ROWS) == whole, f"undo leaves {page.run(ROWS)}, not {whole}")
    page.click_on("#clear")
    page.click_on("#redo")
    page.reaches(2, "the restoration is redone")
    page.expect(page.run(ROWS) == rows, f"redo leaves {page.run(ROWS)}, not {rows}")
    page.click_on("#masks li:first-child button:last-child")
    page.until(f"{ROWS}.length === 0", "a named mask is dropped")


def check_hidden(page):
    """Each mask that is hidden has a name of its own; shown again and hidden without a change, it gets no other. The region of a step has a
    name that no mask of the user gets."""
    names, marks = "isomend.model.state.masks.map((mask) => mask.name)", "isomend.mask().runs()"
    page.tab("paint")
    before = page.run(names)
    for number, faces in (("1", [10, 11, 12]), ("2", [20, 21])):
        page.run(f"isomend.masks.take({faces})")
        page.key("h")
        page.until(f"isomend.marked() === 0 && {names}.includes('hidden {number}')", f"mask {number} is hidden under a name")
    page.key("h")
    page.until("isomend.marked() === 2", "the mask that was hidden last is shown")
    page.key("h")
    page.until("isomend.marked() === 0", "it is hidden again")
    page.expect(page.run(names) == [*before, "hidden 1", "hidden 2"], f"the masks are {page.run(names)}")
    page.run("(async () => isomend.masks.take(await isomend.masks.facesOf('hidden 1')))()")
    page.expect(page.run(marks) == [[10, 13]], f"the first hidden mask is {page.run(marks)}")
    page.fill_in("#mask-name", "last region")
    page.click_on("#mask-keep")
    page.until(f"{names}.includes('last region 2')", "the name of the region of a step is not taken")
    page.click_on("#clear")


def check_folder(page, folder):
    """A folder is made, and the mesh is saved in it; a name that exists is refused."""
    page.tab("save")
    page.until("document.querySelectorAll('#files option').length > 0", "the files of the folder are listed")
    page.click_on("#folder-new")
    page.expect(page.run("document.activeElement.id") == "folder-name", "the name of a new folder has no focus")
    page.shot("new_folder")
    page.fill_in("#folder-name", "../out")
    page.click_on("#folder-make")
    page.until("document.querySelector('#save-trouble').textContent.includes('not below the folder')", "a folder outside is refused")
    page.fill_in("#folder-name", "parts")
    page.run("document.querySelector('#folder-name').focus()")
    page.key("Enter")
    page.until("document.querySelector('#saved').textContent.includes('parts')", "the folder is made")
    page.expect((folder / "parts").is_dir() and page.run("document.querySelector('#save-path').value") == "parts/scan_mended.ply", "the folder is not used")
    page.fill_in("#save-format", "stl")
    page.expect(page.run("document.querySelector('#save-path').value") == "parts/scan_mended.stl", "another format leaves the folder")
    page.click_on("#save")
    page.until("document.querySelector('#saved').textContent.includes('scan_mended.stl')", "the mesh is saved in the folder")
    page.expect((folder / "parts" / "scan_mended.stl").exists(), "the folder is empty")
    page.click_on("#folder-new")
    page.fill_in("#folder-name", "parts")
    page.click_on("#folder-make")
    page.until("document.querySelector('#save-trouble').textContent.includes('exists already')", "a folder that exists is refused")
    page.shot("folder_exists")
    page.click_on("#folder-new")
    page.expect(page.run("document.querySelector('#folder-row').hidden"), "the name of a new folder stays")


def check_recent(page):
    """Files that were opened are offered, the last one first, and opened by a click."""
    page.click_on("#open-button")
    page.calm()
    page.expect(not page.run("document.querySelector('#recent-files').checkVisibility()"), "recent files are offered before another file was opened")
    page.fill_in("#open-path", "parts/scan_mended.stl")
    page.run("document.querySelector('#open-path').focus()")
    page.key("Enter")
    page.until_open("scan_mended.stl", "the saved mesh is opened")
    page.until("!!isomend.mask()", "the surface is prepared")
    page.click_on("#open-button")
    page.until("document.querySelector('#recent-files').checkVisibility()", "recent files are offered")
    page.expect(page.run("[...document.querySelectorAll('#recent-files span')].map((e) => e.textContent)") == ["scan.ply"], "the recent file is another one")
    page.shot("recent")
    page.click_on("#recent-files button")
    page.until_open("scan.ply", "a recent file is opened")
    page.until("!!isomend.mask()", "the surface is prepared")
    page.expect(page.state()["current"] > 0, "the steps of the first file are gone")


def masks(page, program, folder, mesh):
    """All tests of the smoothing brush, of named masks and of the folder, on a scan."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server, width=1280, height=800)
        page.until("!!isomend.mask()", "the surface is prepared")
        check_smoothing(page)
        check_named(page)
        check_hidden(page)
        check_folder(page, folder)
        check_recent(page)
        check_one_side(page)
        # The tabs that show what this session has: masks, steps, a folder.
        check_layout(page, ["paint", "history", "save"], ())
        page.tell_troubles()
    finally:
        server.stop()
