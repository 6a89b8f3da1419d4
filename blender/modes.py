"""Modes of objects: leaves edit mode while a mesh is written, and returns to it."""

from contextlib import contextmanager

import bpy


@contextmanager
def object_mode():
    """Object mode inside a `with` block. After it, also after an exception, every object is in the mode that it had before."""
    active = bpy.context.view_layer.objects.active
    mode = active.mode
    if mode == "OBJECT":
        yield
        return
    # Blender leaves edit mode for all objects at once.
    together = [item for item in bpy.context.view_layer.objects if item.mode == mode]
    bpy.ops.object.mode_set(mode="OBJECT")
    try:
        yield
    finally:
        enter(mode, together)


def enter(mode, items):
    """Puts these objects, which include the active one, into a mode. Which objects are selected and hidden does not change."""
    layer = bpy.context.view_layer
    before = [(item, item.select_get(), item.hide_get(), item.hide_select, item.hide_viewport) for item in layer.objects]
    changing = [row for row in before if row[1] or row[0] in items]
    # Blender puts the selected objects that can be seen into edit mode together with the active one.
    for item, *_ in changing:
        if item in items:
            set_visibility(item, False, False, False)
    layer.update()
    for item, *_ in changing:
        item.select_set(item in items)
    try:
        bpy.ops.object.mode_set(mode=mode)
    finally:
        for item, selected, *hiding in changing:
            item.select_set(selected)
            if item in items:
                set_visibility(item, *hiding)


def set_visibility(item, hidden, unselectable, off):
    """Sets whether an object is hidden in the view layer, cannot be selected, and is switched off in all viewports."""
    item.hide_select, item.hide_viewport = unselectable, off
    item.hide_set(hidden)
