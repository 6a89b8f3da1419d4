"""Reads a Blender mesh into arrays for isomend: triangles, selections, attributes."""

import hashlib

import numpy as np

from . import attributes as at

# Scales along the axes count as equal if they differ by no more than this part of the largest.
SAME_SCALE = 1e-5

# Names of values that hold the index of each vertex and triangle: in the result they say where vertices and faces come from.
VERTEX, TRIANGLE = "isomend_vertex_number", "isomend_triangle_number"


class Taken:
    """The mesh of an object: its polygons as triangles, selections, and attributes. Blender's data is read only when this is made, so the
    arrays can be used in other threads.

    Attributes:
        scale: Length of a unit of the arrays' coordinates in the scene, in Blender units.
        digest: `digest_of` the mesh.
        vertices: float64 (n, 3). The mesh's own coordinates; if the object is scaled unequally along its axes, stretched as in the scene.
        triangles: int64 (m, 3), vertices of the triangles of all polygons.
        loops: (m, 3), the loops (face corners) of these triangles.
        polygons: (m,), the polygons of these triangles.
        chosen_vertices, chosen_edges, chosen_faces: bool, for each vertex, edge and polygon whether it is selected.
        earlier_patch: bool, for each polygon whether it belongs to a patch of an earlier run.
        earlier_errors: For each vertex its expected error from an earlier run, in Blender units.
        of_points, of_corners, of_faces: Attributes of vertices, loops and polygons, by name.
        a_loop: (n,), one loop of each vertex, -1 for vertices of no polygon.
    """

    def __init__(self, item):
        self.stretch, self.scale = stretch_of(item.matrix_world)
        with at.readable(item) as mesh:
            self._read_elements(mesh)
            self._read_values(mesh, len(item.vertex_groups))

    def _read_elements(self, mesh):
        mesh.calc_loop_triangles()
        self.digest = digest_of(mesh)
        self.vertices = at.numbers(mesh.vertices, "co", 3, np.float32).astype(np.float64)
        if self.stretch is not None:
            self.vertices = self.vertices @ self.stretch
        self.triangles = at.numbers(mesh.loop_triangles, "vertices", 3).astype(np.int64)
        self.loops = at.numbers(mesh.loop_triangles, "loops", 3)
        self.polygons = at.numbers(mesh.loop_triangles, "polygon_index")
        self.edges = at.numbers(mesh.edges, "vertices", 2)
        self.chosen_vertices = at.numbers(mesh.vertices, "select", dtype=bool)
        self.chosen_edges = at.numbers(mesh.edges, "select", dtype=bool)
        self.chosen_faces = at.numbers(mesh.polygons, "select", dtype=bool)
        self.sizes = (len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons))

    def _read_values(self, mesh, groups):
        self.of_points = {name: at.values_of(mesh, name) for name in at.carried(mesh, "POINT")}
        self.of_corners = {name: at.values_of(mesh, name) for name in at.carried(mesh, "CORNER")}
        self.of_faces = {name: at.values_of(mesh, name) for name in at.carried(mesh, "FACE")}
        # Without this attribute all faces are smooth. Faces that bmesh makes are flat, which adds it.
        self.of_faces.setdefault("sharp_face", np.zeros((len(mesh.polygons), 1), bool))
        self.earlier_patch = at.marks_of(mesh, at.PATCH, "BOOLEAN", "FACE", len(mesh.polygons))
        self.earlier_errors = at.marks_of(mesh, at.SIGMA, "FLOAT", "POINT", len(mesh.vertices))
        self.weights = at.weights_of(mesh, groups)
        is_smooth = {a.name: a.data_type in at.SMOOTH for a in mesh.attributes}
        self.smooth_points = [name for name in self.of_points if is_smooth[name]]
        self.smooth_corners = [name for name in self.of_corners if is_smooth[name]]
        # If the loops of a vertex have different values, as at a UV seam, the values of one loop are continued.
        self.a_loop = np.full(self.sizes[0], -1, np.int64)
        self.a_loop[self.triangles.ravel()] = self.loops.ravel()

    def model(self):
        """The mesh as isomend's model, with indices and all values that are continued smoothly on patches."""
        import isomend

        values = {VERTEX: np.arange(self.sizes[0])}
        values |= {f"point {name}": self.of_points[name] for name in self.smooth_points}
        for name in self.smooth_corners:
            values[f"corner {name}"] = self.of_corners[name][self.a_loop]
        if self.weights.shape[1]:
            values["weights"] = self.weights
        numbers = {TRIANGLE: np.arange(len(self.triangles))}
        return isomend.Model(self.vertices, self.triangles, point_data=values, cell_data=numbers)

    def marks(self):
        """bool (m,): for each triangle whether its polygon is selected."""
        return self.chosen_faces[self.polygons]

    def chosen_holes(self, holes):
        """Numbers of the holes with a selected edge in their rim; if there are none, with a selected vertex."""
        pairs = np.sort(self.edges[self.chosen_edges].astype(np.int64), axis=1)
        keys = pairs[:, 0] * self.sizes[0] + pairs[:, 1]

        def by_edges(hole):
            ends = np.sort(np.column_stack([hole.rim, np.roll(hole.rim, -1)]), axis=1)
            return np.isin(ends[:, 0] * self.sizes[0] + ends[:, 1], keys).any()

        found = [hole.id for hole in holes if by_edges(hole)]
        return found or [hole.id for hole in holes if self.chosen_vertices[hole.rim].any()]

    def own_coordinates(self, vertices):
        """Converts coordinates of the arrays to the mesh's own coordinates."""
        if self.stretch is not None:
            vertices = vertices @ np.linalg.inv(self.stretch)
        return vertices.astype(np.float32)

    def length(self, value):
        """A length of the scene in the units of the arrays; none for 0, which stands for the default."""
        return value / self.scale if value > 0 else None

    def like(self, mirror):
        """The option `like` for a setting of `mirror`: none, a plane that is searched, or the plane through the object's origin that is
        perpendicular to an axis of the object."""
        if mirror in ("none", "search"):
            return None if mirror == "none" else "mirror"
        normal = np.eye(3)["xyz".index(mirror)]
        if self.stretch is not None:
            normal = np.linalg.solve(self.stretch, normal)
        return "mirror:" + ",".join(repr(float(value)) for value in (0, 0, 0, *normal))


def digest_of(mesh):
    """A hash of a mesh's positions and polygons and of its number of edges, as text. The same elements in another order give another hash.
    It takes about 0.3 s for a million vertices."""
    digest = hashlib.blake2b(digest_size=16)
    digest.update(repr((len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons))).encode())
    digest.update(at.numbers(mesh.vertices, "co", 3, np.float32).tobytes())
    digest.update(at.numbers(mesh.loops, "vertex_index").tobytes())
    digest.update(at.numbers(mesh.polygons, "loop_start").tobytes())
    return digest.hexdigest()


def stretch_of(matrix):
    """How an object's matrix stretches its mesh: (None, scale) if the scale is the same along all axes, else (3 × 3 matrix for rows of
    coordinates, 1). A `ValueError` if a scale is zero."""
    linear = np.array([list(row)[:3] for row in matrix][:3], np.float64)
    _, scales, axes = np.linalg.svd(linear)
    if scales[0] - scales[2] <= SAME_SCALE * scales[0]:
        return None, float(scales[0]) or 1.0
    if scales[2] <= SAME_SCALE * scales[0]:
        raise ValueError("The object's scale is zero along an axis; set another scale first")
    return axes.T @ np.diag(scales) @ axes, 1.0
