"""Functions on arrays and files: read, inspect, fill, repair, check, compare, convert, restore, fair, tasks of regions."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, NoReturn, Union, overload

from isomend import _isomend, _params
from isomend._adapters import as_model, is_mesh, model_of
from isomend._check import Verdict
from isomend._compare import Comparison, comparison
from isomend._errors import ParameterError
from isomend._mesh import Inspection, Mended, Model

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import Unpack

    from isomend._holes import CreaseEnd, Hole
    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask, Progress, Voxel

    Path = Union[str, os.PathLike[str]]


def read(source: str | os.PathLike[str] | bytes, *, format: str | None = None) -> Model:
    """Reads a mesh with its attributes from a file: OBJ, PLY, STL, glTF, GLB, VTK legacy, VTP, OFF, 3MF or USD.

    Args:
        source: A path, or the bytes of a file.
        format: Name of the format; by default it is recognised from the content, else from the extension.

    Returns:
        The mesh.

    Raises:
        FileError: The file cannot be read, its content is damaged, or it has no surface.
        ParameterError: There is no format of this name.
    """
    return Model._read(source if isinstance(source, bytes) else os.fspath(source), format)


@overload
def inspect(vertices: ArrayLike, faces: ArrayLike) -> Inspection: ...
@overload
def inspect(vertices: Any) -> Inspection: ...
def inspect(vertices: Any, faces: ArrayLike | None = None) -> Inspection:
    """Finds the holes, connected components and defects of a mesh.

    Args:
        vertices: (n, 3), numbers of any type. Or a mesh, without ``faces``, as for :func:`fill`.
        faces: (m, 3), indices from 0.

    Returns:
        The holes with their sizes, and the defects.

    Raises:
        MeshError: The arrays are no valid mesh.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> hole = isomend.inspect(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]]).holes[0]
    >>> hole.id, hole.edges, round(hole.length, 3), hole.is_outer_boundary
    (1, 3, 4.243, True)
    """
    return model_of(vertices, faces).inspect()


@overload
def fill(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[FillOptions],
) -> Mended: ...
@overload
def fill(vertices: Any, **options: Unpack[FillOptions]) -> Mended: ...
def fill(
    vertices: Any,
    faces: ArrayLike | None = None,
    *,
    holes: Iterable[int | Hole] | Literal['all'] | None = None,
    max_diameter: float | None = None,
    keep_open: Iterable[int | Hole] = (),
    bridge: Iterable[Iterable[int | Hole]] = (),
    flat: Iterable[int | Hole] = (),
    crease: Iterable[Iterable[int | CreaseEnd]] = (),
    flat_base: bool = False,
    base_offset: float | None = None,
    voxel: Voxel = "auto",
    energy: Literal["willmore", "curvature-variation"] = "willmore",
    finish: Literal["auto", "willmore", "none"] = "auto",
    sharp: Literal["auto", "off"] = "auto",
    like: Any = None,
    grain: bool = False,
    apart: bool = False,
    edge_ratio: float | None = None,
    threads: int | None = None,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    progress: Progress | None = None,
    strict: bool = False,
    **unknown: NoReturn,
) -> Mended:
    """Fills holes of a mesh. The mesh's own vertices and faces stay bit for bit and in order; patches come after them.

    Args:
        vertices: (n, 3), numbers of any type whose values 64-bit floats hold. Or a mesh, without ``faces``: a path, vertices and
            faces as a pair, a :class:`Model` or :class:`Mended`, or a mesh of trimesh, pyvista, meshio or Open3D.
        faces: (m, 3), indices from 0, counter-clockwise from outside.
        holes: Numbers of the holes to fill; with ``all``, the outer borders of open sheets stay open.
        max_diameter: Leave holes open that are wider than this, in the mesh's units.
        keep_open: Numbers of holes to leave open.
        bridge: Groups of holes to fill in one region each, whatever their distance. By default holes that are near each other
            share a region.
        flat: Numbers of holes to close by nearly flat caps instead of continuing the surface: necks, bases, mouths of vessels.
        crease: Pairs of crease ends between which a sharp edge is continued across their hole. By default the pairs that
            predict the faces round the hole.
        flat_base: Put open sheets such as terrains on a flat base, with straight walls down from their outer borders.
        base_offset: Distance from the lowest vertex of the sheet down to the base of ``flat_base``, in the mesh's units. By
            default the mean edge of the border.
        voxel: Voxel size in the mesh's units.
        energy: The bending energy that patches minimise.
        finish: How the patches of the level set are finished on their own triangles.
        sharp: Whether sharp edges of man-made shapes that end at a hole are continued across it.
        like: Fill holes with the shape of a counterpart: the mesh mirrored (``mirror``), or another mesh of the same kind of
            object. By default none.
        grain: Give patches the roughness of their surroundings, so that they do not look like plastic.
        apart: Close each rim by itself: join only rims that ``bridge`` names.
        edge_ratio: Length of the patch's edges relative to the edges round the hole. By default 0.7, 0.8 with ``finish`` none,
            0.45 with ``energy`` curvature-variation.
        threads: Number of threads, one per core by default. The result does not depend on it.
        point_data: Named values of vertices, (n,) or (n, k), which are continued on patches; see :class:`isomend.Model`.
        cell_data: Named values of faces, (m,) or (m, k).
        progress: Called as ``progress(part, done, regions)``, at most 20 times a second, in the calling thread: the part of the work
            that is done (0 to 1), regions done, all regions. The run stops if it returns ``False`` or raises an exception.
        strict: Raise :class:`isomend.StrictError` unless every hole of more than four edges that was to be filled is closed well: by a
            surface that continues its surroundings, or as asked for, that intersects nothing.

    Returns:
        The filled mesh, with a report.

    Raises:
        MeshError: The arrays are no valid mesh.
        HoleIdError: The mesh has no hole with a given number.
        ParameterError: A parameter is not valid.
        Cancelled: ``progress`` returned ``False``.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> filled = isomend.fill(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]], holes=[1])
    >>> filled.faces.tolist()
    [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> filled.is_patch.tolist(), filled.report["outcomes"]["rim_triangles"]
    ([False, False, False, True], 1)
    """
    model = model_of(vertices, faces, point_data, cell_data)
    return model.fill(
        holes=holes, max_diameter=max_diameter, keep_open=keep_open, bridge=bridge, flat=flat, crease=crease,
        flat_base=flat_base, base_offset=base_offset, voxel=voxel, energy=energy, finish=finish, sharp=sharp, like=like,
        grain=grain, apart=apart, edge_ratio=edge_ratio,
        threads=threads, progress=progress, strict=strict, **unknown,
    )  # fmt: skip


@overload
def repair(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[RepairOptions],
) -> Mended: ...
@overload
def repair(vertices: Any, **options: Unpack[RepairOptions]) -> Mended: ...
def repair(
    vertices: Any,
    faces: ArrayLike | None = None,
    *,
    weld: float | None = None,
    drop: Iterable[int] = (),
    debris: float | None = None,
    flat_base: bool = False,
    base_offset: float | None = None,
    drop_inside: bool = False,
    solid: bool = False,
    skip: Iterable[Literal["duplicates", "orientation", "non-manifold", "intersections", "holes"]] = (),
    drop_unused: bool = False,
    close_borders: bool = False,
    wall: float | None = None,
    min_wall: float | None = None,
    holes: Iterable[int | Hole] | Literal['all'] | None = None,
    max_diameter: float | None = None,
    keep_open: Iterable[int | Hole] = (),
    bridge: Iterable[Iterable[int | Hole]] = (),
    flat: Iterable[int | Hole] = (),
    crease: Iterable[Iterable[int | CreaseEnd]] = (),
    voxel: Voxel = "auto",
    energy: Literal["willmore", "curvature-variation"] = "willmore",
    finish: Literal["auto", "willmore", "none"] = "auto",
    sharp: Literal["auto", "off"] = "auto",
    like: Any = None,
    grain: bool = False,
    apart: bool = False,
    edge_ratio: float | None = None,
    threads: int | None = None,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    progress: Progress | None = None,
    strict: bool = False,
    **unknown: NoReturn,
) -> Mended:
    """Repairs a mesh: makes it closed, manifold, oriented and free of self-intersections, as far as possible.

    The steps, in this order: coinciding vertices are merged, degenerate and duplicate faces removed; faces are oriented consistently,
    closed components outward; surfaces are separated at non-manifold edges and vertices; faces that intersect others are cut out with
    a ring of faces round them; holes are filled as by :func:`fill`. Faces without a defect stay bit for bit and in order.
    ``complete`` of the result is the verdict of :func:`check` on it; ``report`` has the verdicts before and after.

    Args:
        vertices: (n, 3), numbers of any type whose values 64-bit floats hold. Or a mesh, without ``faces``, as for :func:`fill`.
        faces: (m, 3), indices from 0.
        weld: Merge boundary vertices that are no farther apart than this, in the mesh's units. Vertices at exactly the same
            position are always merged; by default also vertices of edges that coincide within the precision of the coordinates.
        drop: Numbers of components to remove, as ``isomend inspect -v`` and the page count them.
        debris: Remove components whose area is below this fraction, from 0 to 1, of the area of the largest one. By default all
            components stay.
        flat_base: Put open sheets such as terrains on a flat base, with straight walls down from their outer borders.
        base_offset: Distance from the lowest vertex of the sheet down to the base of ``flat_base``, in the mesh's units. By
            default the mean edge of the border.
        drop_inside: Remove components that lie wholly inside another one; cavities stay.
        solid: Make double-skinned bodies solid: remove inner skins that pinholes join to the outer one, and close the pinholes.
        skip: Steps of the repair to leave out: duplicates, orientation, non-manifold, intersections, holes. By default no step.
        drop_unused: Drop vertices that no face of the input uses.
        close_borders: Also close the outer borders of open sheets, which otherwise stay open.
        wall: Thickness of the walls that ``close_borders`` makes of open sheets that no flat cap closes, in the mesh's units.
            By default the mean edge of the component.
        min_wall: Report walls thinner than this as a defect, in the mesh's units. By default half a mean edge for walls that
            the repair makes; other walls are only reported.
        holes: Numbers of the holes to fill; with ``all``, the outer borders of open sheets stay open.
        max_diameter: Leave holes open that are wider than this, in the mesh's units.
        keep_open: Numbers of holes to leave open.
        bridge: Groups of holes to fill in one region each, whatever their distance. By default holes that are near each other
            share a region.
        flat: Numbers of holes to close by nearly flat caps instead of continuing the surface: necks, bases, mouths of vessels.
        crease: Pairs of crease ends between which a sharp edge is continued across their hole. By default the pairs that
            predict the faces round the hole.
        voxel, energy, finish, sharp, like, grain, apart, edge_ratio: How holes are filled, as for :func:`fill`.
        threads, point_data, cell_data, progress: As for :func:`fill`.
        strict: Raise :class:`isomend.StrictError` unless the result is sound and its holes are closed well.

    Returns:
        The repaired mesh, with a report.

    Raises:
        MeshError, ParameterError, Cancelled: As for :func:`fill`.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> turned = [[0, 1, 2], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> repaired = isomend.repair(vertices, turned)
    >>> repaired.complete, repaired.faces.tolist(), repaired.report["steps"]["reoriented_faces"]
    (True, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], 1)
    """
    model = model_of(vertices, faces, point_data, cell_data)
    return model.repair(
        weld=weld, drop=drop, debris=debris, flat_base=flat_base, base_offset=base_offset, drop_inside=drop_inside, solid=solid,
        skip=skip, drop_unused=drop_unused, close_borders=close_borders, wall=wall, min_wall=min_wall, holes=holes,
        max_diameter=max_diameter, keep_open=keep_open, bridge=bridge, flat=flat, crease=crease, voxel=voxel, energy=energy,
        finish=finish, sharp=sharp, like=like, grain=grain, apart=apart, edge_ratio=edge_ratio,
        threads=threads, progress=progress, strict=strict, **unknown,
    )  # fmt: skip


@overload
def check(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    thin: float | None = None,
    min_wall: float | None = None,
    debris: float = 0.01,
    threads: int | None = None,
) -> Verdict: ...
@overload
def check(
    vertices: Any,
    *,
    thin: float | None = None,
    min_wall: float | None = None,
    debris: float = 0.01,
    threads: int | None = None,
) -> Verdict: ...
def check(
    vertices: Any,
    faces: ArrayLike | None = None,
    *,
    thin: float | None = None,
    min_wall: float | None = None,
    debris: float = 0.01,
    threads: int | None = None,
    **unknown: NoReturn,
) -> Verdict:
    """Checks whether a mesh is watertight and can be printed, and finds its defects.

    Defects are boundary edges, non-manifold edges and vertices, faces oriented against their neighbours, closed components that are
    inside out, degenerate and duplicate faces, and faces that intersect or touch others. Vertices at exactly the same position count
    as one. Intersections are decided exactly.

    Args:
        vertices: (n, 3), numbers of any type whose values 64-bit floats hold. Or a mesh, without ``faces``, as for :func:`fill`.
        faces: (m, 3), indices from 0.
        thin: Also report parts thinner than this, in the mesh's units.
        min_wall: Report walls thinner than this as a defect, in the mesh's units. By default the thinnest and the mean wall are only
            reported.
        debris: Report components as debris if their area is below this fraction, from 0 to 1, of the area of the largest one.
        threads: Number of threads, one per core by default.

    Returns:
        A verdict, which is true if there is no defect; ``print(verdict)`` prints the same lines as ``isomend check``.

    Raises:
        MeshError: The arrays are no valid mesh.
        ParameterError: A parameter is not valid.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> bool(isomend.check(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
    True
    >>> verdict = isomend.check(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 3, 2]])
    >>> verdict
    <isomend.Verdict: watertight and printable: no, because 3 edges have faces oriented against each other>
    >>> verdict.watertight, verdict.oriented, verdict.defects["misoriented"].count
    (True, False, 3)
    """
    return model_of(vertices, faces).check(thin=thin, min_wall=min_wall, debris=debris, threads=threads, **unknown)


def compare(a: Any, b: Any, *, samples: int = 100_000, threads: int | None = None, **unknown: NoReturn) -> Comparison:
    """Compares two meshes: distances in both directions, normals, bending energy, vertices and faces that both have.

    Args:
        a: The first mesh: vertices and faces as a pair, a path, a :class:`Model` or :class:`Mended`, or a mesh of trimesh, pyvista,
            meshio or Open3D.
        b: The second mesh.
        samples: Number of samples on each mesh, at most 100 million. They are spread evenly over the area. The largest distance also
            takes every vertex into account.
        threads: Number of threads, one per core by default.

    Returns:
        The comparison.

    Raises:
        MeshError: A mesh has no face with an area.
        ParameterError: The number of samples is out of range.
        MeshTypeError: A mesh has none of these types.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> open_one = (vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    >>> done = isomend.compare(open_one, isomend.fill(*open_one, holes=[1]))
    >>> done.a_to_b.max, done.kept.faces, round(done.b_to_a.max, 3)
    (0.0, 3, 0.331)
    """
    samples = _params.params("compare", {"samples": samples, **unknown})["samples"]
    workers = None if threads is None else _params.count("threads", threads)
    first, second = as_model(a), as_model(b)
    return comparison(*_isomend.compare(first._core, second._core, samples, workers))


def convert(
    source: Path | bytes,
    output: Path,
    *,
    from_: str | None = None,
    to: str | None = None,
    ascii: bool = False,
    report: Path | None = None,
    picture: Path | None = None,
) -> list[str]:
    """Writes a mesh file in another format, or in the same one: the same bytes as ``isomend convert``.

    Vertices and faces keep their order, open holes stay open. Coordinates are rounded if the format has 32-bit floats.

    Args:
        source: A path, or the bytes of a file.
        output: The file to write, in the format of its extension.
        from_: The format of the source; by default it is recognised from the content, else from the extension.
        to: The format of the output, whatever its extension: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
        ascii: Write text instead of binary: PLY, STL and VTK legacy.
        report: Path of an HTML page that shows the mesh.
        picture: Path of a PNG picture of the mesh.

    Returns:
        Remarks, such as on values that the format cannot hold.

    Raises:
        FileError: A file cannot be read or written.
        ParameterError: There is no format of a given name, or it has no text form.
    """
    model = read(source, format=from_)
    return model.write(output, format=to, ascii=ascii, report=report, picture=picture)


@overload
def restore(
    vertices: ArrayLike,
    faces: ArrayLike,
    mark: Mask,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[RestoreOptions],
) -> Mended: ...
@overload
def restore(mesh: Any, mark: Mask, /, **options: Unpack[RestoreOptions]) -> Mended: ...
@overload
def restore(vertices: Any, *, mark: Mask, **options: Unpack[RestoreOptions]) -> Mended: ...
def restore(
    vertices: Any,
    faces: Any = None,
    mark: Mask | None = None,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[RestoreOptions],
) -> Mended:
    """Cuts out a marked region and fills it. All other faces and vertices stay bit for bit and in order.

    Args:
        vertices: (n, 3). Or a mesh, as for :func:`fill`; the mask comes next then: ``restore("scan.ply", mark)``.
        faces: (m, 3).
        mark: bool (m,), or the indices of the faces to replace; or a mask as a dictionary, such as
            ``{"balls": [[[0, 0, 1], 0.3]], "grow": 0.1}``. ``inside`` takes closed meshes of the kinds that ``vertices`` takes.
        point_data: Named values of vertices.
        cell_data: Named values of faces.
        options: ``keep_shape`` from 0 to 1 keeps part of the shape that was cut out; ``keep_vertices`` keeps the indices of
            vertices; further options as for :func:`fill`, except the choice of holes.

    Returns:
        The restored mesh, with a report.

    Raises:
        EmptyMaskError: No face is marked.
        MeshError, ParameterError, Cancelled: As for :func:`fill`.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> isomend.restore(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], [False] * 4)
    Traceback (most recent call last):
    ...
    isomend.EmptyMaskError: no region is marked: a restoration needs a mask
    """
    model, mask = _marked(vertices, faces, mark, point_data, cell_data)
    if mask is None:
        _params.params("restore", dict.fromkeys(_params.taken_apart(options)[1]))
        raise ParameterError("restore needs a mask: restore(vertices, faces, mark), or restore(mesh, mark)")
    return model.restore(mask, **options)


@overload
def fair(
    vertices: ArrayLike,
    faces: ArrayLike,
    mark: Mask | None = None,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[FairOptions],
) -> Mended: ...
@overload
def fair(mesh: Any, mark: Mask, /, **options: Unpack[FairOptions]) -> Mended: ...
@overload
def fair(vertices: Any, *, mark: Mask | None = None, **options: Unpack[FairOptions]) -> Mended: ...
def fair(
    vertices: Any,
    faces: Any = None,
    mark: Mask | None = None,
    *,
    point_data: Mapping[str, ArrayLike] | None = None,
    cell_data: Mapping[str, ArrayLike] | None = None,
    **options: Unpack[FairOptions],
) -> Mended:
    """Smooths a surface by Willmore flow: noise and small features are removed, large forms stay.

    Args:
        vertices: (n, 3). Or a mesh, as for :func:`fill`; a mask comes next then: ``fair("scan.ply", mark)``.
        faces: (m, 3).
        mark: The faces to fair, as for :func:`restore`; by default all.
        point_data: Named values of vertices.
        cell_data: Named values of faces.
        options: ``strength``, the width of the features to remove, in the units of the mesh, or ``time``, the time of the flow, in
            these units to the fourth power; by default features narrower than eight mean edges are removed. ``voxel``, ``variant``,
            ``edge_ratio``, ``keep_vertices``, ``threads``, ``progress``, ``strict`` as for :func:`fill` and :func:`restore`.

    Returns:
        The faired mesh, with a report.

    Raises:
        EmptyMaskError, MeshError, ParameterError, Cancelled: As for :func:`restore`.

    >>> import isomend
    >>> isomend.fair([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], strength=1.0, time=1.0)
    Traceback (most recent call last):
    ...
    isomend.ParameterError: strength and time exclude each other; give one of them
    """
    model, mask = _marked(vertices, faces, mark, point_data, cell_data)
    return model.fair(mask, **options)


def _marked(
    vertices: Any,
    faces: Any,
    mark: Mask | None,
    point_data: Mapping[str, ArrayLike] | None,
    cell_data: Mapping[str, ArrayLike] | None,
) -> tuple[Model, Mask | None]:
    """The model and the mask of vertices, faces and a mask, or of a mesh and a mask."""
    if mark is None and faces is not None and is_mesh(vertices):
        faces, mark = None, faces
    return model_of(vertices, faces, point_data, cell_data), mark


def solve_task(task: bytes, *, threads: int | None = None) -> bytes:
    """Solves the task of a region, in any process or machine; see :meth:`isomend.Inspection.each_task`.

    Args:
        task: The bytes of a task.
        threads: Number of threads, one per core by default.

    Returns:
        The bytes of the region's patch, for :meth:`isomend.Inspection.assemble`.

    Raises:
        ParameterError: The bytes are no task.
    """
    if threads is not None:
        threads = _params.count("threads", threads)
    return _isomend.solve_task(task, threads)


def is_cramped(patch: bytes) -> bool:
    """Whether a region needed more of the mesh than its task contains, so that it has no patch yet.

    The task of :meth:`isomend.Inspection.wide_task` contains all that the region may use. If it is not solved,
    :meth:`isomend.Inspection.assemble` solves the region itself.

    Args:
        patch: The bytes that :func:`solve_task` returned.

    Raises:
        ParameterError: The bytes are no patch.
    """
    return _isomend.is_cramped(patch)
