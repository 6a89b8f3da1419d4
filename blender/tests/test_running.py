"""Runs of operators in a thread, with progress, cancelled with Escape, undone; and the colours of expected errors."""

import time
from types import SimpleNamespace

import numpy as np
import pytest
import shapes
from test_panel import Layout


class Operator:
    """Stands for an operator in its modal run, without Blender's window."""

    def __init__(self, extension, **properties):
        self.said = []
        self.report = lambda kind, text: self.said.append((kind, text))
        for name in ("fill", "restore", "fair", "repair"):
            if name in properties:
                of = getattr(extension.settings, f"of_{name}")()
                common = {} if name == "fair" else extension.settings.common()
                chosen = {"scope": "ALL", "energy": "willmore", "sharp": "auto", "mirror": "none"}
                for key in {**of, **common}:
                    setattr(self, key, chosen.get(key, 0))
                kind = getattr(extension.operators, f"ISOMEND_OT_{name}")
        for name, module in (("check", "check"), ("find_holes", "holes")):
            if name in properties:
                self.min_wall = 0
                kind = getattr(getattr(extension, module), f"ISOMEND_OT_{name}")
        self.doing = kind.doing
        for name in ("work", "prepare", "finish", "invoke", "modal", "show_progress", "clear_progress", "cancel", "solving"):
            if hasattr(kind, name):
                setattr(self, name, getattr(kind, name).__get__(self))


def context_of(bpy, item):
    """A context whose window has timers and progress."""
    window = SimpleNamespace(
        event_timer_add=lambda pause, window: "timer", event_timer_remove=lambda timer: None, modal_handler_add=lambda operator: None
    )
    texts = []
    workspace = SimpleNamespace(status_text_set=texts.append)
    return texts, SimpleNamespace(
        active_object=item, scene=bpy.context.scene, window_manager=window, window=None, workspace=workspace, screen=None
    )


def event(kind, value="NOTHING"):
    return SimpleNamespace(type=kind, value=value)


def test_a_run_shows_progress_and_ends(bpy, scene, extension):
    item = shapes.plane_with_holes(bpy, 120, 3)
    count = len(item.data.polygons)
    texts, context = context_of(bpy, item)
    operator = Operator(extension, fill=True)
    assert operator.invoke(context, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert operator.modal(context, event("MIDDLEMOUSE")) == {"PASS_THROUGH"}, "the view can be moved"
    assert operator.modal(context, event("X", "PRESS")) == {"RUNNING_MODAL"}, "the mesh cannot be changed"
    seen = set()
    while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
        seen.add(extension.running.progress.part)
        time.sleep(0.01)
    assert answer == {"FINISHED"} and len(item.data.polygons) > count
    assert len(seen) > 2 and all(0 <= part <= 1 for part in seen) and extension.running.progress.part == -1
    assert any("region" in (text or "") and "Esc cancels" in text for text in texts) and texts[-1] is None
    assert operator.said[0][1].startswith("9 of 9 holes closed")


def test_escape_cancels_and_nothing_is_changed(bpy, scene, extension):
    item = shapes.plane_with_holes(bpy, 300, 8)
    before = shapes.positions(item.data)
    texts, context = context_of(bpy, item)
    operator = Operator(extension, fill=True)
    operator.invoke(context, event("LEFTMOUSE"))
    operator.modal(context, event("ESC", "PRESS"))
    start = time.monotonic()
    while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
        time.sleep(0.01)
    assert answer == {"CANCELLED"} and time.monotonic() - start < 5
    assert np.array_equal(shapes.positions(item.data), before) and "Cancelled" in operator.said[0][1]


@pytest.mark.parametrize(("name", "said"), [("check", "Not watertight or printable"), ("find_holes", "10 holes")])
def test_checks_and_lists_leave_the_window_usable(bpy, scene, extension, name, said):
    item = shapes.plane_with_holes(bpy, 120, 3)
    texts, context = context_of(bpy, item)
    operator = Operator(extension, **{name: True})
    assert operator.invoke(context, event("LEFTMOUSE")) == {"RUNNING_MODAL"}
    assert operator.modal(context, event("MIDDLEMOUSE")) == {"PASS_THROUGH"}, "the view can be moved"
    while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
        time.sleep(0.01)
    assert answer == {"FINISHED"} and operator.said[0][1].startswith(said) and texts[-1] is None
    assert len(scene.isomend.holes) == (10 if name == "find_holes" else 0)
    operator = Operator(extension, **{name: True})
    operator.invoke(context, event("LEFTMOUSE"))
    assert operator.modal(context, event("ESC", "PRESS")) == {"CANCELLED"} and operator.said == [({"WARNING"}, "Cancelled")]


def test_a_file_saved_during_a_run_opens_with_the_whole_panel(bpy, scene, extension, tmp_path):
    item = shapes.plane_with_holes(bpy, 120, 3)
    bpy.ops.isomend.find_holes()
    texts, context = context_of(bpy, item)
    operator = Operator(extension, fill=True)
    operator.invoke(context, event("LEFTMOUSE"))
    operator.modal(context, event("TIMER"))
    path = str(tmp_path / "during.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    operator.cancel(context)
    bpy.ops.wm.open_mainfile(filepath=path)
    layout = Layout(bpy)
    extension.panel.ISOMEND_PT_panel.draw(SimpleNamespace(layout=layout), bpy.context)
    assert {"isomend.fill", "ISOMEND_UL_holes"} <= set(layout.drawn)
    assert bpy.ops.isomend.select_hole(index=1) == {"FINISHED"}, "the list of holes was saved, too"


def moved(mesh):
    mesh.vertices[0].co.x += 1


def flipped(mesh):
    mesh.polygons[0].flip()


@pytest.mark.parametrize("change", [moved, flipped])
def test_a_mesh_that_changed_meanwhile_is_left_alone(bpy, scene, extension, change):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    count = len(item.data.polygons)
    texts, context = context_of(bpy, item)
    operator = Operator(extension, fill=True)
    operator.invoke(context, event("LEFTMOUSE"))
    change(item.data)
    while (answer := operator.modal(context, event("TIMER"))) == {"RUNNING_MODAL"}:
        time.sleep(0.01)
    assert answer == {"CANCELLED"} and "was changed during the run" in operator.said[0][1] and len(item.data.polygons) == count


def test_undo_takes_a_fill_back(bpy, scene):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    count, name = len(item.data.polygons), item.name
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.isomend.fill()
    bpy.ops.ed.undo_push(message="Fill holes")
    assert len(bpy.data.objects[name].data.polygons) > count
    bpy.ops.ed.undo()
    assert len(bpy.data.objects[name].data.polygons) == count
    assert "isomend_patch" not in bpy.data.objects[name].data.attributes
    bpy.ops.ed.redo()
    assert len(bpy.data.objects[name].data.polygons) > count


def test_expected_errors_are_shown_and_hidden(bpy, scene):
    item = shapes.added(bpy, *shapes.globe(without=shapes.window()))
    item.data.materials.append(bpy.data.materials.new("own"))
    bpy.ops.isomend.fill()
    layer = bpy.context.view_layer
    assert bpy.ops.isomend.show_error() == {"FINISHED"} and layer.material_override.name == "isomend expected error"
    largest = float(shapes.values(item.data, "isomend_sigma", "value").max())
    nodes = layer.material_override.node_tree.nodes
    assert nodes["Map Range"].inputs["From Max"].default_value == pytest.approx(largest)
    assert len(nodes["Color Ramp" if "Color Ramp" in nodes else "ColorRamp"].color_ramp.elements) == 4
    assert bpy.ops.isomend.show_error() == {"FINISHED"} and layer.material_override is None
    assert [m.name for m in item.data.materials] == ["own"]
