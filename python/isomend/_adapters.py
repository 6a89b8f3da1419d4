"""Functions that take meshes of trimesh, pyvista, meshio and Open3D, and meshes of all kinds as models."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from isomend._carried import reported, values_of_vertices
from isomend._errors import MeshTypeError, ParameterError
from isomend._foreign import adapted
from isomend._mesh import Mended, Model, model_from

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask

Work = Callable[[Model], Mended]


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
        MeshTypeError: The type is none of these.
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
        MeshTypeError, MeshError: As for :func:`fill_mesh`.
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
        MeshTypeError, MeshError: As for :func:`fill_mesh`.
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
        EmptyMaskError, MeshTypeError, MeshError: As for :func:`restore_mesh`.
    """
    return mend_mesh("fair", mesh, lambda model: model.fair(mark, **options), return_report)


def mend_mesh(command: str, mesh: Any, work: Work, return_report: bool = False) -> Any:
    """A mesh of the same type as `mesh` with the result of `work`; with `return_report` the mesh and the report."""
    _refuse_own(command, mesh)
    own = adapted(mesh)
    mended = work(own.model(Model))
    points, remarks = values_of_vertices(mended)
    report = reported(mended, remarks)
    out = own.back(mended, points, report)
    return (out, report) if return_report else out


def as_model(mesh: Any) -> Model:
    """Converts a mesh to a :class:`isomend.Model`, with the data of its vertices and faces.

    Args:
        mesh: ``trimesh.Trimesh``, ``pyvista.PolyData``, ``meshio.Mesh``, Open3D's ``TriangleMesh``, vertices and faces as a pair, the
            path of a file, or a :class:`isomend.Model` or :class:`isomend.Mended`.

    Returns:
        The model; ``mesh`` itself if it is one.

    Raises:
        MeshTypeError: The type is none of these.
        MeshError: The mesh has cells other than triangles.
        FileError: The file cannot be read.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> isomend.as_model((vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])).check().reasons
    ['1 hole is open']
    """
    if isinstance(mesh, (str, os.PathLike)):
        return Model._read(os.fspath(mesh))
    return model_from(mesh)


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


def _refuse_own(command: str, mesh: Any) -> None:
    """A `MeshTypeError` if a mesh is none of another package, but one that the functions on models and files take."""
    own = "a path" if isinstance(mesh, (str, os.PathLike)) else "a model" if isinstance(mesh, (Model, Mended)) else None
    if own is not None:
        name = "path" if own == "a path" else "model"
        raise MeshTypeError(f"{command}_mesh takes meshes of other packages, but this is {own}: call isomend.{command}({name}, ...)")
    if isinstance(mesh, (tuple, list)) or type(mesh).__module__ == "numpy":
        raise MeshTypeError(f"{command}_mesh takes meshes of other packages, but these are arrays: call isomend.{command}(vertices, faces, ...)")
