"""Reads and writes attributes of Blender meshes as arrays; says which of them isomend continues on patches."""

from contextlib import contextmanager

import bmesh
import bpy
import numpy as np

# For each type of attribute: the property with its values, the number of components, and the components' type.
KINDS = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    # The stored values, not linear ones, so that 8-bit values are restored exactly.
    "BYTE_COLOR": ("color_srgb", 4, np.float32),
    "INT32_2D": ("value", 2, np.int32),
    "QUATERNION": ("value", 4, np.float32),
    "FLOAT4X4": ("value", 16, np.float32),
}

# Types whose values are continued smoothly. Values of other types are copied from the nearest vertex of the rim.
SMOOTH = ("FLOAT", "FLOAT_VECTOR", "FLOAT2", "FLOAT_COLOR", "BYTE_COLOR")

PATCH = "isomend_patch"
# The vertex group of patches must not have the name of the attribute: Blender 5.2 drops an attribute with the name of a vertex group when a
# bmesh is written to its mesh, also on leaving edit mode.
PATCH_GROUP = "isomend patch"
SIGMA = "isomend_sigma"


@contextmanager
def readable(item):
    """The mesh of an object with the values of all its attributes. In edit mode it is a copy, which is removed after the `with` block:
    attributes of a mesh in edit mode have no values in Python."""
    if item.mode != "EDIT":
        yield item.data
        return
    mesh = bpy.data.meshes.new("isomend")
    try:
        bmesh.from_edit_mesh(item.data).to_mesh(mesh)
        yield mesh
    finally:
        bpy.data.meshes.remove(mesh)


def carried(mesh, domain):
    """Names of a mesh's attributes of a domain, without positions, Blender's internal attributes, isomend's own attributes, and types that
    are not in `KINDS`."""
    return [
        a.name
        for a in mesh.attributes
        if a.domain == domain
        and a.data_type in KINDS
        and not a.name.startswith(".")
        and a.name not in ("position", PATCH, SIGMA)
    ]


def values_of(mesh, name):
    """Values of an attribute, (n, components)."""
    attribute = mesh.attributes[name]
    prop, components, dtype = KINDS[attribute.data_type]
    values = np.zeros(len(attribute.data) * components, dtype)
    attribute.data.foreach_get(prop, values)
    return values.reshape(-1, components)


def set_values(mesh, name, values):
    """Sets all values of an attribute, (n, components)."""
    attribute = mesh.attributes[name]
    prop, _, dtype = KINDS[attribute.data_type]
    attribute.data.foreach_set(prop, np.ascontiguousarray(values, dtype).reshape(-1))


def numbers(collection, prop, components=1, dtype=np.int32):
    """A property of all elements of a mesh, (n,) or (n, components)."""
    values = np.zeros(len(collection) * components, dtype)
    collection.foreach_get(prop, values)
    return values if components == 1 else values.reshape(-1, components)


def attribute_named(mesh, name, data_type, domain):
    """The attribute with this name, type and domain. It is made if it is missing, and replaced if it has another type or domain."""
    attribute = mesh.attributes.get(name)
    if attribute is not None and (attribute.data_type, attribute.domain) != (data_type, domain):
        mesh.attributes.remove(attribute)
        attribute = None
    return attribute or mesh.attributes.new(name, data_type, domain)


def marks_of(mesh, name, data_type, domain, count):
    """Values (count,) of an attribute that an earlier run of isomend has made; zeros if there is none."""
    attribute = mesh.attributes.get(name)
    if attribute is None or (attribute.data_type, attribute.domain) != (data_type, domain):
        return np.zeros(count, KINDS[data_type][2])
    return values_of(mesh, name)[:, 0]


def weights_of(mesh, groups):
    """Weights of the first `groups` vertex groups of a mesh, (vertices, groups)."""
    weights = np.zeros((len(mesh.vertices), groups), np.float32)
    if groups:
        for vertex in mesh.vertices:
            for element in vertex.groups:
                if element.group < groups:
                    weights[vertex.index, element.group] = element.weight
    return weights
