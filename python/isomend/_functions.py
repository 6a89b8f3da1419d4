"""The functions of isomend."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal

from isomend import _isomend, _params
from isomend._mesh import Inspection, Mended, Model

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Unpack

    from isomend._params import FairOptions, FillOptions, Mask, Progress, RestoreOptions, Voxel


def read(source: str | os.PathLike[str] | bytes, *, format: str | None = None) -> Model:
    """Reads a mesh with all that it carries: OBJ, PLY, STL, glTF, GLB, VTK legacy or VTP.

    Args:
        source: A path, or the bytes of a file.
        format: The format; by default it is told from the content, else from the extension.

    Raises:
        FileError: The file cannot be read, or its content is damaged or holds no surface.
    """
    if isinstance(source, bytes):
        return Model._of(_isomend.Model.read_bytes(source, format))
    return Model._of(_isomend.Model.read(os.fspath(source), format))


def inspect(vertices: ArrayLike, faces: ArrayLike) -> Inspection:
    """Finds the holes, pieces and defects of a mesh.

    Args:
        vertices: (n, 3), numbers of any type.
        faces: (m, 3), indices from 0.

    Raises:
        MeshError: The arrays are no mesh that can be measured.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> hole = isomend.inspect(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]]).holes[0]
    >>> hole.id, hole.edges, round(hole.length, 3), hole.is_border
    (1, 3, 4.243, True)
    """
    return Model(vertices, faces).inspect()


def fill(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    holes: Iterable[int] | None = None,
    keep_open: Iterable[int] = (),
    bridge: Iterable[Iterable[int]] = (),
    flat: Iterable[int] = (),
    max_diameter: float | None = None,
    voxel: Voxel = "auto",
    surface: Literal["stitched", "whole"] = "stitched",
    finish: Literal["auto", "willmore", "none"] = "auto",
    energy: Literal["willmore", "curvature-variation"] = "willmore",
    variant: Literal["I", "II", "gauss-newton"] = "gauss-newton",
    steps: int | None = None,
    time_step: float | None = None,
    edge_ratio: float | None = None,
    threads: int | None = None,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    progress: Progress | None = None,
    strict: bool = False,
) -> Mended:
    """Fills holes of a mesh. Its own vertices and faces stay bit for bit and in order; patches come after them.

    Args:
        vertices: (n, 3), numbers of any type whose values 64-bit floats hold.
        faces: (m, 3), indices from 0, counter-clockwise from outside.
        holes: Numbers of the holes to fill; by default all but outer borders of open sheets.
        keep_open: Numbers of holes to keep open.
        bridge: Groups of holes to fill together whatever their distance, such as ``[(1, 2)]``.
        flat: Holes to close by nearly flat caps instead of continuing the surface.
        max_diameter: Wider holes stay open; in the units of the mesh.
        voxel: Voxel size in the units of the mesh.
        surface: ``"whole"`` returns the level set round each hole alone.
        finish: How patches are finished on their own triangles.
        energy: What the patch makes small.
        variant: The scheme of the flow's steps.
        steps: Most steps on each grid.
        time_step: Time step in units of the voxel size to the fourth power; none aims at the steady state.
        edge_ratio: Length of the patch's edges over that of the edges round the hole; by default what suits the energy.
        threads: Number of threads, one per core by default. The result does not depend on it.
        point_data: Named values of vertices, (n,) or (n, k), which are continued on patches; see :class:`isomend.Model`.
        cell_data: Named values of faces, (m,) or (m, k).
        progress: Called as ``progress(part, done, all)``, at most 20 times a second, in the calling thread: the part of the work
            that is done, regions done, all regions. The run stops when it returns ``False`` or raises an exception.
        strict: Raise :class:`isomend.StrictError` unless every hole of more than four edges got a steady surface.

    Raises:
        MeshError: The arrays are no mesh that can be measured.
        HoleIdError: There is no hole of a number.
        ParameterError: A parameter makes no sense.
        Cancelled: ``progress`` returned ``False``.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> filled = isomend.fill(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]], holes=[1])
    >>> filled.faces.tolist()
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> filled.is_patch.tolist(), filled.report["outcomes"]["triangulated"]
    ([False, False, False, True], 1)
    """
    model = Model(vertices, faces, point_data=point_data, cell_data=cell_data)
    return model.fill(
        holes=holes, keep_open=keep_open, bridge=bridge, flat=flat, max_diameter=max_diameter, voxel=voxel, surface=surface,
        finish=finish, energy=energy, variant=variant, steps=steps, time_step=time_step, edge_ratio=edge_ratio,
        threads=threads, progress=progress, strict=strict,
    )  # fmt: skip


def restore(
    vertices: ArrayLike,
    faces: ArrayLike,
    mark: Mask,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[RestoreOptions],
) -> Mended:
    """Cuts a marked region out and fills it. All else stays bit for bit and in order.

    Args:
        vertices: (n, 3).
        faces: (m, 3).
        mark: bool (m,), or the numbers of the faces to replace; or a mask as a dictionary, such as
            ``{"balls": [[[0, 0, 1], 0.3]], "grow": 0.1}``.
        point_data: Named values of vertices.
        cell_data: Named values of faces.
        options: ``keep_shape`` from 0 to 1 keeps part of the shape that was there; ``keep_vertices`` keeps the numbers of
            vertices; those of :func:`fill` but for the choice of holes.

    Raises:
        EmptyMaskError: No face is marked.
        MeshError, ParameterError, Cancelled: As for :func:`fill`.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> isomend.restore(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], [False] * 4)
    Traceback (most recent call last):
    ...
    isomend._errors.EmptyMaskError: no region is marked
    """
    return Model(vertices, faces, point_data=point_data, cell_data=cell_data).restore(mark, **options)


def fair(
    vertices: ArrayLike,
    faces: ArrayLike,
    mark: Mask | None = None,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[FairOptions],
) -> Mended:
    """Lets a surface evolve by Willmore flow: noise and small features go, large forms stay.

    Args:
        vertices: (n, 3).
        faces: (m, 3).
        mark: What is faired, as for :func:`restore`; all of it by default.
        point_data: Named values of vertices.
        cell_data: Named values of faces.
        options: ``strength``, the width of the features that go, in the units of the mesh, or ``time``, that of the flow in
            length⁴; by default features narrower than eight mean edges go. ``voxel``, ``variant``, ``edge_ratio``,
            ``keep_vertices``, ``threads``, ``progress``, ``strict`` as for :func:`fill` and :func:`restore`.

    Raises:
        EmptyMaskError, MeshError, ParameterError, Cancelled: As for :func:`restore`.

    >>> import isomend
    >>> isomend.fair([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], strength=1.0, time=1.0)
    Traceback (most recent call last):
    ...
    isomend._errors.ParameterError: time and strength say the same in two ways; give one of them
    """
    return Model(vertices, faces, point_data=point_data, cell_data=cell_data).fair(mark, **options)


def signed_distance(
    points: ArrayLike, vertices: ArrayLike, faces: ArrayLike, *, threads: int | None = None
) -> NDArray[Any]:
    """Distances of points from a mesh, negative inside, exact up to rounding.

    Inside is where the magnitude of the generalized winding number exceeds one half, so that open meshes have an inside too.

    Args:
        points: (k, 3), in the units of the mesh.
        vertices: (n, 3).
        faces: (m, 3).
        threads: Number of threads, one per core by default.

    Returns:
        float64 (k,); NaN for points that are not finite.

    Raises:
        MeshError: The arrays are no mesh that can be measured.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> isomend.signed_distance([[0.125, 0.25, 0.25], [0, 0, 3]], vertices, faces).tolist()
    [-0.125, 2.0]
    """
    from isomend import _arrays

    if threads is not None:
        threads = _params.count("threads", threads)
    at = _arrays.points("points", points)
    return _isomend.signed_distance(at, _arrays.points("vertices", vertices), _arrays.faces(faces), threads)


def solve_task(task: bytes, *, threads: int | None = None) -> bytes:
    """Works on the task of a region; see :meth:`isomend.Inspection.each_task`. Returns the bytes of its patch.

    Raises:
        ParameterError: The bytes are no task.
    """
    if threads is not None:
        threads = _params.count("threads", threads)
    return _isomend.solve_task(task, threads)
