"""Shows the expected error of patches as colours: a material with a colour ramp over the attribute `isomend_sigma`, which overrides all
materials of the view layer while it is shown. The objects' own materials are not changed."""

import bpy

from . import attributes as at
from .refusals import OnMesh

NAME = "isomend expected error"

# The colour ramp: position from 0 (no error) to 1 (largest error), colour (linear RGBA).
RAMP = [(0.0, (0.8, 0.8, 0.8, 1)), (0.05, (0.05, 0.15, 0.6, 1)), (0.5, (0.95, 0.75, 0.1, 1)), (1.0, (0.7, 0.02, 0.02, 1))]


def material_for(largest):
    """The material; `largest` is the error at the end of its ramp, in the units of the scene."""
    material = bpy.data.materials.get(NAME) or bpy.data.materials.new(NAME)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    value = nodes.new("ShaderNodeAttribute")
    value.attribute_name = at.SIGMA
    scaled = nodes.new("ShaderNodeMapRange")
    scaled.inputs["From Max"].default_value = largest
    ramp = nodes.new("ShaderNodeValToRGB")
    elements = ramp.color_ramp.elements
    while len(elements) < len(RAMP):
        elements.new(0.5)
    for element, (position, colour) in zip(elements, RAMP):
        element.position, element.color = position, colour
    shader = nodes.new("ShaderNodeBsdfPrincipled")
    output = nodes.new("ShaderNodeOutputMaterial")
    links.new(value.outputs["Fac"], scaled.inputs["Value"])
    links.new(scaled.outputs["Result"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], shader.inputs["Base Color"])
    links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    for place, node in enumerate((value, scaled, ramp, shader, output)):
        node.location = (300 * place, 0)
    return material


class ISOMEND_OT_show_error(OnMesh, bpy.types.Operator):
    """Show the expected error of patches as colours, in the material preview and in renderings. Press again to hide it"""

    bl_idname = "isomend.show_error"
    bl_label = "Show expected error"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and (at.SIGMA in context.active_object.data.attributes or is_shown(context))

    def execute(self, context):
        if is_shown(context):
            context.view_layer.material_override = None
            return {"FINISHED"}
        with at.readable(context.active_object) as mesh:
            largest = float(at.values_of(mesh, at.SIGMA).max(initial=0))
        if largest <= 0:
            self.report({"WARNING"}, "The mesh has no patches with an expected error")
            return {"CANCELLED"}
        context.view_layer.material_override = material_for(largest)
        for area in context.screen.areas if context.screen else []:
            if area.type == "VIEW_3D" and area.spaces.active.shading.type in ("WIREFRAME", "SOLID"):
                area.spaces.active.shading.type = "MATERIAL"
        return {"FINISHED"}


def is_shown(context):
    """Whether the material overrides all others."""
    override = context.view_layer.material_override
    return override is not None and override.name == NAME


register, unregister = bpy.utils.register_classes_factory((ISOMEND_OT_show_error,))
