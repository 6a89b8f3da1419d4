"""Conversion of ComfyUI's meshes, which are batches of tensors; each mesh of a batch is processed separately. Tensors need the methods
`detach`, `cpu`, `numpy` and `new_tensor`, as torch's have; torch itself is not imported."""

import copy

import numpy as np

# Attributes of ComfyUI's vertices that are continued on patches, with the names under which isomend knows their role.
CONTINUED = {"uvs": "uv", "vertex_colors": "colors"}
# Attributes that are removed from the result, since others can compute them from the new mesh.
COMPUTED = ("normals", "tangents")


def array_of(tensor):
    """A tensor as an array."""
    return tensor.detach().cpu().numpy()


def each(mesh):
    """Yields each mesh of a batch, without padding: vertices (n, 3), faces (m, 3), and the values of vertices to continue, by name."""
    vertices, faces = array_of(mesh.vertices), array_of(mesh.faces)
    counts = [getattr(mesh, name, None) for name in ("vertex_counts", "face_counts")]
    n, m = (None if count is None else array_of(count).astype(int) for count in counts)
    values = {name: getattr(mesh, name, None) for name in CONTINUED}
    for i in range(len(vertices)):
        to, end = (len(vertices[i]) if n is None else n[i]), (len(faces[i]) if m is None else m[i])
        own = {CONTINUED[name]: array_of(given)[i, :to] for name, given in values.items() if given is not None}
        yield vertices[i, :to].astype(np.float64), faces[i, :end].astype(np.int64), own


def mended(mesh, mend):
    """Applies `mend(model)` to each mesh of a batch. Returns a new batch, with unchanged textures and materials, and the list of results.

    The input is not changed. Meshes of different sizes are padded with zeros; `vertex_counts` and `face_counts` have their sizes."""
    import isomend

    results = [mend(isomend.Model(points, faces, point_data=own)) for points, faces, own in each(mesh)]
    out = copy.copy(mesh)
    n, m = [len(r.vertices) for r in results], [len(r.faces) for r in results]
    out.vertices = mesh.vertices.new_tensor(padded([r.vertices for r in results], array_of(mesh.vertices).dtype))
    out.faces = mesh.faces.new_tensor(padded([r.faces for r in results], array_of(mesh.faces).dtype))
    for name, key in CONTINUED.items():
        before = getattr(mesh, name, None)
        if before is not None:
            rows = [r.point_data[key].reshape(len(r.vertices), -1) for r in results]
            setattr(out, name, before.new_tensor(padded(rows, array_of(before).dtype)))
    for name in COMPUTED:
        if getattr(mesh, name, None) is not None:
            setattr(out, name, None)
    if len(set(n)) > 1 or len(set(m)) > 1:
        out.vertex_counts, out.face_counts = mesh.faces.new_tensor(np.array(n)), mesh.faces.new_tensor(np.array(m))
    elif hasattr(out, "vertex_counts"):
        out.vertex_counts = out.face_counts = None
    return out, results


def padded(rows, dtype):
    """Stacks arrays of different lengths and pads the shorter ones with zeros. Unknown values (NaN) become zero too."""
    whole = np.zeros((len(rows), max(map(len, rows)), rows[0].shape[1]), dtype)
    for place, row in zip(whole, rows):
        place[: len(row)] = np.nan_to_num(row)
    return whole
