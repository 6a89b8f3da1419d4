"""Keeps hooks and vertex parents at their vertices when the vertices of a mesh are numbered anew."""

import bpy
import numpy as np

from . import attributes as at

# For each type of vertex parent how many vertices of the parent it names.
PARENTS = {"VERTEX": 1, "VERTEX_3": 3}


class Followers:
    """The hooks of the objects with a mesh, and the objects whose parents are vertices of it, with the vertices that they name."""

    def __init__(self, mesh):
        users = {item for item in bpy.data.objects if item.data == mesh}
        hooks = [modifier for item in users for modifier in item.modifiers if modifier.type == "HOOK"]
        self.mesh = mesh
        self.hooks = [(hook, list(hook.vertex_indices)) for hook in hooks if len(hook.vertex_indices)]
        children = [item for item in bpy.data.objects if item.parent in users and item.parent_type in PARENTS]
        self.children = [(child, list(child.parent_vertices)[: PARENTS[child.parent_type]]) for child in children]
        self.places = at.numbers(mesh.vertices, "co", 3, np.float32)

    def follow(self, needed):
        """Sets the numbers of the vertices after all vertices but those `needed`, bool for each, were removed. Hooks let go of removed
        vertices, as in Blender. A parent's removed vertex is replaced by the nearest vertex, so that the child stays near its place."""
        numbers = np.where(needed, np.cumsum(needed) - 1, -1)
        for hook, named in self.hooks:
            hook.vertex_indices_set([int(numbers[n]) for n in named if numbers[n] >= 0])
        places = at.numbers(self.mesh.vertices, "co", 3, np.float32)
        for child, named in self.children:
            found = [int(numbers[n]) if n < len(numbers) else -1 for n in named]
            for i, n in enumerate(named):
                if found[i] < 0 and n < len(numbers):
                    distances = np.linalg.norm(places - self.places[n], axis=1)
                    distances[[taken for taken in found if taken >= 0]] = np.inf
                    found[i] = int(np.argmin(distances))
            for i, number in enumerate(found):
                if number >= 0:
                    child.parent_vertices[i] = number
