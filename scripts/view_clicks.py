"""Ten tasks on the page of `isomend view` as a new user does them, in Chromium, with the clicks that each takes. A stroke over the surface
and a choice in a list count as a click. For view_test.py."""

import shutil
import subprocess

from browser_test import ROOT
from view_page import HOLE, Server
from view_tasks import DENT, begin


class Counted:
    """Counts the clicks of one task, and compares them with the upper bound; docs/view.md states most of them."""

    def __init__(self, page, name, most):
        self.page, self.name, self.most, self.count = page, name, most, 0

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind:
            return
        print(f"  {self.name}: {self.count} clicks (at most {self.most})", flush=True)
        self.page.expect(self.count <= self.most, f"{self.name} takes {self.count} clicks, more than {self.most}")

    def on(self, query):
        self.count += 1
        self.page.click_on(query)

    def at(self, x, y):
        self.count += 1
        self.page.calm()
        self.page.click(x, y)

    def hole(self, number):
        # A moving view would take the hole away from the point.
        self.page.calm()
        self.at(*self.page.run(f"{HOLE}({number})"))
        self.page.until(f"isomend.card.id === {number} || isomend.holes.doings.get({number}).startsWith('bridge')", f"a click in hole {number} shows its card")

    def choose(self, query, value):
        self.count += 1
        self.page.fill_in(query, value)


def back(page):
    """Undoes all steps."""
    while page.state()["undo"]:
        page.click_on("#undo")
        page.until("!isomend.steps.job", "a step is undone")
        page.calm()
    page.tab("holes")
    page.fill_in("#set-all", "fill")
    page.run("isomend.viewer.fly(isomend.home())")
    page.settled()


def filling(page, folder):
    """Fill all; all but one and save as STL; a flat cap; two holes as one."""
    with Counted(page, "fill all holes", 1) as task:
        task.on("#fill-all")
        page.until_done()
        page.reaches(1, "all holes are filled")
        page.expect(page.run("document.querySelector('#result').dataset.level") == "good", "the card does not say that all is well")
        page.expect(page.run("document.querySelectorAll('#summary li .swatch').length") > 5, "no hole has an expected error in a colour")
    with Counted(page, "see where the patches may err", 2) as task:
        task.on("#fly-surface > summary")
        task.choose("#colour", "sigma")
        page.until("isomend.display.coloured === 'sigma'", "expected errors are shown")
        page.run("document.querySelector('#fly-surface').open = false")
    page.fill_in("#colour", "plain")
    back(page)
    first = page.run("isomend.holes.list[0].id")
    with Counted(page, "fill all but one hole, save as STL", 6) as task:
        task.hole(first)
        task.on("#hole-card [value=open]")
        task.on("#fill-all")
        page.until_done()
        page.until("isomend.model.state.current > 1", "the holes are filled")
        left = page.run("isomend.holes.list.map((hole) => hole.diameter)")
        page.expect(0 < len(left) <= 2, f"{len(left)} holes are left, not the one that is to stay open")
        task.on("#tab-save")
        task.choose("#save-format", "stl")
        task.on("#save")
        page.until("document.querySelector('#saved').textContent.includes('.stl')", "the mesh is saved")
        page.expect((folder / "scan_mended.stl").stat().st_size > 100_000, "the file is empty")
    back(page)
    with Counted(page, "close one hole flat", 3) as task:
        task.hole(first)
        task.on("#hole-card [value=flat]")
        task.on("#hole-card .first")
        page.until_done()
        page.until("isomend.model.current.command.includes('--flat')", "the hole is closed flat")
    back(page)
    page.run("isomend.holes.choose(isomend.holes.list[0].id)")
    page.settled()
    near = page.run("isomend.labels.items.filter((item) => item.seen.after && !isomend.holes.group(isomend.holes.list[0].id).includes(item.hole.id)).map((item) => item.hole.id)")
    # The label of a hole on the far side is seen through another hole, but its rim cannot be clicked.
    near = [hole for hole in near if page.run(f"{HOLE}({hole})") != [0, 0]]
    with Counted(page, "fill two holes as one", 5) as task:
        task.hole(first)
        task.on("#hole-card button:last-child")
        task.hole(near[0])
        page.expect("--bridge" in page.run("isomend.holes.text()"), "the holes are not joined: " + page.run("isomend.holes.text()"))
        task.hole(first)
        page.until(f"isomend.card.id === {first}", "the card of a joined hole is shown")
        # Holes that are joined with one of the two without being asked are filled with them.
        wanted = set(page.run(f"isomend.holes.list.filter((hole) => [{first}, {near[0]}].includes(hole.id)).flatMap((hole) => [hole.id, ...hole.joined])"))
        task.on("#hole-card .first")
        page.until_done()
        page.until("isomend.model.state.current > 0", "the holes are filled")
    filled = page.run("isomend.model.current.report.holes.filter((hole) => hole.outcome === 'closed').map((hole) => [hole.id, hole.region])")
    page.expect({hole for hole, _ in filled} == wanted, f"holes {wanted} are joined, but these holes and regions are filled: {filled}")
    page.expect(len({region for _, region in filled}) == 1, f"joined holes are filled in several regions: {filled}")
    left = "document.querySelector('#result-line').textContent.includes('left open')"
    page.expect(page.run(f"document.querySelector('#result').dataset.level === 'fair' && {left}"), "holes left open as asked are not yellow")
    page.key("Escape")
    back(page)
    bridges(page)


def bridges(page):
    """Joining takes the bridge of either hole, merges two bridges, and takes no name that is taken."""
    page.fill_in("#set-all", "fill")
    a, b, c, d, e, f = page.run("isomend.holes.list.filter((hole) => !hole.joined.length).slice(0, 6).map((hole) => hole.id)")
    join = "((a, b) => { isomend.card.joins = a; isomend.card.join(b); return [...isomend.holes.bridges()].map(([name, ids]) => [name, ids.sort((x, y) => x - y)]); })"
    page.run(f"{join}({a}, {b})")
    found = page.run(f"{join}({c}, {d})")
    page.expect(len(found) == 2 and all(len(ids) == 2 for _, ids in found), f"two pairs are joined as {found}")
    found = page.run(f"{join}({e}, {a})")
    page.expect(["bridge 1", sorted([a, b, e])] in found, f"a third hole is joined as {found}")
    found = page.run(f"{join}({c}, {a})")
    page.expect(found == [["bridge 2", sorted([a, b, c, d, e])]], f"two bridges are merged as {found}")
    page.run(f"isomend.holes.set({f}, 'fill')")
    shown = page.run("[...document.querySelectorAll('#holes li')].filter((row) => row.dataset.doing === 'bridge').map((row) => row.querySelector('select').value)")
    page.expect(shown == ["bridge 2"] * 5, f"the rows of a bridge show {shown}")
    page.fill_in("#set-all", "fill")


def checking(page):
    """Printable or not and where; make it printable; the same verdict in both places; a minimum wall."""
    with Counted(page, "printable or not, and where", 2) as task:
        task.on("#tab-check")
        page.until("document.querySelector('#verdict').textContent.startsWith('Not printable')", "the mesh is judged")
        before = page.settled()["hash"]
        task.on("#defect-list button")
        page.expect(page.settled()["hash"] != before, "the place of the defect is not shown")
    with Counted(page, "make it printable", 2) as task:
        task.on("#tab-print")
        shown = page.run("document.querySelector('#mend-text').textContent")
        page.expect("--close-borders" in shown and "--drop-inside" in shown, f"Make printable begins with {shown}")
        task.on("#run")
        page.until_done()
        page.until("document.querySelector('#result-line').textContent.includes('Printable')", "it is printable")
        line = page.run("document.querySelector('#result-line').textContent")
    page.tab("check")
    page.until("document.querySelector('#verdict').textContent.startsWith('Printable')", "the check agrees")
    page.expect(line.endswith(page.run("document.querySelector('#verdict').textContent")), f"the card says {line!r}")
    page.fill_in("#min-wall", "1000")
    page.until("document.querySelector('#verdict').textContent.startsWith('Not printable')", "a minimum wall counts in the check")
    page.until("document.querySelector('#result-line').textContent.includes('Not printable')", "a minimum wall counts in the card")
    page.expect("--min-wall 1000" in page.run("isomend.open('print') || document.querySelector('#mend-text').textContent"), "a minimum wall does not count in the repair")
    # A preset and the defaults keep the minimum wall of the check, which was set before.
    for query in ("#presets [value=sound]", "#presets [value=print]", "#defaults"):
        page.click_on(query)
        page.expect("--min-wall 1000" in page.run("document.querySelector('#mend-text').textContent"), f"{query} loses the minimum wall")
    page.fill_in("#min-wall", "")
    back(page)


def measuring(page):
    with Counted(page, "measure a wall", 2) as task:
        task.on("[name=tool][value=thickness] + span")
        task.at(*page.surface()[0])
        page.until("document.querySelectorAll('#measures li').length === 1", "the thickness is measured")
    with Counted(page, "open another file", 2) as task:
        task.on("#open-button")
        page.until("document.querySelectorAll('#folder-files button').length > 1", "the files of the folder are listed")
        task.count += 1
        page.click_on("#folder-files li:nth-child(1) button")
        page.until_open("painted.ply", "the other file is opened")


def restoring(page, folder):
    """A dent is restored, compared, and saved with the missing piece."""
    page.until("!!isomend.mask()", "the surface is prepared")
    faces = page.run(DENT)
    with Counted(page, "restore, compare, save the piece", 7) as task:
        task.on("#tab-paint")
        page.expect(page.run("isomend.tool") == "brush", "restoring does not begin with the brush")
        # A stroke over the dent: the faces are given, since its place in the window is not known.
        task.count += 1
        page.run(f"isomend.masks.take({faces})")
        task.on("#run")
        page.until_done()
        page.reaches(1, "the dent is restored")
        page.expect(page.run("isomend.marked()") == 0, "the mask covers the patch")
        task.on("[name=show][value=slider] + span")
        task.on("#tab-save")
        task.on("#piece-file")
        task.on("#save")
        page.until("document.querySelector('#saved').textContent.includes('piece')", "the piece is saved")
        page.expect((folder / "painted_mended_piece.stl").exists(), "there is no piece")


def start_page(page, program, folder):
    """The page of a folder lists its meshes; one is opened by a click, and a damaged file is named and not left behind."""
    server = Server(program, folder, folder.parent / "log_folder.txt")
    try:
        page.open(server.address)
        names = page.run("[...document.querySelectorAll('#folder-files span')].map((e) => e.textContent)")
        page.expect({"painted.ply", "scan.ply"} <= set(names), f"the list is {names}")
        page.shot("start")
        page.run("isomend.send([new File(['no mesh'], 'bad.ply'), new File(['text'], 'notes.doc')])")
        said = page.run("document.querySelector('#open-trouble').textContent")
        page.expect("bad.ply:" in said and "notes.doc:" in said and "(name)" not in said, f"two refused files are named as {said!r}")
        page.expect(not (folder / "bad.ply").exists(), "a damaged file is left behind")
        page.run("""(() => { const tetrahedron = "solid a\\n" + ["0 0 0,0 1 0,1 0 0", "0 0 0,1 0 0,0 0 1", "0 0 0,0 0 1,0 1 0", "1 0 0,0 1 0,0 0 1"].map((face) =>
              "facet normal 0 0 0\\nouter loop\\n" + face.split(",").map((point) => `vertex ${point}\\n`).join("") + "endloop\\nendfacet\\n").join("") + "endsolid a\\n";
            return isomend.send([new File([tetrahedron], "one.stl"), new File([tetrahedron], "two.stl")]); })()""")
        page.until("document.querySelector('#open-said').textContent.includes('one.stl, two.stl')", "files that are taken are named")
        page.expect(page.run("document.querySelector('#open-trouble').textContent") == "", "files that are taken are shown as an error")
        page.fill_in("#open-path", "SCAN.p")
        page.run("document.querySelector('#open-path').focus()")
        page.key("Enter")
        page.until_open("scan.ply", "a mesh of the folder is opened")
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def clicks(page, program, folder):
    """All tasks."""
    for name in ("scan.ply", "painted.ply"):
        shutil.copy(ROOT / "data" / name, folder)
    server = Server(program, folder / "scan.ply", folder.parent / "log.txt")
    try:
        begin(page, server)
        filling(page, folder)
        checking(page)
        measuring(page)
        restoring(page, folder)
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    start_page(page, program, folder)
    refused = subprocess.run([program, "view", folder, "--resume", "--no-browser"], capture_output=True, text=True, timeout=60)
    page.expect(refused.returncode != 0 and "name the mesh" in refused.stderr, f"a folder is resumed: {refused.stderr}")
