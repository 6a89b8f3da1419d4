"""Tests of the page of `isomend view` in Chromium: two tabs on one session, a page that is loaded again, a task with keys only, a mesh that is shown coarse first. For
view_test.py."""

from view_meshes import bumpy_ball
from view_page import Page, Server

# Members of the state of the page that differ from the whole state, as another page would get it.
DIFFERENT = """(async () => { const { model } = isomend, whole = await new model.constructor().fetchState(), own = await model.fetchState();
  return Object.keys(whole).filter((k) => JSON.stringify(whole[k]) !== JSON.stringify(own[k])); })()"""


# What the page says at the foot of the view.
SAID = "document.querySelector('#message').textContent"


def same_state(page, what):
    page.expect(not (different := page.run(DIFFERENT)), f"{what}: the page has another state in {different}")


def two_tabs(page, program, folder, mesh, profile):
    """What one tab does, the other one shows: steps, undo, a preview that is taken; only changes are sent to each."""
    server = Server(program, mesh, folder / "log.txt")
    other = Page(page.process.args[0], profile, None, coarse=page.coarse)
    page.requests.clear()
    try:
        for tab in (page, other):
            tab.start(server, width=1280, height=800)
            tab.until("!!isomend.mask()", "the surface is prepared")
        page.run("isomend.holes.choose(isomend.holes.list[0].id)")
        page.click_on("#fill-chosen")
        page.until_done()
        for tab in (page, other):
            tab.reaches(1, "both tabs show the step")
            same_state(tab, "after a step")
        other.run("isomend.holes.choose(isomend.holes.list[0].id)")
        other.key("k")
        other.click_on("#undo")
        for tab in (page, other):
            tab.reaches(0, "both tabs show that it is undone")
        page.until(f"{SAID}.startsWith('Changed in another tab')", "the other tab says that the mesh was changed here")
        page.expect(other.run(SAID).startswith("Undone"), "the tab that undoes a step takes the change for another tab's")
        page.job("fill")
        page.run("isomend.holes.choose(isomend.holes.list[1].id)")
        page.click_on("#preview")
        page.until("isomend.steps.previews.length === 1", "there is a preview")
        other.until("isomend.model.state.states.some((s) => s.preview)", "the other tab knows of the preview")
        page.click_on("#previews button")
        page.calm()
        taken = page.run("isomend.model.fetchState().then((s) => s.current)")
        for tab in (page, other):
            tab.reaches(taken, "both tabs show the preview that was taken")
            same_state(tab, "after a preview")
            changes = [url for url in tab.requests if "api/state?known=" in url]
            page.expect(len(changes) > 3 and sum(url.endswith("api/state") for url in tab.requests) < 5, "a tab gets whole states")
        other.start(server, width=1280, height=800)
        other.until(f"isomend.model.state.current === {taken}", "a tab that is loaded again shows the session")
        for tab in (page, other):
            page.expect(not tab.troubles, f"console: {tab.troubles}")
            tab.call("Page.navigate", url="about:blank")
    finally:
        other.close()
        server.stop()


def loaded_again(page, program, folder, mesh):
    """A page that is loaded again keeps its fields, tab, theme and the chosen hole; settings hold for later starts of the program. A field with
    a wrong value is marked when it is left."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server, width=1280, height=800)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.click_on("#theme")
        theme = page.run("document.documentElement.dataset.theme")
        page.run("isomend.holes.choose(isomend.holes.list[1].id)")
        chosen = page.run("isomend.holes.chosen")
        page.expect(f"Preview: hole {chosen} only" in page.run("document.querySelector('#mend-on').textContent"), "it is not said what a preview shows")
        page.fill_in("[id='fill--edge-ratio']", "0")
        page.expect(page.run("document.querySelector('#mend-trouble').textContent").startswith("--edge-ratio must be"), "a wrong value is not named when its field is left")
        page.expect(page.run("document.querySelector('[id=\"fill--edge-ratio\"]').getAttribute('aria-invalid')") == "true", "the field of a wrong value is not marked")
        page.fill_in("[id='fill--edge-ratio']", "0.7")
        page.expect(not page.run("document.querySelector('#mend-trouble').textContent"), "a value that was corrected is still called wrong")
        page.fill_in("#unit", "mm")
        page.tab("save")
        page.run("window.isOld = true")
        page.leave("location.reload()")
        page.until("!window.isOld && document.documentElement?.dataset.state === 'ready' && !!isomend.mask()", "the page is loaded again")
        kept = page.run("[document.querySelector('[id=\"fill--edge-ratio\"]').value, isomend.holes.chosen, isomend.tab, isomend.measure.unit, document.documentElement.dataset.theme]")
        page.expect(kept == ["0.7", chosen, "save", "mm", theme], f"a page that is loaded again has {kept}")
        # Another page with the same address, as another tab would open it.
        page.run("(window.heard = [], window.tab = new BroadcastChannel('isomend' + location.pathname), tab.onmessage = ({ data }) => heard.push(data), tab.postMessage('opened'))")
        page.until(f"heard.includes('open') && {SAID}.includes('another tab')", "a page says that it is open in another tab")
        later = Server(program, mesh, folder / "log_later.txt")
        try:
            page.start(later, forget=False, width=1280, height=800)
            page.expect(page.run("document.documentElement.dataset.theme") == theme, "the theme is lost at the next start")
            page.expect(page.run("document.querySelector('[id=\"fill--edge-ratio\"]').value") != "0.7", "another session has the fields of the first one")
            page.tell_troubles()
            page.call("Page.navigate", url="about:blank")
        finally:
            later.stop()
    finally:
        server.stop()


def reach(page, query, backwards=False):
    """Moves the focus with the Tab key until it is on an element."""
    for _ in range(150):
        page.key("Tab", modifiers=8 if backwards else 0)
        if page.run(f"document.activeElement.matches({query!r})"):
            return
    page.expect(False, f"the Tab key does not lead to {query}")


def keys_only(page, program, folder, mesh):
    """Two holes are filled, one step undone, and the mesh saved, without the mouse."""
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server, width=1024, height=700)
        page.until("!!isomend.mask()", "the surface is prepared")
        reach(page, "#view")
        page.key("n")
        page.expect(page.run("isomend.holes.chosen !== null"), "N chooses no hole")
        page.key("i")
        reach(page, "#holes .hole")
        page.key("ArrowDown", modifiers=8)
        page.expect(page.run("new Set([...isomend.holes.picked].map((id) => isomend.holes.group(id)[0])).size") == 2, "Shift and an arrow do not choose two holes")
        reach(page, "#fill-chosen")
        page.key("Enter")
        page.until_done()
        page.reaches(1, "two holes are filled with keys")
        page.key("z", modifiers=2)
        page.reaches(0, "Ctrl+Z undoes the step")
        page.key("y", modifiers=2)
        page.reaches(1, "Ctrl+Y redoes the step")
        reach(page, "[role=tab][aria-selected=true]")
        page.key("ArrowRight")
        page.expect(page.run("isomend.tab") == "paint", "an arrow does not lead to the next job")
        page.key("s", modifiers=2)
        page.expect(page.run("isomend.tab === 'save' && document.activeElement.id") == "save", "Ctrl+S does not lead to saving")
        page.key("Enter")
        page.until("document.querySelector('#saved').textContent || document.querySelector('#save-trouble').textContent", "the mesh is saved")
        page.expect(len([f for f in folder.iterdir() if f.suffix == ".ply"]) == 2, "no mesh is saved: " + page.run("document.querySelector('#save-trouble').textContent"))
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def tabs(page, program, folder, mesh):
    loaded_again(page, program, folder, mesh)
    keys_only(page, program, folder, mesh)
    profile = folder.parent / "second"
    profile.mkdir()
    two_tabs(page, program, folder, mesh, profile)


def huge(page, program, folder):
    """A mesh of two million triangles: first a coarse version, on which holes are chosen; then the mesh itself, in which one is filled."""
    mesh = folder / "huge.ply"
    print(f"  {bumpy_ball(mesh, 720)} triangles")
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.requests.clear()
        page.start(server, width=1024, height=700)
        print(f"  first picture after {page.run('isomend.times.first') / 1000:.1f} s")
        page.run("isomend.open('check'); isomend.aspects.choose('components')")
        page.expect(page.run("isomend.mesh() === null && !document.querySelector('#component-list li')"), "components of a coarse version are listed")
        page.expect(page.settled()["part"] > 0.03, "no coarse version is drawn")
        page.expect(page.run("isomend.holes.list.length === 3 && isomend.viewer.sides.after.mesh.rims.length === 3"), "holes are missing")
        page.run("isomend.holes.choose(1)")
        page.expect(page.run("isomend.holes.chosen") == 1, "no hole can be chosen")
        page.until("!!isomend.mask() && !!isomend.viewer.sides.after.surface.order", "the mesh itself is prepared")
        page.until("document.querySelectorAll('#component-list li').length === 1", "the component is listed when the mesh itself is shown")
        page.tab("holes")
        asked = [url.rsplit("/api/", 1)[-1] for url in page.requests]
        page.expect(asked.index("coarse/0") < asked.index("mesh/0"), f"the coarse version does not come first: {asked}")
        faces, coarse = page.run("(({ mesh, levels }) => [mesh.faces.length / 3, levels.clusters.numbers.length])(isomend.viewer.sides.after.surface)")
        page.expect(faces > 2e6 and 0.2 * faces < coarse < 0.8 * faces, f"{coarse} of {faces} faces are in the coarse version")
        middle = page.run("""(() => { const v = isomend.viewer, m = isomend.mesh(), at = v.onPage(isomend.holes.list[0].centre.map((x, k) => x - m.centre[k]), v.panes()[0]); return at; })()""")
        found = page.run(f"isomend.holes.at(isomend.viewer.pick({middle[0]}, {middle[1]}))")
        page.expect(found == 1, f"in the middle of hole 1 is hole {found}")
        page.run("isomend.holes.choose(1)")
        page.click_on("#fill-chosen")
        page.until_done()
        page.reaches(1, "a hole of the mesh is filled")
        page.expect(page.run("isomend.mesh().facts.length") > faces, "the mesh has no more faces than before")
        region = page.run(f"(() => {{ const hit = isomend.viewer.pick({middle[0]}, {middle[1]}); return hit.region ?? 0; }})()")
        page.expect(region == 1, "the patch is not where the hole was")
        asked = [url.rsplit("/api/", 1)[-1] for url in page.requests]
        page.expect("mesh/1?from=0" in asked and "coarse/1" not in asked, f"after a step more than the changes is sent: {asked[-8:]}")
        page.shot("huge")
        page.tell_troubles()
    finally:
        server.stop()
