"""Objects that are refused: other objects than meshes, and meshes whose shape keys or modifiers would break if faces are added or removed."""

# Modifiers that store data for each vertex or face: if these change, the modifiers stop working, or the data is lost.
BOUND = {
    "MULTIRES": "keeps displacements for each face; apply it first",
    "MESH_CACHE": "reads positions of the vertices from a file; apply or remove it first",
    "MESH_SEQUENCE_CACHE": "reads positions of the vertices from a file; apply or remove it first",
    "SURFACE_DEFORM": "is bound to the vertices; unbind or apply it first",
    "MESH_DEFORM": "is bound to the vertices; unbind or apply it first",
    "LAPLACIANDEFORM": "is bound to the vertices; unbind or apply it first",
    "CORRECTIVE_SMOOTH": "is bound to the vertices; unbind or apply it first",
    "CLOTH": "has a simulation of the vertices; apply or remove it first",
    "SOFT_BODY": "has a simulation of the vertices; apply or remove it first",
    "PARTICLE_SYSTEM": "has particles that belong to faces; remove it first",
}

# Modifiers that close or replace the mesh that is seen, so that its holes are not the holes of the mesh without them.
CLOSING = {
    "MIRROR": "closes the border in its mirror plane, which would be filled as a hole; apply it, or disable it in the viewport, first",
    "SKIN": "makes a surface from edges, which isomend does not see; apply it, or disable it in the viewport, first",
    "REMESH": "shows another mesh than the one that would be filled; apply it, or disable it in the viewport, first",
}


class OnMesh:
    """Base class of the operators that need an active mesh."""

    @classmethod
    def poll(cls, context):
        return context.active_object is not None and context.active_object.type == "MESH"


def is_bound(modifier):
    """Whether a modifier stores data for each vertex or face. Some modifiers do so only after their button "Bind" was pressed."""
    if modifier.type not in BOUND:
        return False
    flag = getattr(modifier, "is_bound", None)
    if flag is None:
        flag = getattr(modifier, "is_bind", None)
    return True if flag is None else bool(flag)


def reason_against(active):
    """Why an object cannot be mended, as a sentence for the user; none if it can."""
    if active is None or active.type != "MESH":
        return "The active object is not a mesh"
    mesh = active.data
    if not active.is_editable or not mesh.is_editable:
        return f"'{active.name}' is linked from another file; make it local first"
    if mesh.shape_keys:
        return f"'{active.name}' has shape keys, which have no positions for new vertices; remove or apply them first"
    for modifier in active.modifiers:
        if is_bound(modifier):
            return f"The modifier '{modifier.name}' {BOUND[modifier.type]}"
        if modifier.show_viewport and modifier.type in CLOSING:
            return f"The modifier '{modifier.name}' {CLOSING[modifier.type]}"
    if len(mesh.polygons) == 0:
        return f"'{active.name}' has no faces"
    return None
