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
    """Puts these objects, which include the active one, into a mode. Which objects are selected does not change."""
    layer = bpy.context.view_layer.objects
    # Blender puts the selected objects into edit mode together with the active one.
    others = [item for item in layer if item.select_get() and item not in items]
    added = [item for item in items if not item.select_get()]
    set_selected(others, False)
    set_selected(added, True)
    try:
        bpy.ops.object.mode_set(mode=mode)
    finally:
        set_selected(others, True)
        set_selected(added, False)


def set_selected(items, selected):
    """Selects or deselects objects."""
    for item in items:
        item.select_set(selected)
