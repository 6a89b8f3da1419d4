"""The panel and the menus: each tab draws its own controls, and the buttons run with the settings of the panel."""

from types import SimpleNamespace

import numpy as np
import pytest
import shapes

# The controls of each tab that no other tab has.
OWN = {
    "FILL": {"isomend.fill", "isomend.find_holes", "scope", "max_diameter", "flat"},
    "RESTORE": {"isomend.restore", "isomend.fair", "keep_shape", "strength"},
    "REPAIR": {"isomend.repair", "close_borders", "keep_holes", "weld", "debris"},
    "CHECK": {"isomend.check", "min_wall"},
}
COMMON = {"energy", "sharp", "voxel", "mirror"}


class Button:
    """Properties of an operator, as a layout returns them: only those that the operator has, with values that they take."""

    def __init__(self, bpy, name):
        group, own = name.split(".")
        kind = getattr(getattr(bpy.ops, group), own).get_rna_type()
        object.__setattr__(self, "name", name)
        object.__setattr__(self, "known", kind.properties)
        object.__setattr__(self, "values", {})

    def __setattr__(self, name, value):
        rule = self.known[name]
        assert rule.type != "ENUM" or value in rule.enum_items, (name, value)
        self.values[name] = value

    def run(self, bpy):
        group, own = self.name.split(".")
        return getattr(getattr(bpy.ops, group), own)(**self.values)


class Layout:
    """A layout that records what is drawn into it. Blender draws only in a window; its own declarations of the functions of a layout, of
    properties and of operators say here whether it could."""

    def __init__(self, bpy):
        self.bpy, self.drawn, self.buttons = bpy, [], {}

    def _takes(self, function, *names):
        known = self.bpy.types.UILayout.bl_rna.functions[function].parameters.keys()
        assert set(names) <= set(known), (function, names)

    def box(self):
        self._takes("box")
        return self

    def row(self):
        self._takes("row")
        return self

    def separator(self):
        self._takes("separator")

    def label(self, **options):
        self._takes("label", *options)
        self.drawn.append(options["text"])

    def prop(self, data, name, **options):
        self._takes("prop", *options)
        assert name in data.bl_rna.properties
        self.drawn.append(name)

    def progress(self, **options):
        self._takes("progress", *options)
        self.drawn.append(("progress", round(options["factor"], 3), options["text"]))

    def template_list(self, kind, *names, **options):
        self._takes("template_list", *options)
        self.drawn.append(kind)

    def operator(self, name, **options):
        self._takes("operator", *options)
        self.drawn.append(name)
        button = self.buttons[name] = Button(self.bpy, name)
        return button


@pytest.fixture
def drawn(bpy, scene, extension):
    """Draws the panel with these settings, and returns its layout."""
    before = {name: getattr(scene.isomend, name) for name in ("tab", "scope", "bridge", "mirror", "max_diameter")}

    def draw(**settings):
        for name, value in settings.items():
            setattr(scene.isomend, name, value)
        layout = Layout(bpy)
        extension.panel.ISOMEND_PT_panel.draw(SimpleNamespace(layout=layout), bpy.context)
        return layout

    yield draw
    for name, value in before.items():
        setattr(scene.isomend, name, value)


def test_each_tab_shows_its_own_controls(bpy, scene, extension, drawn):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    for tab, own in OWN.items():
        others = set().union(*(controls for name, controls in OWN.items() if name != tab))
        seen = set(drawn(tab=tab).drawn)
        assert own <= seen and not others & seen, tab
        assert COMMON <= seen if tab != "CHECK" else not COMMON & seen
    assert "bridge" not in drawn(tab="FILL", scope="ALL").drawn and "bridge" in drawn(scope="SELECTED").drawn
    bpy.ops.isomend.find_holes()
    assert "ISOMEND_UL_holes" in drawn(scope="ALL").drawn and "ISOMEND_UL_holes" not in drawn(tab="REPAIR").drawn
    bpy.ops.isomend.fill()
    assert "ISOMEND_UL_holes" not in drawn(tab="FILL").drawn and "isomend.show_error" in drawn(tab="CHECK").drawn
    progress = extension.running.progress
    progress.part, progress.text = 0.25, "isomend: 25 %"
    assert drawn().drawn == [("progress", 0.25, "isomend: 25 %")]
    progress.part = -1
    item.shape_key_add(name="Basis")
    for tab in OWN:
        seen = drawn(tab=tab).drawn
        assert "shape keys" in " ".join(seen) and not OWN[tab] & set(seen)


def test_a_row_of_the_list_adds_its_rim_to_the_selection(bpy, scene, extension):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window() | shapes.window(range(14, 16), range(30, 32))))
    bpy.ops.isomend.find_holes()
    rows = scene.isomend.holes
    bpy.ops.isomend.select_hole(index=0)
    layout = Layout(bpy)
    extension.panel.ISOMEND_UL_holes.draw_item(None, bpy.context, layout, None, rows[1], 0, None, "", index=1)
    assert "diameter" in layout.drawn and layout.buttons["isomend.select_hole"].run(bpy) == {"FINISHED"}
    assert sum(edge.select for edge in item.data.edges) == rows[0].edges + rows[1].edges


def test_buttons_run_with_the_settings_of_the_panel(bpy, scene, drawn):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window() | shapes.window(range(14, 16), range(30, 32))))
    bpy.ops.isomend.find_holes()
    between = sum(hole.diameter for hole in scene.isomend.holes) / 2
    small = scene.isomend.holes[1].edges
    # A bridge that was chosen before, whose control is hidden now, is not made.
    scene.isomend.bridge = True
    assert drawn(tab="FILL", scope="ALL", max_diameter=between).buttons["isomend.fill"].run(bpy) == {"FINISHED"}
    bpy.ops.isomend.find_holes()
    assert len(scene.isomend.holes) == 1 and scene.isomend.holes[0].edges > small
    assert drawn(tab="REPAIR").buttons["isomend.repair"].run(bpy) == {"FINISHED"} and shapes.is_closed(item.data)
    # The patch is selected. A dent in it is replaced by a surface that continues the globe.
    patch = [n for polygon in item.data.polygons if polygon.select for n in polygon.vertices]
    item.data.vertices[max(patch)].co *= 0.8
    assert drawn(tab="RESTORE").buttons["isomend.restore"].run(bpy) == {"FINISHED"} and shapes.is_closed(item.data)
    assert np.linalg.norm(shapes.positions(item.data), axis=1).min() > 0.98
    before = shapes.positions(item.data)
    assert drawn().buttons["isomend.fair"].run(bpy) == {"FINISHED"} and not np.array_equal(shapes.positions(item.data), before)


def test_menus(bpy, scene, extension):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    draw = extension.panel.draw_menu

    def entries(menu, mode):
        bpy.ops.object.mode_set(mode=mode)
        assert draw in getattr(bpy.types, menu).draw._draw_funcs
        layout = Layout(bpy)
        draw(SimpleNamespace(layout=layout), bpy.context)
        return layout

    names = {"isomend.fill", "isomend.restore", "isomend.fair", "isomend.repair", "isomend.check"}
    layout = entries("VIEW3D_MT_edit_mesh_clean", "EDIT")
    assert set(layout.drawn) == names
    assert layout.buttons["isomend.fill"].run(bpy) == {"FINISHED"}
    layout = entries("VIEW3D_MT_object_cleanup", "OBJECT")
    assert set(layout.drawn) == names - {"isomend.restore", "isomend.fair"} and shapes.is_closed(item.data)


def test_the_check_answers_and_selects_defects(bpy, scene, extension, drawn):
    vertices, faces = shapes.globe(without=shapes.window())
    item = shapes.added(bpy, vertices, faces)
    assert bpy.ops.isomend.check() == {"FINISHED"}
    layout = drawn(tab="CHECK")
    assert "1 hole is open" in " ".join(layout.drawn)
    assert layout.buttons["isomend.select_defects"].run(bpy) == {"FINISHED"} and item.mode == "EDIT"
    bpy.ops.object.mode_set(mode="OBJECT")
    count = {}
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1]):
            count[min(a, b), max(a, b)] = count.get((min(a, b), max(a, b)), 0) + 1
    at_rim = [any(count[min(a, b), max(a, b)] == 1 for a, b in zip(face, face[1:] + face[:1])) for face in faces]
    assert [polygon.select for polygon in item.data.polygons] == at_rim and any(at_rim)

    bpy.ops.isomend.fill()
    assert scene.isomend.checked == "", "a check before the fill says nothing about the mesh after it"
    assert bpy.ops.isomend.check() == {"FINISHED"} and "Watertight and printable" in drawn().drawn
    assert bpy.ops.isomend.check(min_wall=3) == {"FINISHED"} and len(scene.isomend.defects) == 1, "the globe is thinner than 3"
    assert bpy.ops.isomend.select_defects(kind="boundary_edge") == {"CANCELLED"}


def moved(bpy, item):
    item.data.vertices[0].co.z += 0.01


def cut_elsewhere(bpy, item):
    """Removes a vertex and its faces, which numbers the others anew."""
    edit(bpy, item, lambda bmesh, bm: bmesh.ops.delete(bm, geom=bm.verts[700:701], context="VERTS"))


def sorted_anew(bpy, item):
    edit(bpy, item, lambda bmesh, bm: bm.verts.sort(key=lambda vertex: vertex.co.x))


def closed_by_hand(bpy, item):
    """Closes the hole by one polygon: the vertices stay as they are."""
    edit(bpy, item, lambda bmesh, bm: bmesh.ops.holes_fill(bm, edges=bm.edges))


def edit(bpy, item, change):
    import bmesh

    bm = bmesh.new()
    bm.from_mesh(item.data)
    bm.verts.ensure_lookup_table()
    change(bmesh, bm)
    bm.to_mesh(item.data)
    bm.free()


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize("change", [moved, cut_elsewhere, sorted_anew, closed_by_hand])
def test_lists_are_out_of_date_after_any_change_of_the_mesh(bpy, scene, capfd, change, mode):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    scene.isomend.defects.clear()
    bpy.ops.object.mode_set(mode=mode)
    bpy.ops.isomend.find_holes()
    bpy.ops.isomend.check()
    for same in ("EDIT", "OBJECT"):
        bpy.ops.object.mode_set(mode=same)
        assert bpy.ops.isomend.select_hole(index=0) == {"FINISHED"} and item.mode == same
    kind = scene.isomend.defects[0].kind
    assert bpy.ops.isomend.select_defects(kind=kind) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    change(bpy, item)
    for elements in (item.data.vertices, item.data.edges, item.data.polygons):
        elements.foreach_set("select", [False] * len(elements))
    bpy.ops.object.mode_set(mode=mode)
    assert bpy.ops.isomend.select_hole(index=0) == {"CANCELLED"} and "list of holes is out of date" in capfd.readouterr().out
    assert bpy.ops.isomend.select_defects(kind=kind) == {"CANCELLED"} and "list of defects is out of date" in capfd.readouterr().out
    assert item.mode == mode
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not any(vertex.select for vertex in item.data.vertices)


def test_switched_off_and_on(bpy, extension):
    extension.unregister()
    assert not hasattr(bpy.types.Scene, "isomend")
    assert extension.panel.draw_menu not in bpy.types.VIEW3D_MT_object_cleanup.draw._draw_funcs
    extension.register()
    assert hasattr(bpy.types.Scene, "isomend")
    assert extension.panel.draw_menu in bpy.types.VIEW3D_MT_object_cleanup.draw._draw_funcs
