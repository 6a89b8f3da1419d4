"""Tests of choices on the page of `isomend view`, in Chromium: rows show what is sent, masks and choices are kept. For view_test.py."""

import re
import shutil
import subprocess

from view_page import Server

# For each row of the list of holes: whether the row says that the hole stays open, and whether the parameters sent say so.
ROWS = """(() => { const { holes } = isomend, sent = holes.params(), rows = [...document.querySelectorAll("#holes li")];
  return rows.map((row) => { const id = Number(row.dataset.hole), open = row.querySelector("select").value === "open";
    return [id, open, sent.holes ? !sent.holes.includes(id) : sent.keep_open.includes(id) || holes.list.find((h) => h.id === id).stays_open]; }); })()"""
DOINGS = "JSON.stringify([...isomend.holes.doings])"


def check_point(page):
    """A click shows the point and copies nothing; with Alt it copies the ball."""
    x, y = page.surface()[0]
    page.run("isomend.point.copied = null")
    page.click(x, y)
    page.until("document.querySelector('#point-at').textContent.includes(',')", "the point is shown")
    page.expect(page.run("isomend.point.copied") is None, "a click without Alt copies the point")
    page.click(x, y, modifiers=1)
    page.until("!!isomend.point.copied", "the ball is copied")
    ball = page.run("isomend.point.copied")
    page.expect(re.fullmatch(r"--ball (-?[\d.e-]+,){3}[\d.e-]+", ball), f"the ball is {ball!r}")


def check_rows(page):
    """Each row shows what is sent for its hole."""
    holes = page.state()["holes"]
    for first in ("fill", "flat", "open"):
        page.fill_in("#holes li select", first)
        wrong = [row for row in page.run(ROWS) if row[1] != row[2]]
        page.expect(not wrong, f"with hole 1 to {first} these rows differ from what is sent: {wrong}")
    page.expect(any(hole["outer_boundary"] for hole in holes), "the mesh of this check has no border")
    heights = page.run("document.querySelector('#holes').textContent")
    page.expect(not re.search(r"e-1\d", heights), "rounding is shown as a height")


def check_kept(page, server):
    """Choices are kept when the page is loaded again."""
    page.fill_in("#holes li select", "flat")
    page.fill_in("#holes li:nth-child(3) select", "open")
    before = page.run(DOINGS)
    page.run("isomend.choices.flush()")
    page.start(server)
    page.until("!!isomend.mask()", "the surface is prepared")
    page.expect(page.run(DOINGS) == before, "a reload loses what was chosen")


def check_step(page):
    """A step moves nothing on the page, and keeps the choices for other holes; undo restores the choices."""
    third = page.run("isomend.holes.list[2].diameter")
    page.run("scrollTo(0, 0)")
    before, box = page.run(DOINGS), page.view()
    hole = page.run("isomend.holes.list[4].id")
    page.run(f"isomend.holes.choose({hole}, false)")
    page.click_on("#fill-chosen")
    page.until_done()
    page.reaches(1, "the hole is filled")
    page.run("scrollTo(0, 0)")
    page.expect(page.view() == box, f"the first step moves the view from {box} to {page.view()}")
    kept = page.run(f"isomend.holes.doings.get(isomend.holes.list.find((h) => h.diameter === {third}).id)")
    page.expect(kept == "open", f"after a step the hole that was to stay open is to {kept}")
    page.expect("not saved" in page.run("document.querySelector('#subtitle').textContent"), "it is not said that the step is not saved")
    page.shot("step")
    page.fill_in("#colour", "sigma")
    page.until("isomend.viewer.sides.after.surface.colour.kind === 2", "expected errors are shown")
    words = page.run("document.querySelector('#scale').innerText")
    page.expect("expected error, in the mesh's units" in words and "-1" not in words, f"the scale of expected errors says {words!r}")
    page.settled()
    page.shot("expected_error")
    page.fill_in("#colour", "plain")
    page.click_on("#undo")
    page.reaches(0, "the step is undone")
    page.expect(page.run(DOINGS) == before, "undo loses what was chosen")


def check_mask(page):
    """A mask is kept for a second preview and after a step; a run without a mask asks for one."""
    page.tab("paint")
    page.run("isomend.setBrush(isomend.viewer.camera.radius / 12)")
    page.click_on("[name=tool][value=brush] + span")
    x, y = page.surface()[0]
    page.drag([[x, y], [x + 4, y + 4]])
    marked = page.run("isomend.marked()")
    page.expect(marked > 0, "the brush marks nothing")
    axes = page.run("JSON.stringify(isomend.viewer.camera.axes)")
    for kind, button in (("mousePressed", "right"), ("mouseMoved", "right"), ("mouseReleased", "right")):
        page.call("Input.dispatchMouseEvent", type=kind, x=x + (0 if kind == "mousePressed" else 40), y=y, button=button, buttons=2, clickCount=1)
    page.expect(page.run("JSON.stringify(isomend.viewer.camera.axes)") != axes, "the right button does not turn while painting")
    page.job("restore")
    for number in (1, 2):
        page.click_on("#preview")
        page.until(f"!isomend.steps.job && isomend.steps.previews.length === {number}", f"preview {number} is made")
        page.expect(page.run("document.querySelector('#mend-trouble').textContent") == "", "a preview is refused")
    page.expect(page.run("isomend.marked()") == marked, "previews lose the mask")
    page.shot("mask_previews")
    page.run("[...document.querySelectorAll('#previews button')].find((b) => b.textContent === 'Take').click()")
    page.until("isomend.model.state.current > 0 && !isomend.steps.previews.length && !!isomend.mask()", "a preview is taken")
    # The mask of the step is the last region, hidden: a stroke begins a new mask, and H shows the region.
    masked = "isomend.viewer.sides.after.mesh.facts.filter((fact) => fact >>> 18 & 1).length"
    old = "isomend.viewer.sides.before.mesh.facts.some((fact) => fact >>> 18 & 1)"
    page.expect(page.run("isomend.marked()") == 0 and page.run(masked) == 0 and not page.run(old), "the mask covers the patch, or the mesh before it")
    page.key("h")
    page.until("isomend.marked() > 0", "H shows the last region")
    region = page.run("isomend.marked()")
    page.shot("mask_region")
    page.key("h")
    page.until("isomend.marked() === 0", "H hides the region")
    page.calm()
    page.expect(page.run(masked) == 0, "a hidden mask is drawn")
    page.run("isomend.setBrush(isomend.viewer.camera.radius / 40)")
    page.drag([[x, y], [x + 2, y]])
    page.expect(0 < page.run("isomend.marked()") < region, "a stroke after a step adds to the region of the step")
    page.click_on("#clear")
    page.job("fair")
    page.fill_in("[id='fair--strength']", "2,5")
    shown = page.run("document.querySelector('#mend-text').textContent")
    page.expect("--strength 2.5" in shown, f"a decimal comma is shown as {shown}")
    page.run_command()
    page.until("!document.querySelector('#ask').hidden", "a run without a mask asks")
    page.shot("ask")
    page.click_on("#ask-no")
    page.expect(page.run("isomend.steps.job === null"), "a run begins although it was not wanted")


def check_joined(page, number):
    """Joined rims are one row, chosen, filled and kept open together."""
    group, rows = page.run(f"isomend.holes.group({number})"), page.run("[...document.querySelectorAll('#holes li')].map((row) => Number(row.dataset.hole))")
    page.expect(len(group) > 1 and [hole for hole in rows if hole in group] == [min(group)], f"the joined rims {group} are the rows {rows}")
    page.run(f"isomend.holes.choose({number}, false)")
    page.expect(page.run("isomend.holes.only()") == group, f"of the joined rims {group} these are chosen: {page.run('isomend.holes.only()')}")
    page.expect(" + ".join(map(str, group)) in page.run("document.querySelector('#fill-chosen').textContent"), "the button names other holes than it fills")
    page.run(f"isomend.holes.set({number}, 'open')")
    page.expect(f"--keep-open {','.join(map(str, group))}" in page.run("isomend.holes.text()"), "joined rims are not kept open together: " + page.run("isomend.holes.text()"))
    page.run(f"isomend.holes.set({number}, 'fill')")
    page.run("isomend.holes.choose(null)")


def check_card(page):
    """The card of a step can be closed and opened again, and its rows lead to the holes."""
    page.click_on("#result-close")
    page.expect(page.run("document.querySelector('#result').hidden"), "the card is not closed")
    page.click_on("#result-open")
    page.expect(page.run("!document.querySelector('#result').hidden && document.querySelector('#result-open').hidden"), "a closed card is not opened again")
    before = page.run("[...isomend.viewer.camera.centre]")
    page.click_on("#outcome summary")
    page.click_on("#summary .link")
    page.settled()
    page.expect(page.run("[...isomend.viewer.camera.centre]") != before, "a row of the card does not lead to its hole")
    page.click_on("#outcome summary")


def check_defaults(page, program, folder, mesh):
    """Filling with all defaults writes the bytes of `isomend fill`, which joins outer borders with the rims that they face."""
    mesh = shutil.copy(mesh, folder / "defaults.ply")
    by_program, by_page = folder / "by_program.ply", folder / "by_page.ply"
    done = subprocess.run([program, "fill", mesh, "-o", by_program], capture_output=True, text=True)
    server = Server(program, mesh, folder / "log_defaults.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        joined = [hole["id"] for hole in page.state()["holes"] if hole["outer_boundary"] and hole["joined"]]
        page.expect(joined, "no outer border of this mesh faces another rim")
        for number in joined:
            first = page.run(f"isomend.holes.group({number})[0]")
            row = page.run(f"document.querySelector('#holes li[data-hole=\"{first}\"]').textContent")
            page.expect("+" in row or "×" in row, f"the row of border {number} names no rim that it is joined with: {row!r}")
        check_joined(page, joined[0])
        page.expect(page.run("isomend.holes.text()") == "--holes all", "the page proposes " + page.run("isomend.holes.text()"))
        page.click_on("#fill-all")
        page.until_done()
        page.reaches(1, "all holes are filled")
        check_card(page)
        page.tab("save")
        page.fill_in("#save-path", by_page.name)
        page.click_on("#save")
        page.until("document.querySelector('#saved').textContent || document.querySelector('#save-trouble').textContent", "the mesh is saved")
        page.expect(done.returncode == 0 and by_page.read_bytes() == by_program.read_bytes(), "the page's fill with its defaults differs from the program's")
        page.tell_troubles()
    finally:
        server.stop()


def choices(page, program, folder, mesh):
    """All tests of choices, on a mesh with outer borders."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        check_rows(page)
        check_kept(page, server)
        check_step(page)
        check_mask(page)
        page.tell_troubles()
        # Leave the page before its server stops, of which it would report an error.
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    check_defaults(page, program, folder, mesh)
