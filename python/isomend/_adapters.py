"""Adapters for meshes of trimesh, pyvista, meshio and Open3D. Types are recognised by their attributes, so that none of these packages is
imported here."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from isomend._carried import REPORT, reported, values_of_vertices
from isomend._errors import MeshError, ParameterError
from isomend._mesh import Mended, Model
from isomend._volume import Volume

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask

# Name of the face values that hold the index of a face's meshio block during the work.
BLOCK = "isomend_block"

Work = Callable[[Model], Mended]
# A mesh of another package as a model, and a function that makes a mesh of the same type from the result, its values of vertices and
# its report.
Adapted = tuple[Model, Callable[[Mended, "dict[str, Any]", "dict[str, Any]"], Any]]


def fill_mesh(mesh: Any, *, return_report: bool = False, **options: Unpack[FillOptions]) -> Any:
    """Fills holes of a mesh of another package; the same type comes back, with its data continued on the patches.

    Args:
        mesh: ``trimesh.Trimesh``, ``pyvista.PolyData``, ``meshio.Mesh`` or Open3D's ``TriangleMesh``. It is not changed.
        return_report: Whether to return the report beside the mesh; see :attr:`isomend.Mended.report`.
        options: As for :func:`isomend.fill`.

    Returns:
        A new mesh, or with ``return_report`` the mesh and the report. If the type has named values of faces, ``isomend_patch`` marks
        the faces of patches, and if it has named values of vertices, ``isomend_sigma`` is their expected error (0 for the mesh's own, -1
        where it is unknown). New vertices to which texture coordinates cannot be continued have the coordinates of the nearest vertex of the
        rim in one chart of the texture, which a note of the report says. The report is stored as JSON under ``isomend_report`` in trimesh's
        ``metadata``, pyvista's ``field_data`` and meshio's ``info``; Open3D's meshes cannot store it.

    Raises:
        TypeError: The type is none of these.
        MeshError: The mesh has cells other than triangles, or is not valid.
    """
    return mend_mesh("fill", mesh, lambda model: model.fill(**options), return_report)


def repair_mesh(mesh: Any, *, return_report: bool = False, **options: Unpack[RepairOptions]) -> Any:
    """Repairs a mesh of another package: closed, manifold, oriented, without self-intersections; the same type comes back.

    Args:
        mesh: As for :func:`fill_mesh`.
        return_report: Whether to return the report beside the mesh.
        options: As for :func:`isomend.repair`.

    Returns:
        As for :func:`fill_mesh`.

    Raises:
        TypeError, MeshError: As for :func:`fill_mesh`.
    """
    return mend_mesh("repair", mesh, lambda model: model.repair(**options), return_report)


def restore_mesh(mesh: Any, mark: Mask, *, return_report: bool = False, **options: Unpack[RestoreOptions]) -> Any:
    """Cuts a marked region out of a mesh of another package and fills it; the same type comes back.

    Args:
        mesh: As for :func:`fill_mesh`.
        mark: The faces to replace, as for :func:`isomend.restore`: bool, one for each triangle, or the indices of triangles, or a mask
            as a dictionary.
        return_report: Whether to return the report beside the mesh.
        options: As for :func:`isomend.restore`.

    Returns:
        As for :func:`fill_mesh`.

    Raises:
        EmptyMaskError: No face is marked.
        TypeError, MeshError: As for :func:`fill_mesh`.
    """
    return mend_mesh("restore", mesh, lambda model: model.restore(mark, **options), return_report)


def fair_mesh(
    mesh: Any, mark: Mask | None = None, *, return_report: bool = False, **options: Unpack[FairOptions]
) -> Any:
    """Fairs a mesh of another package by Willmore flow; the same type comes back.

    If a closed mesh is faired as a whole, all vertices and faces are new, and the data of vertices and faces is lost.

    Args:
        mesh: As for :func:`fill_mesh`.
        mark: The faces to fair, as for :func:`isomend.fair`; by default all.
        return_report: Whether to return the report beside the mesh.
        options: As for :func:`isomend.fair`.

    Returns:
        As for :func:`fill_mesh`.

    Raises:
        EmptyMaskError, TypeError, MeshError: As for :func:`restore_mesh`.
    """
    return mend_mesh("fair", mesh, lambda model: model.fair(mark, **options), return_report)


def mend_mesh(command: str, mesh: Any, work: Work, return_report: bool = False) -> Any:
    """A mesh of the same type as `mesh` with the result of `work`; with `return_report` the mesh and the report."""
    _refuse_own(command, mesh)
    model, back = _adapted(mesh)
    mended = work(model)
    points, remarks = values_of_vertices(mended)
    report = reported(mended, remarks)
    out = back(mended, points, report)
    return (out, report) if return_report else out


def as_model(mesh: Any) -> Model:
    """Converts a mesh to a :class:`isomend.Model`, with the data of its vertices and faces.

    Args:
        mesh: ``trimesh.Trimesh``, ``pyvista.PolyData``, ``meshio.Mesh``, Open3D's ``TriangleMesh``, vertices and faces as a pair, the
            path of a file, or a :class:`isomend.Model` or :class:`isomend.Mended`.

    Returns:
        The model; ``mesh`` itself if it is one.

    Raises:
        TypeError: The type is none of these.
        MeshError: The mesh has cells other than triangles.
        FileError: The file cannot be read.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> isomend.as_model((vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])).check().reasons
    ['1 hole is open']
    """
    if isinstance(mesh, Model):
        return mesh
    if isinstance(mesh, Mended):
        return mesh.model()
    if isinstance(mesh, (str, os.PathLike)):
        return Model._read(os.fspath(mesh))
    if isinstance(mesh, (tuple, list)) and len(mesh) == 2:
        return Model(*mesh)
    if isinstance(mesh, (tuple, list)) or type(mesh).__module__ == "numpy":
        raise TypeError(
            "faces are missing: these are vertices alone; give both, as in isomend.fill(vertices, faces), or in place of a mesh as a pair, "
            "as in isomend.compare((vertices, faces), other)"
        )
    return _adapted(mesh)[0]


def model_of(
    vertices: Any,
    faces: ArrayLike | None,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
) -> Model:
    """The model of vertices and faces, or of a mesh in place of the vertices."""
    if faces is not None:
        return Model(vertices, faces, point_data=point_data, cell_data=cell_data)
    if point_data is not None or cell_data is not None:
        raise ParameterError(
            "point_data and cell_data belong to vertices and faces; a mesh or a file has values of its own: give its arrays, "
            "as in isomend.fill(mesh.vertices, mesh.faces, point_data=...)"
        )
    return as_model(vertices)


def is_mesh(value: Any) -> bool:
    """Whether a value is meant as a mesh for :func:`as_model`, rather than as an array of vertices."""
    if isinstance(value, (Model, Mended, str, os.PathLike)):
        return True
    if isinstance(value, (tuple, list)):
        return len(value) == 2
    return any(hasattr(value, name) for name in ("vertex_attributes", "point_data", "vertex_colors"))


def _adapted(mesh: Any) -> Adapted:
    """Adapts a mesh of another package, recognised by its attributes. A `TypeError` if it is of none of the known types."""

    def has(*names: str) -> bool:
        return all(hasattr(mesh, name) for name in names)

    if isinstance(mesh, Volume):
        raise TypeError("this is a volume, not a mesh; isomend.surface(volume) extracts its surface")
    if has("vertices", "faces", "vertex_attributes", "face_attributes"):
        return _trimesh(mesh)
    if has("points", "is_all_triangles", "n_strips", "point_data", "cell_data", "triangulate"):
        return _pyvista(mesh)
    if has("points", "cells", "point_data", "cell_data", "extract_surface"):
        raise TypeError(
            f"{type(mesh).__qualname__} can have cells other than polygons; extract its surface first: mesh.extract_surface()"
        )
    if has("points", "cells", "point_data", "cell_data"):
        return _meshio(mesh)
    if has("vertices", "triangles", "vertex_colors", "triangle_normals"):
        return _open3d(mesh)
    if has("geometry", "graph"):
        raise TypeError("a scene holds several meshes; give one mesh, as scene.to_mesh() makes it, or isomend.read(path)")
    kind = f"{type(mesh).__module__}.{type(mesh).__qualname__}"
    raise TypeError(
        f"{kind} is no mesh of trimesh, pyvista, meshio or Open3D; pass its arrays to isomend.fill(vertices, faces)"
    )


def _refuse_own(command: str, mesh: Any) -> None:
    """A `TypeError` if a mesh is none of another package, but one that the functions on models and files take."""
    own = "a path" if isinstance(mesh, (str, os.PathLike)) else "a model" if isinstance(mesh, (Model, Mended)) else None
    if own is not None:
        name = "path" if own == "a path" else "model"
        raise TypeError(f"{command}_mesh takes meshes of other packages, but this is {own}: call isomend.{command}({name}, ...)")
    if isinstance(mesh, (tuple, list)) or type(mesh).__module__ == "numpy":
        raise TypeError(f"{command}_mesh takes meshes of other packages, but these are arrays: call isomend.{command}(vertices, faces, ...)")


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

    def back(mended: Mended, named: dict[str, Any], report: dict[str, Any]) -> Any:
        cells = dict(mended.cell_data)
        colours = {
            "vertex_colors": named.pop("vertex_colors", None) if kind == "vertex" else None,
            "face_colors": cells.pop("face_colors", None) if kind == "face" else None,
        }
        cells["isomend_patch"] = mended.is_patch
        out = type(mesh)(
            vertices=mended.vertices, faces=mended.faces, vertex_attributes=named, face_attributes=cells,
            metadata=dict(mesh.metadata) | {REPORT: json.dumps(report)}, process=False, validate=False,
            **{name: values for name, values in colours.items() if values is not None},
        )  # fmt: skip
        if kind == "texture" and "uv" in named:
            uv = out.vertex_attributes.pop("uv")
            visual_type: Any = type(visual)
            out.visual = visual_type(uv=uv, material=visual.material)
        return out

    return Model(mesh.vertices, mesh.faces, point_data=points, cell_data=cells), back


def _pyvista(mesh: Any) -> Adapted:
    import numpy as np

    whole, faces = triangles_of(mesh)
    if whole.n_cells != len(faces):
        raise MeshError("the mesh has lines, vertex cells or strips beside its faces; remove them, or extract the surface first")
    if len(faces) == 0:
        raise MeshError("the mesh has no faces; there is nothing to fill")
    points, cells = _kept_types(whole.point_data), _kept_types(whole.cell_data)

    def back(mended: Mended, named: dict[str, Any], report: dict[str, Any]) -> Any:
        rows = np.column_stack([np.full(len(mended.faces), 3), mended.faces])
        out = type(mesh)(_rounded(mended.vertices, np.asarray(whole.points).dtype), rows.ravel())
        for name, values in named.items():
            out.point_data[name] = values
        for name, values in mended.cell_data.items():
            out.cell_data[name] = values
        for name, values in mesh.field_data.items():
            out.field_data[name] = values
        out.cell_data["isomend_patch"] = mended.is_patch.astype(np.uint8)
        out.field_data[REPORT] = [json.dumps(report)]
        if whole.active_scalars_name in out.array_names:
            side = whole.active_scalars_info.association.name.lower()
            out.set_active_scalars(whole.active_scalars_name, preference=side)
        return out

    return Model(whole.points, faces, point_data=points, cell_data=cells), back


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
    """Vertices in the mesh's own float type. Kept vertices came from this type, so they do not change."""
    return vertices.astype(dtype) if dtype.kind == "f" else vertices


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

    def back(mended: Mended, named: dict[str, Any], report: dict[str, Any]) -> Any:
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

    return Model(points, faces, point_data=_kept_types(mesh.point_data), cell_data=cells), back


def _open3d(mesh: Any) -> Adapted:
    import numpy as np

    names = {"vertex_normals": "normals", "vertex_colors": "colors"}
    points = {own: np.asarray(getattr(mesh, theirs)) for theirs, own in names.items()}
    points = {name: values for name, values in points.items() if len(values)}

    def back(mended: Mended, named: dict[str, Any], report: dict[str, Any]) -> Any:
        open3d = sys.modules["open3d"]
        out = type(mesh)(
            open3d.utility.Vector3dVector(mended.vertices),
            open3d.utility.Vector3iVector(mended.faces.astype(np.int32)),
        )
        for theirs, own in names.items():
            if own in named:
                setattr(out, theirs, open3d.utility.Vector3dVector(named[own]))
        if mesh.has_triangle_normals():
            out.compute_triangle_normals()
        return out

    return Model(np.asarray(mesh.vertices), np.asarray(mesh.triangles), point_data=points), back
