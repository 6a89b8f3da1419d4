"""Settings of the panel, which are stored with the scene. Lengths are in the units of the scene."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

ENERGIES = [
    ("willmore", "Willmore", "Least bending: patches continue spheres, saddles and free forms"),
    ("curvature-variation", "Curvature variation", "Least variation of curvature: patches continue cylinders, cones and ellipsoids"),
]
SCOPES = [
    ("SELECTED", "Selected", "Holes with a selected edge in their rim; if there are none, holes with a selected vertex"),
    ("ALL", "All", "All holes, but not the outer border of an open sheet"),
]
TABS = [
    ("FILL", "Fill", "Fill holes"),
    ("RESTORE", "Restore", "Replace or smooth selected faces"),
    ("REPAIR", "Repair", "Repair the whole mesh"),
    ("CHECK", "Check", "Say whether the mesh is watertight, and select its defects"),
]
MIRRORS = [
    ("none", "None", "Patches continue their surroundings"),
    ("search", "Find plane", "The plane of symmetry is searched"),
    ("x", "X", "The plane through the object's origin, perpendicular to its X axis"),
    ("y", "Y", "The plane through the object's origin, perpendicular to its Y axis"),
    ("z", "Z", "The plane through the object's origin, perpendicular to its Z axis"),
]
SHARP = [
    ("auto", "Continue", "Continue sharp edges that end at a hole across it, if the faces round the hole agree with that"),
    ("off", "Off", "Patches are smooth"),
]


def common():
    """Properties that the operators have in common, as annotations of a class."""
    return {
        "mirror": EnumProperty(
            name="Mirror",
            description="Fill with the mirrored shape of the other side, where it predicts the faces around the hole",
            items=MIRRORS,
        ),
        "energy": EnumProperty(name="Energy", description="Energy that patches minimise", items=ENERGIES),
        "sharp": EnumProperty(name="Sharp edges", description="What to do with sharp edges that end at a hole", items=SHARP),
        "voxel": FloatProperty(
            name="Voxel size", description="Grid spacing of the level set; 0 chooses it for each hole", min=0, unit="LENGTH"
        ),
    }


def of_fill():
    """Properties of filling."""
    return {
        "scope": EnumProperty(name="Holes", description="Which holes are filled", items=SCOPES, default="ALL"),
        "max_diameter": FloatProperty(
            name="Largest diameter", description="Leave wider holes open; 0 for no limit", min=0, unit="LENGTH"
        ),
        "flat": BoolProperty(name="Flat caps", description="Close by nearly flat caps: necks, bases and mouths of vessels"),
        "bridge": BoolProperty(
            name="Bridge", description="Fill the selected holes in one region, with a bridge between them, whatever their distance"
        ),
    }


def of_restore():
    """Properties of restoring."""
    return {
        "keep_shape": FloatProperty(
            name="Keep shape",
            description="0 continues the surroundings only; towards 1 the shape that is cut out is kept, without its noise",
            min=0, max=1,
        )
    }  # fmt: skip


def of_fair():
    """Properties of fairing."""
    return {
        "strength": FloatProperty(
            name="Strength", description="Width of the features to remove; 0 for eight mean edges", min=0, unit="LENGTH"
        )
    }


def of_repair():
    """Properties of repairing."""
    return {
        "close_borders": BoolProperty(
            name="Close borders", description="Also close outer borders of open sheets, by caps or a wall along the sheet"
        ),
        "keep_holes": BoolProperty(name="Keep holes", description="Leave holes of the mesh open; holes that the repair makes are filled"),
        "weld": FloatProperty(
            name="Weld", description="Merge boundary vertices that are no farther apart; 0 merges coinciding ones", min=0, unit="LENGTH"
        ),
        "debris": FloatProperty(
            name="Debris", description="Remove components with less than this part of the largest component's area", min=0, max=1
        ),
    }


def of_check():
    """Properties of checking."""
    return {
        "min_wall": FloatProperty(
            name="Thinnest wall", description="Walls thinner than this are defects; 0 for no limit", min=0, unit="LENGTH"
        )
    }  # fmt: skip


class IsomendHole(bpy.types.PropertyGroup):
    """A row of the list of holes; `rim` is a JSON list of vertex indices."""

    number: IntProperty()
    edges: IntProperty()
    diameter: FloatProperty(unit="LENGTH")
    is_outer_boundary: BoolProperty()
    rim: StringProperty()


class IsomendDefect(bpy.types.PropertyGroup):
    """All defects of one kind, in the list of defects; `polygons` is a JSON list of polygon indices."""

    kind: StringProperty()
    count: IntProperty()
    polygons: StringProperty()


class IsomendSettings(bpy.types.PropertyGroup):
    """The settings, and the last lists of holes and defects. All of it is saved with the scene; so progress is not kept here."""

    __annotations__ = {**common(), **of_fill(), **of_restore(), **of_fair(), **of_repair(), **of_check()}

    tab: EnumProperty(name="Tab", description="The controls that the panel shows", items=TABS)

    # The list of holes, its object, and the hash of the mesh when the holes were found.
    holes: CollectionProperty(type=IsomendHole)
    holes_of: StringProperty()
    holes_digest: StringProperty()
    active_hole: IntProperty(update=lambda settings, context: selected_in_list(settings, context))

    # The last check: its object (empty before the first check), the hash of the mesh, the answer, and the defects found.
    checked: StringProperty()
    checked_digest: StringProperty()
    verdict: StringProperty()
    defects: CollectionProperty(type=IsomendDefect)


def selected_in_list(settings, context):
    """Selects the rim of the hole that is active in the list."""
    if 0 <= settings.active_hole < len(settings.holes) and context.view_layer.objects.active is not None:
        bpy.ops.isomend.select_hole(index=settings.active_hole)


CLASSES = (IsomendHole, IsomendDefect, IsomendSettings)


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.isomend = PointerProperty(type=IsomendSettings)


def unregister():
    del bpy.types.Scene.isomend
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
