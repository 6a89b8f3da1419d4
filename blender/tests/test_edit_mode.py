"""Edit mode: results are the same as in object mode, with all attributes; modes, selections and undo steps are as the user expects."""

import time

import numpy as np
import pytest
import shapes
from test_running import Operator, context_of, event

MODES = ("OBJECT", "EDIT")


@pytest.fixture(autouse=True)
def back_in_object_mode(bpy, scene):
    """Ends edit mode, also after a test that failed."""
    yield
    active = bpy.context.view_layer.objects.active
    if active is not None and active.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")


def dressed_globe(bpy, without=frozenset(), name="mesh"):
    """A globe with texture coordinates, attributes of all domains, a second material on all faces, and a vertex group."""
    item = shapes.added(bpy, *shapes.globe(without=without), name=name)
    mesh, rng = item.data, np.random.default_rng(3)
    uv = mesh.uv_layers.new(name="UVMap")
    uv.data.foreach_set("uv", rng.random(2 * len(mesh.loops)).astype(np.float32))
    for label, kind, domain, prop, components in (
        ("Col", "FLOAT_COLOR", "POINT", "color", 4), ("paint", "BYTE_COLOR", "CORNER", "color_srgb", 4),
        ("height", "FLOAT", "POINT", "value", 1), ("region", "INT", "FACE", "value", 1), ("load", "FLOAT", "EDGE", "value", 1),
    ):  # fmt: skip
        data = mesh.attributes.new(label, kind, domain).data
        some = rng.integers(0, 9, components * len(data))
        data.foreach_set(prop, some.astype(np.int32) if kind == "INT" else (some / 9).astype(np.float32))
    for label in ("first", "second"):
        mesh.materials.append(bpy.data.materials.new(label))
    mesh.polygons.foreach_set("material_index", [1] * len(mesh.polygons))
    item.vertex_groups.new(name="bone").add(range(len(mesh.vertices)), 0.75, "REPLACE")
    shapes.select(item, lambda centre: centre.x > 0.8)
    return item


def everything(mesh):
    """All attributes of a mesh, weights and selections included, as lists by name."""
    out = {}
    for a in mesh.attributes:
        # Blender 5 adds these to each mesh that it writes.
        if a.name.startswith(".uv_select"):
            continue
        prop = next(p for p in ("value", "vector", "color_srgb", "color") if not len(a.data) or hasattr(a.data[0], p))
        out[a.name] = [tuple(v) if hasattr(v, "__len__") else v for v in (getattr(d, prop) for d in a.data)]
    out["weights"] = [sorted((g.group, g.weight) for g in v.groups) for v in mesh.vertices]
    return out


RUNS = {
    "fill": {"without": shapes.window()}, "restore": {}, "fair": {}, "repair": {"without": shapes.window()},
}  # fmt: skip


@pytest.mark.parametrize("operator", RUNS)
def test_every_operator_gives_the_same_mesh_in_both_modes(bpy, scene, operator):
    results = []
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    for mode in MODES:
        item = dressed_globe(bpy, **RUNS[operator])
        faces = len(item.data.polygons)
        bpy.ops.object.mode_set(mode=mode)
        assert getattr(bpy.ops.isomend, operator)() == {"FINISHED"} and item.mode == mode
        bpy.ops.object.mode_set(mode="OBJECT")
        assert len(item.data.polygons) != faces and {p.material_index for p in item.data.polygons} == {1}
        results.append(everything(item.data))
        bpy.data.objects.remove(item)
    assert results[0].keys() == results[1].keys()
    for name in results[0]:
        assert results[0][name] == results[1][name], name


def test_the_answers_are_the_same_in_both_modes(bpy, scene):
    answers = []
    for mode in MODES:
        item = dressed_globe(bpy, without=shapes.window())
        bpy.ops.object.mode_set(mode=mode)
        assert bpy.ops.isomend.check() == {"FINISHED"} and bpy.ops.isomend.find_holes() == {"FINISHED"} and item.mode == mode
        shown = scene.isomend
        answers.append((shown.verdict, [(d.kind, d.polygons) for d in shown.defects], [(h.diameter, h.rim) for h in shown.holes]))
        assert bpy.ops.isomend.fill() == {"FINISHED"}
        assert bpy.ops.isomend.show_error() == {"FINISHED"} and bpy.context.view_layer.material_override is not None
        assert bpy.ops.isomend.show_error() == {"FINISHED"} and item.mode == mode
        bpy.ops.object.mode_set(mode="OBJECT")
    assert answers[0] == answers[1] and len(answers[0][2]) == 1
    assert not [mesh for mesh in bpy.data.meshes if not mesh.users], "copies of meshes are removed"


def test_a_cube_without_one_face(bpy, scene):
    import bmesh

    bpy.ops.mesh.primitive_cube_add()
    item = bpy.context.active_object
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(item.data)
    edited.faces.ensure_lookup_table()
    bmesh.ops.delete(edited, geom=[edited.faces[0]], context="FACES")
    bmesh.update_edit_mesh(item.data)
    assert bpy.ops.isomend.check() == {"FINISHED"} and "1 hole is open" in scene.isomend.verdict
    assert bpy.ops.isomend.fill() == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert shapes.is_closed(item.data) and len(item.data.uv_layers["UVMap"].data) == len(item.data.loops)


def test_marks_of_a_fill_in_object_mode_stay_after_a_restoration_in_edit_mode(bpy, scene):
    results = []
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    for mode in MODES:
        item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
        bpy.ops.isomend.fill()
        patch = {p.index for p in item.data.polygons if item.data.attributes["isomend_patch"].data[p.index].value}
        centre = item.data.polygons[min(patch)].center.copy()
        shapes.select(item, lambda place: (place - centre).length < 0.2)
        assert 0 < len(patch & {p.index for p in item.data.polygons if p.select}) < len(patch)
        bpy.ops.object.mode_set(mode=mode)
        assert bpy.ops.isomend.restore() == {"FINISHED"}
        bpy.ops.object.mode_set(mode="OBJECT")
        results.append(everything(item.data))
    assert results[0] == results[1]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("step", ["fill_corners", "mark", "select"])
def test_a_step_that_fails_leaves_the_mesh_as_it_was(bpy, scene, extension, monkeypatch, mode, step):
    item = dressed_globe(bpy)
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    mesh, before, polygons = item.data, everything(item.data), shapes.polygons(item.data)

    def failing(*arguments):
        raise OverflowError("a step failed")

    monkeypatch.setattr(extension.given_back, step, failing)
    bpy.ops.object.mode_set(mode=mode)
    with pytest.raises(RuntimeError, match="a step failed"):
        bpy.ops.isomend.restore()
    assert item.mode == mode
    bpy.ops.object.mode_set(mode="OBJECT")
    assert shapes.polygons(mesh) == polygons and everything(mesh) == before
    assert [group.name for group in item.vertex_groups] == ["bone"]
    assert [m.name for m in bpy.data.meshes] == [mesh.name]


def two_in_edit_mode(bpy):
    """Two globes with a hole in edit mode; the second is active."""
    items = [dressed_globe(bpy, without=shapes.window(), name=name) for name in ("A", "B")]
    third = shapes.added(bpy, *shapes.globe(), name="C")
    third.select_set(False)
    bpy.context.view_layer.objects.active = items[1]
    bpy.ops.object.mode_set(mode="EDIT")
    third.select_set(True)
    assert [item.mode for item in (*items, third)] == ["EDIT", "EDIT", "OBJECT"]
    return [*items, third]


@pytest.mark.parametrize("chosen", [(True, True, True), (False, True, False), (False, False, True)])
def test_other_objects_keep_their_mode_and_selection(bpy, scene, chosen):
    items = two_in_edit_mode(bpy)
    for item, selected in zip(items, chosen):
        item.select_set(selected)

    def is_as_before():
        assert [item.mode for item in items] == ["EDIT", "EDIT", "OBJECT"]
        assert [item.select_get() for item in items] == list(chosen)
        assert bpy.context.view_layer.objects.active == items[1]

    for run in (bpy.ops.isomend.check, bpy.ops.isomend.find_holes, bpy.ops.isomend.fill, bpy.ops.isomend.find_holes):
        assert run() == {"FINISHED"}
        is_as_before()
    with pytest.raises(RuntimeError, match="has no holes"):
        bpy.ops.isomend.fill()
    is_as_before()
    bpy.ops.object.mode_set(mode="OBJECT")
    assert not shapes.is_closed(items[0].data) and shapes.is_closed(items[1].data), "only the active object is mended"


@pytest.mark.parametrize("hiding", ["hide_set", "hide_viewport", "hide_select"])
def test_other_objects_that_are_hidden_keep_their_mode(bpy, scene, hiding):
    items = two_in_edit_mode(bpy)

    def state():
        return [(i.mode, i.select_get(), i.hide_get(), i.hide_viewport, i.hide_select) for i in items]

    if hiding == "hide_set":
        items[0].hide_set(True)
    else:
        setattr(items[0], hiding, True)
    bpy.context.view_layer.update()
    before = state()
    assert before[0][0] == "EDIT" and True in before[0][2:]
    assert bpy.ops.isomend.fill() == {"FINISHED"} and state() == before


def test_a_run_in_a_thread_returns_to_edit_mode(bpy, scene, extension):
    items = two_in_edit_mode(bpy)
    texts, context = context_of(bpy, items[1])
    for name in ("fill", "check", "find_holes"):
        operator = Operator(extension, **{name: True})
        assert operator.invoke(context, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
        while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
            time.sleep(0.01)
        assert answer == {"FINISHED"} and [item.mode for item in items] == ["EDIT", "EDIT", "OBJECT"]
    assert scene.isomend.verdict == "Watertight and printable" and not scene.isomend.holes


def test_edits_that_edit_mode_has_not_stored_yet_are_a_change(bpy, scene, extension):
    import bmesh

    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    bpy.ops.object.mode_set(mode="EDIT")
    texts, context = context_of(bpy, item)
    operator = Operator(extension, fill=True)
    operator.invoke(context, event("LEFTMOUSE"))
    edited = bmesh.from_edit_mesh(item.data)
    edited.verts.ensure_lookup_table()
    edited.verts[0].co.x += 1
    while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
        time.sleep(0.01)
    assert answer == {"CANCELLED"} and "was changed during the run" in operator.said[0][1] and item.mode == "EDIT"


def test_lists_select_without_changing_modes(bpy, scene):
    items = two_in_edit_mode(bpy)
    items[0].select_set(False)
    bpy.ops.isomend.find_holes()
    assert bpy.ops.isomend.select_hole(index=0) == {"FINISHED"}
    bpy.ops.isomend.check()
    assert bpy.ops.isomend.select_defects(kind=scene.isomend.defects[0].kind) == {"FINISHED"}
    assert [item.mode for item in items] == ["EDIT", "EDIT", "OBJECT"]
    assert [item.select_get() for item in items] == [False, True, True]


@pytest.mark.parametrize("groups", [[], ["bone"], ["bone", "arm"]])
def test_undo_takes_a_fill_in_edit_mode_back_with_its_vertex_group(bpy, scene, groups):
    import bmesh

    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    for group in groups:
        item.vertex_groups.new(name=group).add([3], 0.5, "REPLACE")
    faces, name = len(item.data.polygons), item.name
    bpy.ops.ed.undo_push(message="object mode")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.ed.undo_push(message="edit mode")
    bpy.ops.isomend.fill()
    bpy.ops.ed.undo_push(message="Fill holes")

    def state():
        item = bpy.data.objects[name]
        assert item.mode == "EDIT"
        edited = bmesh.from_edit_mesh(item.data)
        return len(edited.faces) > faces, "isomend_patch" in item.data.attributes, [group.name for group in item.vertex_groups]

    for _ in range(2):
        bpy.ops.ed.undo()
        assert state() == (False, False, groups)
        bpy.ops.ed.redo()
        assert state() == (True, True, [*groups, "isomend patch"])
    bpy.ops.object.mode_set(mode="OBJECT")
    item = bpy.data.objects[name]
    patch = {v for p, mark in zip(item.data.polygons, item.data.attributes["isomend_patch"].data) if mark.value for v in p.vertices}
    assert {v.index for v in item.data.vertices if any(g.group == len(groups) for g in v.groups)} == patch
