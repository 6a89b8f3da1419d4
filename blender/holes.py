"""The list of holes: operators that list the holes with their sizes, and select the rim of a hole."""

import json

import bpy
import numpy as np
from bpy.props import BoolProperty, IntProperty

from . import attributes as at
from .modes import object_mode
from .refusals import OnMesh
from .running import Running
from .taken import digest_of


class ISOMEND_OT_find_holes(Running, bpy.types.Operator):
    """List the holes of the active mesh with their sizes"""

    bl_idname = "isomend.find_holes"
    bl_label = "Find holes"
    bl_options = {"REGISTER"}
    doing = "isomend: finding holes"

    def work(self, taken):
        return lambda progress: taken.model().inspect().holes

    def finish(self, context, item, taken, result):
        """Lists the holes, and reports their number."""
        import isomend

        settings = context.scene.isomend
        settings.holes.clear()
        try:
            found = result()
        except (isomend.IsomendError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for hole in found:
            row = settings.holes.add()
            row.number, row.edges, row.diameter = hole.id, hole.edges, hole.diameter * taken.scale
            row.is_outer_boundary, row.rim = hole.is_outer_boundary, json.dumps(hole.rim.tolist())
        settings.holes_of, settings.holes_digest = item.name, taken.digest
        self.report({"INFO"}, f"{len(found)} {'hole' if len(found) == 1 else 'holes'}")
        return {"FINISHED"}


class ISOMEND_OT_select_hole(OnMesh, bpy.types.Operator):
    """Select the rim of a hole of the list, alone or in addition to what is selected"""

    bl_idname = "isomend.select_hole"
    bl_label = "Select hole"
    bl_options = {"REGISTER", "UNDO"}

    index: IntProperty(name="Row", description="Row of the list, from 0", min=0)
    extend: BoolProperty(name="Extend", description="Keep what is selected")

    def execute(self, context):
        item, settings = context.active_object, context.scene.isomend
        with object_mode():
            is_listed = settings.holes_of == item.name and self.index < len(settings.holes)
            if not is_listed or settings.holes_digest != digest_of(item.data):
                self.report({"WARNING"}, "The list of holes is out of date; find the holes again")
                return {"CANCELLED"}
            select_rim(item.data, json.loads(settings.holes[self.index].rim), self.extend)
        return {"FINISHED"}


def select_rim(mesh, rim, extend):
    """Selects the vertices and edges of a rim; with `extend` what was selected before stays selected."""
    chosen, edges, polygons = (np.zeros(len(elements), bool) for elements in (mesh.vertices, mesh.edges, mesh.polygons))
    chosen[rim] = True
    ends = at.numbers(mesh.edges, "vertices", 2)
    pairs = {tuple(sorted(pair)) for pair in zip(rim, rim[1:] + rim[:1])}
    near = np.flatnonzero(chosen[ends].all(axis=1))
    edges[[n for n in near if tuple(sorted(ends[n].tolist())) in pairs]] = True
    for elements, marks in ((mesh.vertices, chosen), (mesh.edges, edges), (mesh.polygons, polygons)):
        if extend:
            marks |= at.numbers(elements, "select", dtype=bool)
        elements.foreach_set("select", marks)
    mesh.update()


CLASSES = (ISOMEND_OT_find_holes, ISOMEND_OT_select_hole)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
