"""The panel in the sidebar of the 3D view, under the tab "isomend", and the entries of Blender's menus. The panel has a tab of its own for
each task."""

import textwrap

import bpy

from . import attributes as at
from . import expected_error, settings
from .refusals import reason_against
from .running import progress

# Characters in a line of text, since labels of a panel do not wrap.
WIDTH = 40

# The buttons of the tabs that change the mesh: the operator, its own properties, and whether it fills holes.
BUTTONS = {
    "isomend.fill": (settings.of_fill, True),
    "isomend.restore": (settings.of_restore, True),
    "isomend.fair": (settings.of_fair, False),
    "isomend.repair": (settings.of_repair, True),
    "isomend.check": (settings.of_check, False),
}


class ISOMEND_UL_holes(bpy.types.UIList):
    """The list of holes with their sizes."""

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        row = layout.row()
        row.label(text=f"{item.number}", icon="MESH_CIRCLE")
        row.label(text=f"{item.edges} edges")
        row.prop(item, "diameter", text="", emboss=False)
        row.label(text="outer border" if item.is_outer_boundary else "")
        more = row.operator("isomend.select_hole", text="", icon="ADD")
        more.index, more.extend = index, True


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
            draw_text(layout, reason)
            return
        if progress.part >= 0:
            layout.progress(factor=progress.part, text=progress.text)
            return
        layout.row().prop(shown, "tab", expand=True)
        {"FILL": draw_fill, "RESTORE": draw_restore, "REPAIR": draw_repair, "CHECK": draw_check}[shown.tab](layout, context, shown)


def draw_fill(layout, context, shown):
    """The tab for filling, with the list of holes."""
    draw_properties(layout, shown, [name for name in settings.of_fill() if name != "bridge" or shown.scope == "SELECTED"])
    draw_properties(layout, shown, settings.common())
    draw_button(layout, shown, "isomend.fill")
    layout.operator("isomend.find_holes")
    if shown.holes and shown.holes_of == context.active_object.name:
        layout.template_list("ISOMEND_UL_holes", "", shown, "holes", shown, "active_hole", rows=3)


def draw_restore(layout, context, shown):
    """The tab for restoring and fairing selected faces."""
    box = layout.box()
    draw_properties(box, shown, settings.of_restore())
    draw_properties(box, shown, settings.common())
    draw_button(box, shown, "isomend.restore")
    box = layout.box()
    draw_properties(box, shown, settings.of_fair())
    draw_button(box, shown, "isomend.fair")


def draw_repair(layout, context, shown):
    """The tab for repairing."""
    draw_properties(layout, shown, settings.of_repair())
    draw_properties(layout, shown, settings.common())
    draw_button(layout, shown, "isomend.repair")


def draw_check(layout, context, shown):
    """The tab for checking: the last answer, the defects, and the expected error of patches."""
    draw_properties(layout, shown, settings.of_check())
    draw_button(layout, shown, "isomend.check")
    if shown.checked == context.active_object.name:
        draw_text(layout, shown.verdict)
        for defect in shown.defects:
            name = defect.kind.replace("_", " ")
            layout.operator("isomend.select_defects", text=f"Select {name}: {defect.count}").kind = defect.kind
    if at.SIGMA in context.active_object.data.attributes or expected_error.is_shown(context):
        layout.operator("isomend.show_error", depress=expected_error.is_shown(context))


def draw_properties(layout, shown, names):
    """The controls of these settings."""
    for name in names:
        layout.prop(shown, name)


def draw_button(layout, shown, operator):
    """The button of an operator, which runs it with the settings of the panel."""
    own, fills = BUTTONS[operator]
    button = layout.operator(operator)
    for name in [*own(), *(settings.common() if fills else ())]:
        setattr(button, name, getattr(shown, name))
    if operator == "isomend.fill" and shown.scope != "SELECTED":
        button.bridge = False  # Its control is hidden.


def draw_text(layout, text):
    """A text in lines."""
    for line in textwrap.wrap(text, WIDTH):
        layout.label(text=line)


def draw_menu(menu, context):
    """The entries in the menus *Clean Up*: the operators that change the mesh, with the settings of the panel. Restoring and fairing
    need selected faces, so they are shown in edit mode only."""
    menu.layout.separator()
    for operator in BUTTONS:
        if context.mode == "EDIT_MESH" or operator not in ("isomend.restore", "isomend.fair"):
            draw_button(menu.layout, context.scene.isomend, operator)


CLASSES = (ISOMEND_UL_holes, ISOMEND_PT_panel)
# The menus with entries: Mesh > Clean Up in edit mode, Object > Clean Up in object mode.
MENUS = ("VIEW3D_MT_edit_mesh_clean", "VIEW3D_MT_object_cleanup")


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    for name in MENUS:
        getattr(bpy.types, name).append(draw_menu)


def unregister():
    for name in MENUS:
        getattr(bpy.types, name).remove(draw_menu)
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
