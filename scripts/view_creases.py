"""Tests of sharp edges on the page of `isomend view`, in Chromium: two crease ends are clicked, the edge is filled. For view_test.py."""

from view_meshes import open_cube
from view_page import Server

# The position of a crease end in the window.
END = """((id) => { const { viewer, labels } = isomend, b = viewer.canvas.getBoundingClientRect(), panes = viewer.panes();
  const at = viewer.onPage(labels.points.find((point) => point.id === id).at, panes[panes.length - 1]);
  return [b.x + at[0], b.y + at[1]]; })"""
TEXT = "isomend.holes.text()"
LINES = "document.querySelectorAll('#labels .crease:not([hidden])').length"


def click_end(page, id):
    page.click(*page.run(f"{END}({id})"))


def check_pair(page, pair, hole):
    """Two clicks make an edge, which is drawn, listed and shown in the command line; a third click removes it."""
    page.run(f"isomend.holes.choose({hole})")
    page.settled()
    page.until("isomend.labels.settled", "the numbers are placed")
    page.expect(page.run("document.querySelectorAll('#labels .end:not([hidden])').length") >= 2, "crease ends are not shown")
    page.shot("ends")
    for again in (False, True, False):
        click_end(page, pair[0])
        if again:
            page.expect("--crease" not in page.run(TEXT), "a click on an end does not remove the edge")
            page.expect(page.run(LINES) == 0, "a removed edge is still drawn")
        else:
            page.expect("--crease" not in page.run(TEXT), "one end makes an edge")
            click_end(page, pair[1])
            shown = page.run(TEXT)
            page.expect(shown.endswith(f"--crease {pair[0]}+{pair[1]}"), f"the edge is shown as {shown}")
            page.expect(page.run(LINES) == 1, "the edge is not drawn")
    page.expect("Sharp edge 1" in page.run("document.querySelector('#creases').textContent") or pair[0] != 1, "the edge is not listed")
    page.shot("crease")


def creases(page, program, folder):
    """An edge of a cube is chosen by clicks, kept over a reload, filled, and recorded in the recipe."""
    mesh = folder / "cube.ply"
    open_cube(mesh)
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        ends = page.state()["crease_ends"]
        page.expect(len(ends) == 5, f"there are {len(ends)} crease ends")
        holes = {end["hole"] for end in ends}
        hole = next(h for h in holes if sum(end["hole"] == h for end in ends) == 2)
        pair = [end["id"] for end in ends if end["hole"] == hole]
        other = next(end["id"] for end in ends if end["hole"] != hole)
        check_pair(page, pair, hole)
        # Ends at different holes make no edge.
        page.run(f"isomend.creases.drop(isomend.creases.pairs[0]); isomend.creases.choose({pair[0]}); isomend.creases.choose({other})")
        page.expect("another hole" in page.run("document.querySelector('#message').textContent"), "ends at two holes are not refused")
        page.run(f"isomend.creases.first = null; isomend.creases.choose({pair[0]}); isomend.creases.choose({pair[1]})")
        page.run("isomend.choices.flush()")
        page.start(server)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.expect(page.run("isomend.creases.pairs") == [pair], "a reload loses the edge")
        page.click_on("#creases button")
        page.expect(page.run("isomend.creases.pairs") == [], "the button does not take the edge away")
        page.run(f"isomend.creases.choose({pair[0]}); isomend.creases.choose({pair[1]})")
        page.click_on("#fill-all")
        page.until_done()
        page.reaches(1, "the holes are filled")
        regions = page.state()["states"][1]["report"]["regions"]
        page.expect(all(region["closed_by"] == "sides" for region in regions), "the edges of the cube are not continued")
        page.expect(page.state()["creases"] == [] and page.run("document.querySelector('#creases-hint').textContent") == "", "ends of closed holes are left")
        page.tab("save")
        page.until("document.querySelector('#recipe').textContent.includes('isomend')", "the recipe is shown")
        page.expect(f"--crease {pair[0]}+{pair[1]}" in page.run("document.querySelector('#recipe').textContent"), "the recipe has no edge")
        page.shot("filled")
        page.tell_troubles()
    finally:
        server.stop()
