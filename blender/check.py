"""The check of a mesh: operators that say whether it is watertight and printable, and that select the faces at its defects."""

import json

import bpy
import numpy as np
from bpy.props import StringProperty

from . import settings
from .modes import enter, object_mode
from .refusals import OnMesh
from .running import Running
from .taken import digest_of


class ISOMEND_OT_check(Running, bpy.types.Operator):
    """Say whether the active mesh is watertight and can be printed, and list its defects"""

    bl_idname = "isomend.check"
    bl_label = "Check"
    bl_options = {"REGISTER"}
    __annotations__ = settings.of_check()
    doing = "isomend: checking the mesh"

    def work(self, taken):
        wall = taken.length(self.min_wall)
        return lambda progress: taken.model().check(min_wall=wall)

    def finish(self, context, item, taken, result):
        """Lists the defects, and reports the answer."""
        import isomend

        shown = context.scene.isomend
        shown.checked = ""
        shown.defects.clear()
        try:
            verdict = result()
        except (isomend.IsomendError, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for defect in verdict.defects.values():
            row = shown.defects.add()
            row.kind, row.count = defect.kind, defect.count
            row.polygons = json.dumps(np.unique(taken.polygons[defect.faces]).tolist())
        shown.checked, shown.checked_digest, shown.verdict = item.name, taken.digest, answer(verdict)
        self.report({"INFO" if verdict.sound else "WARNING"}, shown.verdict)
        return {"FINISHED"}


def answer(verdict):
    """The answer of a check as a sentence."""
    if verdict.sound:
        return "Watertight and printable"
    return f"Not watertight or printable: {'; '.join(verdict.reasons)}"


class ISOMEND_OT_select_defects(OnMesh, bpy.types.Operator):
    """Select the faces at all defects of one kind"""

    bl_idname = "isomend.select_defects"
    bl_label = "Select defects"
    bl_options = {"REGISTER", "UNDO"}

    kind: StringProperty(name="Kind", description="Kind of the defects, as in the list of defects")

    def execute(self, context):
        item, shown = context.active_object, context.scene.isomend
        found = [json.loads(row.polygons) for row in shown.defects if row.kind == self.kind]
        with object_mode():
            if shown.checked != item.name or not found or shown.checked_digest != digest_of(item.data):
                self.report({"WARNING"}, "The list of defects is out of date; check again")
                return {"CANCELLED"}
            select_polygons(item.data, found[0])
        # The selection of faces is visible in edit mode only.
        if item.mode != "EDIT":
            enter("EDIT", [item])
        bpy.ops.mesh.select_mode(type="FACE")
        return {"FINISHED"}


def select_polygons(mesh, polygons):
    """Selects these polygons with their edges and vertices, and nothing else."""
    marks = np.zeros(len(mesh.polygons), bool)
    marks[polygons] = True
    corners = [n for polygon in polygons for n in mesh.polygons[polygon].loop_indices]
    for elements, numbers in ((mesh.vertices, "vertex_index"), (mesh.edges, "edge_index")):
        chosen = np.zeros(len(elements), bool)
        chosen[[getattr(mesh.loops[n], numbers) for n in corners]] = True
        elements.foreach_set("select", chosen)
    mesh.polygons.foreach_set("select", marks)
    mesh.update()


CLASSES = (ISOMEND_OT_check, ISOMEND_OT_select_defects)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
