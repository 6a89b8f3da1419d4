"""The panel in the sidebar of the 3D view, under the tab "isomend"."""

import bpy

from . import attributes as at
from . import expected_error, settings
from .refusals import reason_against


class ISOMEND_UL_holes(bpy.types.UIList):
    """The list of holes with their sizes."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row()
        row.label(text=f"{item.number}", icon="MESH_CIRCLE")
        row.label(text=f"{item.edges} edges")
        row.prop(item, "diameter", text="", emboss=False)
        row.label(text="outer border" if item.is_outer_boundary else "")


class ISOMEND_PT_panel(bpy.types.Panel):
    bl_idname = "ISOMEND_PT_panel"
    bl_label = "isomend"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "isomend"

    def draw(self, context):
        layout, shown = self.layout, context.scene.isomend
        layout.use_property_split = True
        layout.use_property_decorate = False
        reason = reason_against(context.active_object)
        if reason:
            for line in lines(reason, 40):
                layout.label(text=line)
            return
        if shown.progress >= 0:
            layout.progress(factor=shown.progress, text=shown.progress_text)
            return
        self.draw_fill(layout, context, shown)
        for operator, properties in (
            ("isomend.restore", settings.of_restore()),
            ("isomend.fair", settings.of_fair()),
            ("isomend.repair", settings.of_repair()),
        ):
            self.draw_one(layout, shown, operator, properties, operator != "isomend.fair")
        common = layout.box()
        for name in settings.common():
            common.prop(shown, name)
        if at.SIGMA in context.active_object.data.attributes or expected_error.is_shown(context):
            layout.operator("isomend.show_error", depress=expected_error.is_shown(context))

    def draw_fill(self, layout, context, shown):
        self.draw_one(layout, shown, "isomend.fill", settings.of_fill(), True)
        layout.operator("isomend.find_holes")
        if shown.holes and shown.holes_of == context.active_object.name:
            layout.template_list("ISOMEND_UL_holes", "", shown, "holes", shown, "active_hole", rows=3)

    def draw_one(self, layout, shown, operator, properties, fills):
        box = layout.box()
        for name in properties:
            box.prop(shown, name)
        button = box.operator(operator)
        for name in [*properties, *(settings.common() if fills else ())]:
            setattr(button, name, getattr(shown, name))


def lines(text, width):
    """A text in lines of at most `width` characters, since labels of a panel do not wrap."""
    import textwrap

    return textwrap.wrap(text, width)


CLASSES = (ISOMEND_UL_holes, ISOMEND_PT_panel)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
