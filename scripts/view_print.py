"""Tests of the print check on the page of `isomend view`: wall thickness and overhangs as maps with a limit, components hidden and deleted.
Counts, areas, pixels and written bytes are tested on bodies of known size. For view_test.py."""

import subprocess
import zipfile

import numpy as np

from browser_test import PICTURE
from view_layout import check_layout
from view_meshes import write_ply
from view_page import Server

# A block on the plate, a thin sheet above it, and two small cubes: lowest corner, sides, squares along a side.
BODIES = [((0, 0, 0), (20, 20, 20), 8), ((5, 5, 25), (10, 10, 0.5), 4), ((-3, 0, 1), (0.5, 0.5, 0.5), 1), ((23, 0, 1), (0.5, 0.5, 0.5), 1)]
SKIPPED = "duplicates,orientation,non-manifold,intersections,holes"
# The colour of the pixel where a point of the mesh is drawn.
PIXEL = """((x, y, z) => { const v = isomend.viewer, c = v.sides.after.mesh.centre, at = v.onPage([x - c[0], y - c[1], z - c[2]], v.panes()[0]), gl = v.gl, p = new Uint8Array(4);
  v.draw(); const ratio = v.canvas.width / v.canvas.clientWidth;
  gl.readPixels(at[0] * ratio, v.canvas.height - at[1] * ratio, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, p); return [...p.slice(0, 3)]; })"""


def boxes(path):
    """Writes the bodies as a binary PLY."""
    vertices, faces = [], []
    for low, sides, n in BODIES:
        for k in range(3):
            a, b = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij")
            at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
            quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, :-1], at[1:, 1:], at[:-1, 1:]], -1).reshape(-1, 3)
            for side in 0, 1:
                points = np.empty((n + 1, n + 1, 3))
                points[..., k], points[..., (k + 1) % 3], points[..., (k + 2) % 3] = side, a, b
                faces.append((quads if side else quads[:, ::-1]) + sum(map(len, vertices)))
                vertices.append(points.reshape(-1, 3) * sides + low)
    vertices, number = np.unique(np.concatenate(vertices), axis=0, return_inverse=True)
    write_ply(path, vertices, number.ravel()[np.concatenate(faces)])


def finding(page, query, area, what):
    """The area that a finding tells, as far as it is written."""
    page.calm(PICTURE)
    said = page.run(f"document.querySelector('{query}').textContent")
    page.expect(f", {area}, " in said, f"{what}: {said!r} instead of {area}")


def is_red(colour):
    return colour[0] > 1.6 * max(colour[1:])


def walls(page):
    page.click_on("[name=aspect][value=walls] + span")
    page.until("isomend.viewer.sides.after.surface.colour.kind === 5", "walls are measured")
    page.click_on("[data-view=isometric]")
    thick, thin = f"{PIXEL}(19, 1, 20)", f"{PIXEL}(10, 10, 25.5)"
    page.calm(PICTURE)
    page.expect(not is_red(page.run(thin)), "without a limit something is too thin")
    page.fill_in("#min-wall", "1")
    finding(page, "#walls-said", "203", "walls below 1")
    page.expect(is_red(page.run(thin)) and not is_red(page.run(thick)), "not only the sheet is red")
    page.shot("walls")
    # The slider sets the same limit.
    high = page.run("isomend.aspects.walls.high")
    page.fill_in("#wall-range", str(round(1000 * 0.3 / high)))
    finding(page, "#walls-said", "0", "walls below 0.3")
    page.expect(not is_red(page.run(thin)), "the sheet stays red")
    page.until("document.querySelector('#wall-thinnest button')?.textContent.includes('0.5')", "the thinnest wall is named")
    page.click_on("#wall-thinnest button")
    page.calm(PICTURE)
    page.expect(page.run("isomend.viewer.camera.reach") < 10, "the view is not at the thinnest wall")
    page.fill_in("#min-wall", "")


def overhangs(page):
    page.click_on("[name=aspect][value=overhangs] + span")
    page.until("isomend.viewer.sides.after.surface.colour.kind === 5", "overhangs are shown")
    finding(page, "#overhangs-said", "area 100.5", "overhangs")
    rows = page.run("[...document.querySelectorAll('#stand-list button')].map((b) => [...b.children].map((s) => s.textContent))")
    page.expect(["+Z", "100.5", "400"] in rows and len(rows) == 6, f"the mesh stands as {rows}")
    page.click_on("[data-view=bottom]")
    page.calm(PICTURE)
    page.expect(is_red(page.run(f"{PIXEL}(-2.75, 0.25, 1)")) and not is_red(page.run(f"{PIXEL}(10, 10, 0)")), "what lies on the plate overhangs")
    page.shot("overhangs")
    page.click_on("#stand-list li:nth-child(3) button")
    page.until("isomend.views.up()[1] === 1", "a click on a direction turns the mesh")
    page.fill_in("#up", "")
    page.tab("holes")
    page.until("isomend.display.coloured === 'plain'", "the map goes with the check")


def walls_of_a_sheet(page, program, folder):
    """Faces without an opposite side are grey, also new faces."""
    n, mesh = 12, folder / "sheet.ply"
    a, b = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, :-1], at[1:, 1:], at[:-1, 1:]], -1)
    quads = np.concatenate([quads[:4].reshape(-1, 6), quads[4:8, :4].reshape(-1, 6), quads[4:8, 8:].reshape(-1, 6), quads[8:].reshape(-1, 6)])
    write_ply(mesh, np.stack([a.ravel(), b.ravel(), 0 * a.ravel()], -1), quads.reshape(-1, 3))
    server = Server(program, mesh, folder / "log_sheet.txt")
    try:
        page.start(server, width=1280, height=800)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.click_on("#fill-all")
        page.until_done()
        page.reaches(1, "the hole of a sheet is filled")
        page.click_on("[data-view=top]")
        page.calm(PICTURE)
        patch, sheet = f"{PIXEL}(6.3, 6.1, 0)", f"{PIXEL}(1.3, 1.1, 0)"
        colour = page.run(patch)
        page.expect(colour[0] - colour[2] > 60, f"a patch is {colour}, not orange")
        page.tab("check")
        page.click_on("[name=aspect][value=walls] + span")
        page.until("isomend.viewer.sides.after.surface.colour.kind === 5", "walls are measured")
        page.expect(page.run("isomend.mesh().walls.every((thickness) => thickness !== thickness)"), "a sheet has an opposite side")
        for what, where in (("patch", patch), ("sheet", sheet)):
            colour = page.run(where)
            page.expect(max(colour) - min(colour) < 8 and 60 < colour[0] < 220, f"a {what} without an opposite side is {colour}, not grey")
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def painted_package(path):
    """Writes a cube without one side, each triangle painted, as a 3MF package of a slicer."""
    corners = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for z in (0, 10) for y in (0, 10) for x in (0, 10))
    sides = ((0, 2, 3, 1), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
    faces = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}" paint_color="8"/>' for p, q, r, s in sides for a, b, c in ((p, q, r), (p, r, s)))
    core = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    model = (f'<model unit="millimeter" xmlns="{core}"><resources><object id="1" type="model"><mesh><vertices>{corners}</vertices>'
             f'<triangles>{faces}</triangles></mesh></object></resources><build><item objectid="1"/></build></model>')
    relations = ('<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" '
                 'Id="rel-1" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>')
    types = ('<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType='
             '"application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>')
    with zipfile.ZipFile(path, "w") as package:
        for name, text in (("[Content_Types].xml", types), ("_rels/.rels", relations), ("3D/3dmodel.model", model)):
            package.writestr(name, text)


def paint_of_patches(page, program, folder):
    """Where a file has paint of a slicer, it is offered for patches, and the page writes what the command writes."""
    mesh, shown = folder / "painted.3mf", "!document.querySelector('#patch-paint-label').hidden"
    painted_package(mesh)
    server = Server(program, mesh, folder / "log_painted.txt")
    try:
        page.start(server, width=1280, height=800)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.click_on("#fill-all")
        page.until_done()
        page.reaches(1, "the open side is filled")
        page.tab("save")
        page.fill_in("#save-format", "stl")
        page.expect(not page.run(shown), "paint is offered for a format without it")
        page.fill_in("#save-format", "3mf")
        page.expect(page.run(shown), "the paint of patches is not offered")
        for paint, options in (("", []), ("continue", ["--paint", "continue"])):
            page.fill_in("#patch-paint", paint)
            page.fill_in("#save-path", f"made{paint}.3mf")
            page.click_on("#save")
            page.until(f"document.querySelector('#saved').textContent.includes('made{paint}.3mf')", "the package is saved")
            wanted = folder / f"wanted{paint}.3mf"
            subprocess.run([program, "fill", mesh, "-o", wanted, "-q", *options], check=True)
            page.expect((folder / f"made{paint}.3mf").read_bytes() == wanted.read_bytes(), f"with paint {paint!r} the page writes another package than the command")
        counts = [zipfile.ZipFile(folder / f"made{paint}.3mf").read("3D/3dmodel.model").count(b"paint_color") for paint in ("", "continue")]
        page.expect(counts[0] == 10 < counts[1], f"without and with paint on patches {counts} triangles are painted")
        page.until("document.querySelector('#recipe').textContent.includes('--paint continue')", "the recipe has the paint")
        page.fill_in("#language", "de")
        page.until("document.documentElement?.dataset.state === 'ready' && document.documentElement.lang === 'de' && !!isomend.mask()", "the page is German")
        page.tab("save")
        page.expect(page.run(f"{shown} && document.querySelector('#patch-paint-label').innerText.includes('Flicken bemalen')"), "in German the paint is not offered")
        page.expect(page.run("document.querySelector('#patch-paint').value") == "continue", "the change of the language loses the paint of patches")
        check_layout(page, ["save"], [False])
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()


def expect_same(page, folder, name, command):
    """The page saves the bytes that a command writes."""
    saved, wanted = folder / name, folder / f"wanted_{name}"
    page.run(f"fetch('api/save', {{ method: 'POST', headers: {{ 'content-type': 'application/json' }}, body: JSON.stringify({{ kind: 'mesh', path: '{name}', overwrite: false }}) }})")
    subprocess.run([*command, "-o", wanted, "-q"], check=True)
    page.expect(saved.exists() and saved.read_bytes() == wanted.read_bytes(), "the page writes another mesh than the command")


def components(page, program, folder, mesh):
    page.tab("check")
    page.click_on("[name=aspect][value=components] + span")
    page.until("document.querySelectorAll('#component-list li').length === 4", "the components are listed")
    marked = "isomend.mesh().facts.reduce((sum, fact) => sum + (fact >>> 19 & 1), 0)"
    page.expect(page.run(marked) == 24, "the small cubes are not marked")
    page.run("isomend.viewer.fly(isomend.home())")
    drawn = page.settled()["part"]
    page.click_on("#component-list li:first-child .icon-button")
    page.expect(page.settled()["part"] < 0.5 * drawn, "a hidden component is drawn")
    page.expect(page.run("isomend.aspects.components.found.hidden.size") == 1, "no component is hidden")
    page.shot("components")
    page.click_on("#show-all")
    page.expect(abs(page.settled()["part"] - drawn) < 1e-3, "a component stays hidden")
    page.fill_in("#debris-range", "1")
    page.expect("3 components" in page.run("document.querySelector('#debris-delete').textContent"), "the slider does not choose the sheet")
    page.fill_in("#debris-part", "1")
    page.expect(page.run("document.querySelector('#debris-command').textContent") == f"isomend repair --debris 0.01 --skip {SKIPPED}", "the command is not shown")
    page.click_on("#debris-delete")
    page.until_done()
    page.reaches(1, "the small cubes are deleted")
    page.until("document.querySelectorAll('#component-list li').length === 2", "the rest is listed")
    page.until("document.querySelector('#result-line').textContent.startsWith('Removed: 2 components.')", "the card says what was removed")
    expect_same(page, folder, "without.ply", [program, "repair", mesh, "--debris", "0.01", "--skip", SKIPPED])
    page.click_on("#undo")
    page.reaches(0, "the deletion is undone")
    page.until("document.querySelectorAll('#component-list li').length === 4", "the small cubes are back")


def components_beside_previews(page):
    """No component is listed while previews are shown, and rows of an earlier mesh do nothing; afterwards the components of the current mesh are listed."""
    listed = "document.querySelectorAll('#component-list li').length"
    page.click_on("#redo")
    page.reaches(1, "the deletion is redone")
    page.until(f"{listed} === 2", "what the deletion left is listed")
    page.run("window.old = document.querySelector('#component-list li')")
    page.run(f"isomend.steps.request('', {{ kind: 'repair', params: {{ debris: 0.5, skip: {SKIPPED.split(',')} }}, mask: null, no_texture: false, preview: true }})")
    page.until("isomend.steps.previews.length === 1 && !isomend.steps.job", "there is a preview")
    page.until(f"{listed} === 0", "no component is listed beside a preview")
    hidden = "['#debris', '#show-all'].every((query) => document.querySelector(query).hidden)"
    page.expect(page.run(hidden), "components can be deleted while a preview is shown")
    page.expect("previews" in page.run("document.querySelector('#components-said').textContent"), "why no component is listed is not said")
    page.run("old.querySelectorAll('button').forEach((button) => button.click()); document.querySelector('#show-all').click()")
    page.click_on("#undo")
    page.until("isomend.model.state.current === 0", "the deletion is undone beside a preview")
    page.calm()
    page.expect(page.run(f"{listed} === 0 && {hidden}"), "rows of the mesh before the undo are listed")
    page.click_on("#previews > div:first-child button:nth-of-type(2)")
    page.until(f"!isomend.steps.previews.length && {listed} === 4", "all components are listed after the preview is dropped")
    page.expect(page.run("document.querySelector('#debris-delete').textContent") == "Delete 2 components", "the button has an old count")


def delete_chosen(page, program, folder, mesh):
    """The component that is clicked in the list is deleted alone, as `isomend repair --drop` does."""
    page.click_on("#component-list li:nth-child(3) button")
    number = page.run("isomend.aspects.components.picked") + 1
    command = f"isomend repair --drop {number} --skip {SKIPPED}"
    page.expect(page.run("document.querySelector('#debris-command').textContent") == command, "the command of a chosen component is not shown")
    page.expect(page.run("document.querySelector('#debris-delete').textContent") == f"Delete component {number}", "the button names no component")
    page.click_on("#debris-delete")
    page.until_done()
    page.until("document.querySelectorAll('#component-list li').length === 3", "the others are listed")
    expect_same(page, folder, "three.ply", [program, "repair", mesh, "--drop", str(number), "--skip", SKIPPED])
    page.click_on("#undo")
    page.reaches(0, "the deletion of the chosen component is undone")
    page.until("document.querySelectorAll('#component-list li').length === 4", "the chosen component is back")


def printing(page, program, folder):
    mesh = folder / "bodies.ply"
    boxes(mesh)
    server = Server(program, mesh, folder / "log.txt")
    try:
        page.start(server, width=1280, height=800)
        page.until("!!isomend.mask()", "the surface is prepared")
        page.tab("check")
        walls(page)
        overhangs(page)
        components(page, program, folder, mesh)
        components_beside_previews(page)
        delete_chosen(page, program, folder, mesh)
        page.tell_troubles()
        page.call("Page.navigate", url="about:blank")
    finally:
        server.stop()
    walls_of_a_sheet(page, program, folder)
    paint_of_patches(page, program, folder)
