"""Meshes for the tests, and arrays of Blender's meshes."""

import numpy as np


def globe(rings=24, sectors=48, without=(), quads=True):
    """Vertices and faces of a unit ball of quadrilaterals, with triangles at the poles. `without` names (ring, sector) that are left out."""
    angles = np.linspace(0, np.pi, rings + 1)[1:-1]
    turns = np.arange(sectors) * 2 * np.pi / sectors
    ring = [(np.sin(a) * np.cos(t), np.sin(a) * np.sin(t), np.cos(a)) for a in angles for t in turns]
    vertices = np.array([*ring, (0, 0, 1), (0, 0, -1)], np.float32)
    top, bottom = len(vertices) - 2, len(vertices) - 1
    faces = []
    for s in range(sectors):
        n = (s + 1) % sectors
        faces.append((top, s, n))
        for r in range(rings - 2):
            if (r, s) in without:
                continue
            a, b, c, d = r * sectors + s, (r + 1) * sectors + s, (r + 1) * sectors + n, r * sectors + n
            faces += [(a, b, c, d)] if quads else [(a, b, c), (a, c, d)]
        faces.append((bottom, (rings - 2) * sectors + n, (rings - 2) * sectors + s))
    return vertices, faces


def window(rings=range(8, 12), sectors=range(5, 10)):
    """Quadrilaterals of a globe that are left out."""
    return {(r, s) for r in rings for s in sectors}


def plane_with_holes(bpy, side, holes):
    """A wavy sheet of `side` × `side` quadrilaterals with square holes, `holes` × `holes` of them. Returns its object."""
    x, y = np.meshgrid(np.linspace(0, 10, side + 1), np.linspace(0, 10, side + 1), indexing="ij")
    z = 0.3 * np.sin(x) * np.cos(1.3 * y)
    vertices = np.stack([x, y, z], axis=2).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    step = side // holes
    inside = (abs(i % step - step // 2) < 3) & (abs(j % step - step // 2) < 3)
    a = (i * (side + 1) + j)[~inside]
    quads = np.column_stack([a, a + side + 1, a + side + 2, a + 1])
    used = np.unique(quads)
    number = np.full(len(vertices), -1)
    number[used] = np.arange(len(used))
    return added(bpy, vertices[used], number[quads])


def added(bpy, vertices, faces, name="mesh"):
    """An object with a mesh, active and selected."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    item = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.objects.active = item
    item.select_set(True)
    return item


def select(item, inside):
    """Selects the polygons whose centre a function accepts, with their edges and vertices, and nothing else."""
    mesh = item.data
    polygons = [p for p in mesh.polygons if inside(p.center)]
    vertices = {v for p in polygons for v in p.vertices}
    edges = {key for p in polygons for key in p.edge_keys}
    mesh.polygons.foreach_set("select", [inside(p.center) for p in mesh.polygons])
    mesh.vertices.foreach_set("select", [v.index in vertices for v in mesh.vertices])
    mesh.edges.foreach_set("select", [e.key in edges for e in mesh.edges])


def positions(mesh):
    """float32 (n, 3)."""
    values = np.zeros(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", values)
    return values.reshape(-1, 3)


def polygons(mesh):
    """Vertex numbers of each polygon."""
    return [tuple(p.vertices) for p in mesh.polygons]


def values(mesh, name, prop, components=1):
    """Values of an attribute as an array."""
    data = mesh.attributes[name].data
    out = np.zeros(len(data) * components, np.float32)
    data.foreach_get(prop, out)
    return out.reshape(-1, components)


def is_closed(mesh):
    """Whether every edge is in two polygons."""
    count = {}
    for polygon in mesh.polygons:
        for key in polygon.edge_keys:
            count[key] = count.get(key, 0) + 1
    return set(count.values()) == {2}


def write_ply(path, vertices, triangles):
    """A binary PLY file of 32-bit floats."""
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(len(triangles), [("n", "u1"), ("v", "<i4", 3)])
    rows["n"], rows["v"] = 3, triangles
    path.write_bytes(head.encode() + np.ascontiguousarray(vertices, "<f4").tobytes() + rows.tobytes())


def triangles_of(mesh):
    """Triangles of all polygons as Blender cuts them."""
    mesh.calc_loop_triangles()
    out = np.zeros(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", out)
    return out.reshape(-1, 3)
