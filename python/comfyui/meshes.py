"""ComfyUI's meshes: batches of tensors. Each mesh of a batch goes through isomend by itself. Tensors are those of any package that has
`detach`, `cpu`, `numpy` and `new_tensor`, as torch's; torch itself is not imported."""

import copy

import numpy as np

# Values of vertices that isomend continues on patches, by the names that tell it what they are.
CONTINUED = {"uvs": "uv", "vertex_colors": "colors"}
# Values of vertices that are computed anew by whoever needs them.
COMPUTED = ("normals", "tangents")


def array_of(tensor):
    """A tensor as an array."""
    return tensor.detach().cpu().numpy()


def each(mesh):
    """The meshes of a batch: vertices, faces, and the values of vertices that are continued."""
    vertices, faces = array_of(mesh.vertices), array_of(mesh.faces)
    counts = [getattr(mesh, name, None) for name in ("vertex_counts", "face_counts")]
    n, m = (None if count is None else array_of(count).astype(int) for count in counts)
    values = {name: getattr(mesh, name, None) for name in CONTINUED}
    for i in range(len(vertices)):
        to, end = (len(vertices[i]) if n is None else n[i]), (len(faces[i]) if m is None else m[i])
        own = {CONTINUED[name]: array_of(given)[i, :to] for name, given in values.items() if given is not None}
        yield vertices[i, :to].astype(np.float64), faces[i, :end].astype(np.int64), own


def mended(mesh, mend):
    """The same batch after `mend(model)` of each mesh, with textures and materials as they were; and what `mend` returned of each.

    The input stays as it is. Meshes of different sizes are padded with zeros, and their sizes are in `vertex_counts` and `face_counts`."""
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
    """Arrays of different lengths as one, the ends of the shorter ones filled with zeros. Unknown values are zero too."""
    whole = np.zeros((len(rows), max(map(len, rows)), rows[0].shape[1]), dtype)
    for place, row in zip(whole, rows):
        place[: len(row)] = np.nan_to_num(row)
    return whole
