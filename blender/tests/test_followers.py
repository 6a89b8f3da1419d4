"""Hooks and vertex parents stay at their vertices when vertices with smaller numbers are removed."""

import numpy as np
import pytest
import shapes

BEFORE = np.array([(3, 0, 0), (3, 0.01, 0), (3, 0, 0.01), (3.01, 0, 0)], np.float32)
CORNERS = [(1, 0, 0), (0, -1, 0), (-1, 0, 0)]


def bodies(bpy):
    """A globe with a hole, whose faces at the first pole are selected, and before it a small tetrahedron."""
    vertices, faces = shapes.globe(without=shapes.window())
    tetrahedron = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
    item = shapes.added(bpy, np.concatenate([BEFORE, vertices]), [*tetrahedron, *[tuple(4 + v for v in face) for face in faces]])
    shapes.select(item, lambda centre: centre.z > 0.8 and centre.x < 2)
    return item


def hooked(bpy, item, inside):
    """A hook of the vertices that a function of their places accepts."""
    hook = item.modifiers.new("Hook", "HOOK")
    hook.object = bpy.data.objects.new("handle", None)
    hook.vertex_indices_set([n for n, place in enumerate(shapes.positions(item.data)) if inside(place)])
    return hook


def child_at(bpy, item, places):
    """An object whose parents are the vertices nearest to one or three places."""
    child = bpy.data.objects.new("child", None)
    child.parent, child.parent_type = item, "VERTEX" if len(places) == 1 else "VERTEX_3"
    numbers = [int(np.argmin(np.linalg.norm(shapes.positions(item.data) - place, axis=1))) for place in places]
    child.parent_vertices = (numbers * 3)[:3]
    return child


def places_of(item, numbers):
    return {tuple(place) for place in shapes.positions(item.data)[list(numbers)]}


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT"])
@pytest.mark.parametrize(
    ("operator", "options"), [("restore", {}), ("fair", {"strength": 0.3}), ("repair", {"debris": 0.01}), ("fill", {"scope": "ALL"})]
)
def test_the_same_vertices_are_named_after_a_run(bpy, scene, operator, options, mode):
    item = bodies(bpy)
    bpy.context.tool_settings.mesh_select_mode = (False, False, True)
    hook = hooked(bpy, item, lambda place: -0.3 < place[2] < -0.1)
    # A second object with the same mesh has a hook of its own.
    twin = bpy.data.objects.new("twin", item.data)
    second = hooked(bpy, twin, lambda place: place[2] == -1)
    one, three = child_at(bpy, item, CORNERS[:1]), child_at(bpy, twin, CORNERS)

    def named():
        parents = [places_of(item, list(child.parent_vertices)[:count]) for child, count in ((one, 1), (three, 3))]
        return [places_of(item, modifier.vertex_indices) for modifier in (hook, second)] + parents

    before, removed = named(), list(hook.vertex_indices)
    assert [len(places) for places in before] == [96, 1, 1, 3]
    bpy.ops.object.mode_set(mode=mode)
    assert getattr(bpy.ops.isomend, operator)(**options) == {"FINISHED"}
    bpy.ops.object.mode_set(mode="OBJECT")
    assert named() == before and (operator != "repair" or list(hook.vertex_indices) != removed)


def test_removed_vertices_leave_their_hook_and_parents_become_the_nearest(bpy, scene):
    item = bodies(bpy)
    part, all_removed = hooked(bpy, item, lambda place: place[2] < -0.9 or place[0] > 2), hooked(bpy, item, lambda place: place[0] > 2)
    one = child_at(bpy, item, [(3, 0, 0)])
    three = child_at(bpy, item, [(3, 0, 0), (3, 0.01, 0), (0, 0, -1)])
    staying = {place for place in places_of(item, part.vertex_indices) if place[0] < 2}
    assert bpy.ops.isomend.repair(debris=0.01) == {"FINISHED"}
    places = shapes.positions(item.data)
    assert places[:, 0].max() < 2
    assert places_of(item, part.vertex_indices) == staying and len(all_removed.vertex_indices) == 0
    nearest = np.argsort(np.linalg.norm(places - np.float32([3, 0, 0]), axis=1))
    assert one.parent_vertices[0] == nearest[0] and places[nearest[0], 0] == 1
    assert len(set(three.parent_vertices)) == 3 and tuple(places[three.parent_vertices[2]]) == (0, 0, -1)


def test_hooks_and_parents_are_as_before_after_a_failure(bpy, scene, extension, monkeypatch):
    item = bodies(bpy)
    last = len(item.data.vertices) - 1
    hook, child = hooked(bpy, item, lambda place: place[2] == -1), child_at(bpy, item, [(0, 0, -1)])

    def failing(*arguments):
        raise OverflowError("a step failed")

    monkeypatch.setattr(extension.given_back, "select", failing)
    with pytest.raises(RuntimeError, match="a step failed"):
        bpy.ops.isomend.repair(debris=0.01)
    assert list(hook.vertex_indices) == [last] == [child.parent_vertices[0]] and places_of(item, [last]) == {(0, 0, -1)}
