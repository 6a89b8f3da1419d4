"""Writes a result of isomend into a Blender mesh: kept elements keep all their attributes, new elements are added after them."""

from contextlib import contextmanager
from dataclasses import dataclass

import bmesh
import bpy
import numpy as np

from . import attributes as at
from .followers import Followers
from .taken import TRIANGLE, VERTEX

# Value of the attribute where there is no estimate of the error, as in files that isomend writes.
UNKNOWN = -1.0


@dataclass
class Change:
    """The differences between a result and the Blender mesh from which it was made.

    Attributes:
        sources: (n,), for each vertex of the result its vertex in the mesh; for a new vertex the nearest vertex of the rim.
        new: Indices of the result's vertices to add: vertices at new positions, and copies of kept vertices.
        removed: bool, for each polygon whether it is removed. Its remaining triangles are added again.
        turned: Indices of the polygons that are kept with reversed orientation.
        again: Indices of the result's faces to add again: triangles of removed polygons, or parts of these triangles.
        origins: (m,), for each face of the result that is not part of a patch the triangle of the mesh that it comes from.
        patch: Indices of the result's faces that are part of patches.
        needed: bool, for each vertex of the mesh whether it is kept: it is used by the result's faces, or belongs to no polygon.
    """

    sources: np.ndarray
    new: np.ndarray
    removed: np.ndarray
    turned: np.ndarray
    again: np.ndarray
    origins: np.ndarray
    patch: np.ndarray
    needed: np.ndarray


class NotGivenBack(Exception):
    """A result that cannot be written into the mesh; the message is the reason. The mesh is unchanged."""


def change_of(taken, mended):
    """The differences between a result and the mesh from which it was made. Raises `NotGivenBack` if no face is kept."""
    if mended.is_patch.all():
        raise NotGivenBack("every face would be replaced, and UV maps and attributes would be lost; select only a part of the faces")
    sources = mended.point_data[VERTEX].astype(np.int64)
    kept, used = own_vertices(taken, mended, sources)
    faces = mended.faces[~mended.is_patch]
    origins = mended.cell_data[TRIANGLE][: len(faces)].astype(np.int64)

    # A polygon stays if all its triangles are in the result, all in the same or all in the reversed orientation.
    own = np.where(kept[faces], sources[faces], -1)
    before = taken.triangles[origins]
    same, flipped = turns(own, before), turns(own, before[:, ::-1])
    polygons, count = taken.polygons[origins], len(taken.chosen_faces)
    whole = np.bincount(taken.polygons, minlength=count)
    is_same = np.bincount(polygons[same], minlength=count) == whole
    is_turned = ~is_same & (np.bincount(polygons[flipped], minlength=count) == whole)
    removed = ~(is_same | is_turned)

    needed = np.ones(len(taken.vertices), bool)
    needed[taken.triangles.ravel()] = False
    needed[sources[kept & used]] = True
    return Change(
        sources=sources, new=np.flatnonzero(used & ~kept), removed=removed, turned=np.flatnonzero(is_turned),
        again=np.flatnonzero(removed[polygons]), origins=origins, patch=np.flatnonzero(mended.is_patch), needed=needed,
    )  # fmt: skip


def own_vertices(taken, mended, sources):
    """For each vertex of a result whether it is kept (at the position of its source, and the first vertex with this source), and whether a
    face uses it."""
    first = np.zeros(len(sources), bool)
    first[np.unique(sources, return_index=True)[1]] = True
    used = np.zeros(len(sources), bool)
    used[mended.faces.ravel()] = True
    return first & np.all(mended.vertices == taken.vertices[sources], axis=1), used


def turns(a, b):
    """For each row of three indices whether `a` and `b` are equal up to rotation."""
    return np.any([np.all(a == np.roll(b, shift, axis=1), axis=1) for shift in range(3)], axis=0)


def give_back(item, taken, mended):
    """Writes a result into the object's mesh, in object mode. Returns the number of new vertices and of new faces. Raises `NotGivenBack` if
    the mesh cannot hold the result. The mesh is unchanged after any exception."""
    change = change_of(taken, mended)
    mesh = item.data
    number = (np.cumsum(change.needed) - 1)[change.sources]
    vertices, polygons = int(change.needed.sum()), int((~change.removed).sum())
    number[change.new] = vertices + np.arange(len(change.new))
    corners = number[mended.faces[np.concatenate([change.again, change.patch])]]
    refuse_duplicates(taken, change, corners)
    with all_or_nothing(item) as followers:
        rebuild(mesh, taken, change, taken.own_coordinates(mended.vertices[change.new]), corners)
        # New faces are triangles at the end, so their loops are the last.
        loops = len(mesh.loops) - corners.size
        fill_points(item, taken, mended, change, vertices)
        fill_corners(mesh, taken, mended, change, loops)
        fill_faces(mesh, taken, mended, change, polygons)
        mark(item, taken, mended, change, corners[len(change.again) :], vertices)
        followers.follow(change.needed)
        mesh.update()
    return len(change.new), len(change.patch)


@contextmanager
def all_or_nothing(item):
    """Restores an object's mesh, its vertex groups, hooks and vertex parents if an exception leaves the `with` block."""
    mesh, followers, groups = item.data, Followers(item.data), [group.name for group in item.vertex_groups]
    # Since a data block is added, Blender stores a whole undo step, also in edit mode: undo then takes back the vertex group, too.
    before = mesh.copy()
    try:
        yield followers
    except BaseException:
        overwrite(mesh, before)
        for group in [group for group in item.vertex_groups if group.name not in groups]:
            item.vertex_groups.remove(group)
        followers.follow(np.ones(len(mesh.vertices), bool))
        raise
    finally:
        bpy.data.meshes.remove(before)


def overwrite(mesh, other):
    """Replaces all elements and attributes of a mesh by the elements and attributes of another."""
    bm = bmesh.new()
    try:
        bm.from_mesh(other, face_normals=False, vertex_normals=False)
        bm.to_mesh(mesh)
    finally:
        bm.free()
    mesh.update()


def refuse_duplicates(taken, change, corners):
    """Raises `NotGivenBack` if a triangle to add has a vertex twice, or has the same vertices as another triangle to add or to keep, since
    Blender's meshes cannot hold these faces."""
    is_triangle = np.bincount(taken.polygons, minlength=len(taken.chosen_faces)) == 1
    staying = taken.triangles[(is_triangle & ~change.removed)[taken.polygons]]
    staying = np.sort((np.cumsum(change.needed) - 1)[staying], axis=1)
    adding = np.sort(corners, axis=1)
    if np.any(adding[:, 1:] == adding[:, :-1]):
        raise NotGivenBack("a new face would have the same vertex at two corners; nothing was changed")
    # Duplicate faces that the mesh has already are no reason to refuse.
    both = np.concatenate([np.unique(staying, axis=0), adding])
    if len(np.unique(both, axis=0)) < len(both):
        raise NotGivenBack("a new face would have the same vertices as another face, which Blender does not allow; nothing was changed")


def rebuild(mesh, taken, change, positions, corners):
    """Removes polygons and vertices, adds vertices and triangles after all others, and reverses polygons. Attributes of new elements are
    zero."""
    # With bmesh: `mesh.edges.add` of Blender 5.2 leaves values of attributes undefined, and fails on large meshes.
    if change.removed.any() or not change.needed.all() or len(corners):
        bm = bmesh.new()
        try:
            bm.from_mesh(mesh, face_normals=False, vertex_normals=False)
            if change.removed.any() or not change.needed.all():
                remove(bm, taken, change)
                # A bmesh would put new elements in the gaps of removed ones; its copy has no gaps, so that new elements come last.
                whole, bm = bm, bm.copy()
                whole.free()
            add(bm, positions, corners)
            bm.to_mesh(mesh)
        finally:
            bm.free()
    places = np.cumsum(~change.removed) - 1
    for polygon in places[change.turned]:
        mesh.polygons[int(polygon)].flip()


def remove(bm, taken, change):
    """Removes polygons, edges and vertices that are not kept from a bmesh."""
    # An edge is removed with its last polygon, unless a triangle that is added again uses it.
    again = taken.triangles[change.origins[change.again]]
    ends = np.sort(np.stack([again, np.roll(again, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    wanted = set(map(tuple, ends.tolist()))
    polygons, edges, vertices = bm.faces[:], bm.edges[:], bm.verts[:]
    loose = {edge for edge in edges if not edge.link_faces}
    for number in np.flatnonzero(change.removed):
        bm.faces.remove(polygons[number])
    for edge in edges:
        if not edge.link_faces and edge not in loose:
            if tuple(sorted(vertex.index for vertex in edge.verts)) not in wanted:
                bm.edges.remove(edge)
    for number in np.flatnonzero(~change.needed):
        bm.verts.remove(vertices[number])


def add(bm, positions, corners):
    """Adds vertices and triangles, with their missing edges, to a bmesh."""
    for position in positions.tolist():
        bm.verts.new(position)
    bm.verts.ensure_lookup_table()
    vertices = bm.verts[:]
    for a, b, c in corners.tolist():
        bm.faces.new((vertices[a], vertices[b], vertices[c]))


def append(mesh, name, first, values):
    """Sets the values of an attribute from the element `first` on, if the attribute still exists."""
    if name in mesh.attributes and len(values):
        everything = at.values_of(mesh, name)
        everything[first:] = values.reshape(-1, everything.shape[1])
        at.set_values(mesh, name, everything)


def fill_points(item, taken, mended, change, first):
    """Sets attributes and weights of vertex groups of new vertices: continued smoothly, or copied from the nearest vertex of the rim."""
    mesh, new = item.data, change.new
    for name, values in taken.of_points.items():
        key = f"point {name}"
        append(mesh, name, first, mended.point_data[key][new] if key in mended.point_data else values[change.sources[new]])
    if taken.weights.shape[1]:
        weights = mended.point_data["weights"].reshape(-1, taken.weights.shape[1])[new]
        for group in item.vertex_groups:
            if group.name == at.PATCH_GROUP:
                continue
            for vertex in np.flatnonzero(weights[:, group.index] > 0):
                group.add([first + int(vertex)], float(weights[vertex, group.index]), "REPLACE")


def fill_corners(mesh, taken, mended, change, first):
    """Sets attributes of the corners of added triangles: the values of the triangle that they come from; on patches continued smoothly, or
    copied from the nearest vertex of the rim."""
    loops, shares = corner_sources(taken, mended, change)
    main = np.take_along_axis(loops, np.argmax(shares, axis=1)[:, None], axis=1)[:, 0]
    patch = mended.faces[change.patch].ravel()
    for name, values in taken.of_corners.items():
        key = f"corner {name}"
        smooth = key in mended.point_data
        own = np.einsum("nk,nkc->nc", shares, values[loops]) if smooth else values[main]
        new = mended.point_data[key][patch] if smooth else values[taken.a_loop[change.sources[patch]]]
        append(mesh, name, first, np.concatenate([own, new.reshape(-1, values.shape[1])]))


def corner_sources(taken, mended, change):
    """For each corner of the triangles that are added again the three loops of the triangle of the mesh that contains it, and its
    barycentric coordinates in this triangle."""
    origins = np.repeat(change.origins[change.again], 3)
    places = mended.vertices[mended.faces[change.again].ravel()]
    before = taken.vertices[taken.triangles[origins]]
    a, b, c = before[:, 0], before[:, 1], before[:, 2]
    normal = np.cross(b - a, c - a)
    area = np.maximum(np.einsum("ij,ij->i", normal, normal), np.finfo(float).tiny)
    second = np.einsum("ij,ij->i", np.cross(places - a, c - a), normal) / area
    third = np.einsum("ij,ij->i", np.cross(b - a, places - a), normal) / area
    shares = np.clip(np.column_stack([1 - second - third, second, third]), 0, 1)
    shares /= np.maximum(shares.sum(axis=1, keepdims=True), np.finfo(float).tiny)
    # A corner at a vertex of the triangle gets exactly this vertex's values.
    at_corner = np.all(places[:, None] == before, axis=2)
    shares[at_corner.any(axis=1)] = at_corner[at_corner.any(axis=1)]
    return taken.loops[origins], shares


def fill_faces(mesh, taken, mended, change, first):
    """Sets attributes of added faces, such as materials: the values of the polygon that they come from; on patches the values of a polygon
    at the nearest vertex of the rim."""
    a_polygon = np.zeros(len(taken.vertices), np.int64)
    a_polygon[taken.triangles.ravel()] = np.repeat(taken.polygons, 3)
    kept = taken.polygons[change.origins]
    a_polygon[taken.triangles[change.origins].ravel()] = np.repeat(kept, 3)
    near = a_polygon[change.sources[mended.faces[change.patch, 0]]]
    sources = np.concatenate([kept[change.again], near])
    for name, values in taken.of_faces.items():
        append(mesh, name, first, values[sources])


def mark(item, taken, mended, change, corners, first):
    """Marks patches: the attribute of faces, the vertex group, expected errors, and the selection. Faces and vertices of earlier patches
    that are added again keep their marks; a new vertex that is in no patch of this result gets the marks of its source."""
    mesh = item.data
    start = len(mesh.polygons) - len(corners)
    marks = at.attribute_named(mesh, at.PATCH, "BOOLEAN", "FACE").name
    values = at.values_of(mesh, marks)
    values[start:] = True
    values[start - len(change.again) : start, 0] = taken.earlier_patch[taken.polygons[change.origins[change.again]]]
    at.set_values(mesh, marks, values)

    of_patch = np.unique(corners)
    inherits = ~np.isin(first + np.arange(len(change.new)), of_patch) | (mended.sigma[change.new] == 0)
    sources = change.sources[change.new]
    errors = at.attribute_named(mesh, at.SIGMA, "FLOAT", "POINT").name
    values = at.values_of(mesh, errors)
    new = mended.sigma[change.new] * taken.scale
    values[first:, 0] = np.where(inherits, taken.earlier_errors[sources], np.where(np.isfinite(new), new, UNKNOWN))
    at.set_values(mesh, errors, values)

    group = item.vertex_groups.get(at.PATCH_GROUP)
    if group is not None and group.index < taken.weights.shape[1]:
        weights = taken.weights[sources, group.index]
        for vertex in np.flatnonzero(inherits & (weights > 0)):
            group.add([first + int(vertex)], float(weights[vertex]), "REPLACE")
    group = group or item.vertex_groups.new(name=at.PATCH_GROUP)
    group.add(of_patch.tolist(), 1.0, "REPLACE")
    select(mesh, start, of_patch)


def select(mesh, start, vertices):
    """Selects the faces from `start` on with their edges, and these vertices, and nothing else."""
    chosen = np.zeros(len(mesh.vertices), bool)
    chosen[vertices] = True
    mesh.vertices.foreach_set("select", chosen)
    polygons = np.arange(len(mesh.polygons)) >= start
    mesh.polygons.foreach_set("select", polygons)
    edges = np.zeros(len(mesh.edges), bool)
    loops = at.numbers(mesh.loops, "edge_index")
    # The loops of the last polygons are the last loops.
    edges[loops[mesh.polygons[start].loop_start :] if start < len(mesh.polygons) else []] = True
    mesh.edges.foreach_set("select", edges)
