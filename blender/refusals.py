"""Which objects are refused, with the reason: meshes whose shape keys or modifiers would break with new or removed faces."""

# Modifiers that store data for each vertex or face of the mesh as it is: with other vertices they stop working, or the data is lost.
BOUND = {
    "MULTIRES": "keeps displacements for each face; apply it first",
    "MESH_CACHE": "reads a position for each vertex from a file; apply or remove it first",
    "MESH_SEQUENCE_CACHE": "reads a position for each vertex from a file; apply or remove it first",
    "SURFACE_DEFORM": "is bound to the vertices; unbind or apply it first",
    "MESH_DEFORM": "is bound to the vertices; unbind or apply it first",
    "LAPLACIANDEFORM": "is bound to the vertices; unbind or apply it first",
    "CORRECTIVE_SMOOTH": "is bound to the vertices; unbind or apply it first",
    "CLOTH": "has a simulation of the vertices; apply or remove it first",
    "SOFT_BODY": "has a simulation of the vertices; apply or remove it first",
    "PARTICLE_SYSTEM": "has particles that belong to faces; remove it first",
}

# Modifiers that close or cover the mesh's own border, which the mesh without them has open.
CLOSING = {
    "MIRROR": "closes the border in its mirror plane, which would be filled as a hole; apply it, or switch it off in the viewport, first",
    "SKIN": "makes a surface of edges, which isomend does not see; apply it, or switch it off in the viewport, first",
    "REMESH": "replaces the mesh, so that its holes are not those that are seen; apply it, or switch it off in the viewport, first",
}


def is_bound(modifier):
    """Whether a modifier keeps data of the vertices as they are. Some do so only after their button "Bind" was pressed."""
    if modifier.type not in BOUND:
        return False
    flag = getattr(modifier, "is_bound", None)
    if flag is None:
        flag = getattr(modifier, "is_bind", None)
    return True if flag is None else bool(flag)


def reason_against(active):
    """Why an object cannot be mended, as a sentence; none if it can."""
    if active is None or active.type != "MESH":
        return "The active object is no mesh"
    mesh = active.data
    if not active.is_editable or not mesh.is_editable:
        return f"'{active.name}' is linked from another file; make it local first"
    if mesh.shape_keys:
        return f"'{active.name}' has shape keys, in which new vertices would have no place; remove or apply them first"
    for modifier in active.modifiers:
        if is_bound(modifier):
            return f"The modifier '{modifier.name}' {BOUND[modifier.type]}"
        if modifier.show_viewport and modifier.type in CLOSING:
            return f"The modifier '{modifier.name}' {CLOSING[modifier.type]}"
    if len(mesh.polygons) == 0:
        return f"'{active.name}' has no faces"
    return None
