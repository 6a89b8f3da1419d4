"""Meshes of trimesh, pyvista, meshio and Open3D as arrays, and back. Types are recognised by their attributes, so that none of these
packages is imported here."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from typing import Any, NamedTuple

from isomend._carried import REPORT, copied
from isomend._errors import MeshError, MeshTypeError
from isomend._volume import Volume

# Name of the face values that hold the index of a face's meshio block during the work.
BLOCK = "isomend_block"


class Adapted(NamedTuple):
    """A mesh of another package as arrays.

    ``back`` makes a mesh of the same type from the result, its values of vertices and its report. Results hand out read-only arrays, but
    the mesh belongs to the caller: all its arrays are copies."""

    vertices: Any
    faces: Any
    point_data: dict[str, Any]
    cell_data: dict[str, Any]
    back: Callable[[Any, dict[str, Any], dict[str, Any]], Any]

    def model(self, make: Callable[..., Any]) -> Any:
        """The model of the arrays; ``make`` is the class of models."""
        return make(self.vertices, self.faces, point_data=self.point_data, cell_data=self.cell_data)


def model_of_other(mesh: Any, make: Callable[..., Any]) -> Any:
    """The model of vertices and faces as a pair, or of a mesh of another package; ``make`` is the class of models. A `MeshTypeError` if the
    mesh is none of these."""
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return make(*mesh)
    if isinstance(mesh, (tuple, list)) or type(mesh).__module__ == "numpy":
        raise MeshTypeError(
            "faces are missing: these are vertices alone; give both, as in isomend.fill(vertices, faces), or in place of a mesh as a pair, "
            "as in isomend.compare((vertices, faces), other)"
        )
    return adapted(mesh).model(make)


def adapted(mesh: Any) -> Adapted:
    """Adapts a mesh of another package, recognised by its attributes. A `MeshTypeError` if it is of none of the known types."""

    def has(*names: str) -> bool:
        return all(hasattr(mesh, name) for name in names)

    if isinstance(mesh, Volume):
        raise MeshTypeError("this is a volume, not a mesh; isomend.surface(volume) extracts its surface")
    if has("vertices", "faces", "vertex_attributes", "face_attributes"):
        return _trimesh(mesh)
    if has("points", "is_all_triangles", "n_strips", "point_data", "cell_data", "triangulate"):
        return _pyvista(mesh)
    if has("points", "cells", "point_data", "cell_data", "extract_surface"):
        raise MeshTypeError(
            f"{type(mesh).__qualname__} can have cells other than polygons; extract its surface first: mesh.extract_surface()"
        )
    if has("points", "cells", "point_data", "cell_data"):
        return _meshio(mesh)
    if has("vertices", "triangles", "vertex_colors", "triangle_normals"):
        return _open3d(mesh)
    if has("geometry", "graph"):
        raise MeshTypeError("a scene holds several meshes; give one mesh, as scene.to_mesh() makes it, or isomend.read(path)")
    kind = f"{type(mesh).__module__}.{type(mesh).__qualname__}"
    raise MeshTypeError(
        f"{kind} is no mesh of trimesh, pyvista, meshio or Open3D, and no path, model or result; give its vertices and faces as arrays"
    )


def is_single(value: Any) -> bool:
    """Whether a value is one mesh or result, or is meant as one, rather than as several in a list: results and scenes can be iterated too."""
    return any(hasattr(value, name) for name in ("vertices", "vertex_attributes", "point_data", "vertex_colors", "geometry", "dtype"))


def is_pair(value: Any) -> bool:
    """Whether a value is vertices and faces, rather than two meshes: two arrays, or two lists of rows of three numbers."""
    return isinstance(value, (tuple, list)) and len(value) == 2 and all(map(_is_table, value))


def _is_table(value: Any) -> bool:
    if isinstance(value, (tuple, list)):
        row = value[0] if value else ()
        return hasattr(row, "__len__") and len(row) == 3 and all(hasattr(number, "__float__") for number in row)
    return hasattr(value, "dtype")


def _trimesh(mesh: Any) -> Adapted:
    points, cells = dict(mesh.vertex_attributes), dict(mesh.face_attributes)
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    if kind == "vertex":
        points["vertex_colors"] = visual.vertex_colors
    elif kind == "face":
        cells["face_colors"] = visual.face_colors
    elif kind == "texture" and getattr(visual, "uv", None) is not None:
        points["uv"] = visual.uv

    def back(mended: Any, named: dict[str, Any], report: dict[str, Any]) -> Any:
        cells = copied(mended.cell_data)
        colours = {
            "vertex_colors": named.pop("vertex_colors", None) if kind == "vertex" else None,
            "face_colors": cells.pop("face_colors", None) if kind == "face" else None,
        }
        cells["isomend_patch"] = mended.is_patch.copy()
        out = type(mesh)(
            vertices=mended.vertices.copy(), faces=mended.faces.copy(), vertex_attributes=named, face_attributes=cells,
            metadata=dict(mesh.metadata) | {REPORT: json.dumps(report)}, process=False, validate=False,
            **{name: values for name, values in colours.items() if values is not None},
        )  # fmt: skip
        if kind == "texture" and "uv" in named:
            uv = out.vertex_attributes.pop("uv")
            visual_type: Any = type(visual)
            out.visual = visual_type(uv=uv, material=visual.material)
        return out

    return Adapted(mesh.vertices, mesh.faces, points, cells, back)


def _pyvista(mesh: Any) -> Adapted:
    import numpy as np

    whole, faces = triangles_of(mesh)
    if whole.n_cells != len(faces):
        raise MeshError("the mesh has lines, vertex cells or strips beside its faces; remove them, or extract the surface first")
    if len(faces) == 0:
        raise MeshError("the mesh has no faces; there is nothing to fill")
    points, cells = _kept_types(whole.point_data), _kept_types(whole.cell_data)

    def back(mended: Any, named: dict[str, Any], report: dict[str, Any]) -> Any:
        rows = np.column_stack([np.full(len(mended.faces), 3), mended.faces])
        out = type(mesh)(_rounded(mended.vertices, np.asarray(whole.points).dtype), rows.ravel())
        for name, values in named.items():
            out.point_data[name] = values
        for name, values in copied(mended.cell_data).items():
            out.cell_data[name] = values
        for name, values in mesh.field_data.items():
            out.field_data[name] = values
        out.cell_data["isomend_patch"] = mended.is_patch.astype(np.uint8)
        out.field_data[REPORT] = [json.dumps(report)]
        if whole.active_scalars_name in out.array_names:
            side = whole.active_scalars_info.association.name.lower()
            out.set_active_scalars(whole.active_scalars_name, preference=side)
        return out

    return Adapted(whole.points, faces, points, cells, back)


def triangles_of(mesh: Any) -> tuple[Any, Any]:
    """The pyvista mesh with its polygons cut into triangles, and its faces (n, 3). A `MeshError` if some cannot be cut."""
    import numpy as np

    whole = mesh if mesh.is_all_triangles else mesh.triangulate()
    # Not `regular_faces`: it fails if the mesh has lines or vertex cells beside the faces.
    faces = np.asarray(whole.faces)
    if faces.size % 4 or np.any(faces[::4] != 3):
        raise MeshError("the mesh has faces that cannot be cut into triangles; call triangulate() on it and check its faces")
    return whole, faces.reshape(-1, 4)[:, 1:]


def _kept_types(data: Any) -> dict[str, Any]:
    """The arrays that can be continued on patches: numbers and truth values. Others, such as text, are dropped."""
    import numpy as np

    arrays = {str(name): np.asarray(data[name]) for name in data.keys()}  # noqa: SIM118
    return {name: array for name, array in arrays.items() if array.dtype.kind in "biuf"}


def _rounded(vertices: Any, dtype: Any) -> Any:
    """A copy of vertices in the mesh's own float type. Kept vertices came from this type, so they do not change."""
    return vertices.astype(dtype if dtype.kind == "f" else vertices.dtype)


def _meshio(mesh: Any) -> Adapted:
    import numpy as np

    blocks = list(mesh.cells)
    other = sorted({block.type for block in blocks} - {"triangle"})
    if other or not blocks:
        what = ", ".join(other) or "none"
        raise MeshError(f"the mesh must have triangles only, but has cells of these types: {what}; triangulate or remove them")
    points = np.asarray(mesh.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.column_stack([points, np.zeros(len(points), points.dtype)])
    faces = np.concatenate([block.data for block in blocks])
    cells = _kept_types({name: np.concatenate(list(values)) for name, values in mesh.cell_data.items()})
    # A repair removes faces, so kept faces carry the index of their block with them.
    cells[BLOCK] = np.repeat(np.arange(len(blocks)), [len(block.data) for block in blocks])

    def back(mended: Any, named: dict[str, Any], report: dict[str, Any]) -> Any:
        data = dict(mended.cell_data)
        kept = int(np.count_nonzero(~mended.is_patch))
        # Parts of split faces come after the faces that stay, so faces of a block are brought together.
        block = data.pop(BLOCK, np.zeros(0))[:kept]
        order = np.concatenate([np.argsort(block, kind="stable"), np.arange(kept, len(mended.faces))])
        ends = np.searchsorted(block[order[:kept]], np.arange(len(blocks)), side="right")
        triangles = mended.faces.astype(blocks[0].data.dtype)[order]
        data["isomend_patch"] = mended.is_patch.astype(np.uint8)
        data = {name: values[order] for name, values in data.items()}
        return type(mesh)(
            _rounded(mended.vertices, points.dtype),
            [("triangle", part) for part in np.split(triangles, ends)],
            point_data=named,
            cell_data={name: np.split(values, ends) for name, values in data.items()},
            field_data=mesh.field_data,
            info=dict(mesh.info or {}) | {REPORT: json.dumps(report)},
        )

    return Adapted(points, faces, _kept_types(mesh.point_data), cells, back)


def _open3d(mesh: Any) -> Adapted:
    import numpy as np

    names = {"vertex_normals": "normals", "vertex_colors": "colors"}
    points = {own: np.asarray(getattr(mesh, theirs)) for theirs, own in names.items()}
    points = {name: values for name, values in points.items() if len(values)}

    def back(mended: Any, named: dict[str, Any], report: dict[str, Any]) -> Any:
        open3d = sys.modules["open3d"]
        out = type(mesh)(
            open3d.utility.Vector3dVector(mended.vertices.copy()),
            open3d.utility.Vector3iVector(mended.faces.astype(np.int32)),
        )
        for theirs, own in names.items():
            if own in named:
                setattr(out, theirs, open3d.utility.Vector3dVector(named[own]))
        if mesh.has_triangle_normals():
            out.compute_triangle_normals()
        return out

    return Adapted(np.asarray(mesh.vertices), np.asarray(mesh.triangles), points, {}, back)
