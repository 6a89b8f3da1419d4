"""Signed distances of meshes, at points and as volumes; level surfaces of volumes."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal, NoReturn, Union, overload

from isomend import _isomend, _params
from isomend._adapters import as_model, model_of
from isomend._errors import FileError, MeshTypeError, ParameterError
from isomend._mesh import Model
from isomend._volume import Volume

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from isomend._params import Voxel

    Path = Union[str, os.PathLike[str]]


@overload
def sdf(
    vertices: ArrayLike,
    faces: ArrayLike,
    *,
    voxel: Voxel = "auto",
    band: float | Literal["full"] = "full",
    threads: int | None = None,
) -> Volume: ...
@overload
def sdf(
    vertices: Any,
    *,
    voxel: Voxel = "auto",
    band: float | Literal["full"] = "full",
    threads: int | None = None,
) -> Volume: ...
def sdf(
    vertices: Any,
    faces: ArrayLike | None = None,
    *,
    voxel: Voxel = "auto",
    band: float | Literal["full"] = "full",
    threads: int | None = None,
    **unknown: NoReturn,
) -> Volume:
    """Computes the signed distance of a mesh as a volume, negative inside.

    Distances are to the nearest triangle. A point is inside if the magnitude of the generalized winding number exceeds one half, so
    open meshes have an inside too. The lattice reaches three voxels beyond the mesh. For distances of given points see
    :func:`signed_distance`.

    Args:
        vertices: (n, 3). Or a mesh, without ``faces``, as for :func:`isomend.fill`.
        faces: (m, 3).
        voxel: Distance of neighbouring nodes, in the mesh's units; ``auto`` takes 1/128 of the longest side. The
            longest side is the bounding box's.
        band: Cut distances off at this length, which is faster; ``full`` computes all distances. The length is in the mesh's units,
            and at least a voxel.
        threads: Number of threads, one per core by default.

    Returns:
        A volume with ``values`` (nx, ny, nz), ``origin`` and ``spacing``.

    Raises:
        MeshError: The arrays are no valid mesh.
        ParameterError: A parameter is not valid, or there would be more than 2**27 nodes.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> volume = isomend.sdf(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], voxel=0.125)
    >>> volume.values.shape, volume.origin, float(volume.values[5, 5, 5])
    ((15, 15, 15), (-0.375, -0.375, -0.375), -0.14433756729740643)
    """
    return model_of(vertices, faces).sdf(voxel=voxel, band=band, threads=threads, **unknown)


def read_volume(source: Path | bytes, *, array: str | None = None) -> Volume:
    """Reads a volume: VTI, or VTK legacy structured points.

    Args:
        source: A path, or the bytes of a file.
        array: Name of the point data to take; needed if the file has several arrays.

    Returns:
        The volume.

    Raises:
        FileError: The file cannot be read, has no volume, does not have the named array, or has several arrays and none is named.
    """
    given = source if isinstance(source, bytes) else os.fspath(source)
    try:
        return Volume._of(_isomend.Volume.read_bytes(given, array) if isinstance(given, bytes) else _isomend.Volume.read(given, array))
    except FileError:
        if not _holds_mesh(given):
            raise
    place = "the bytes hold" if isinstance(given, bytes) else f"{given} holds"
    error = FileError(f"{place} a mesh, not a volume: isomend.read reads it, isomend.sdf computes its signed distance as a volume")
    error.filename = None if isinstance(given, bytes) else given
    raise error


def _holds_mesh(source: str | bytes) -> bool:
    """Whether a file that is no volume can be read as a mesh."""
    try:
        Model._read(source)
    except FileError:
        return False
    return True


def surface(
    volume: Volume | Path | bytes,
    *,
    level: float = 0.0,
    close: bool = False,
    array: str | None = None,
    threads: int | None = None,
    **unknown: NoReturn,
) -> Model:
    """Extracts the surface at one level of a volume by marching cubes. Values below the level are inside.

    Args:
        volume: A :class:`Volume`, or a file with one; see :func:`read_volume`.
        level: The level, in the units of the values.
        close: Close the surface with flat caps where it ends at the faces of the volume.
        array: Name of the point data to take from a file with several arrays.
        threads: Number of threads, one per core by default.

    Returns:
        A manifold mesh. Without ``close`` it is open where it reaches the faces of the volume.

    Raises:
        MeshTypeError: The argument is no volume.
        ParameterError: All values are on one side of the level, or a value is not finite.
        FileError: The file cannot be read.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> volume = isomend.sdf(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], voxel=0.0625)
    >>> bool(isomend.surface(volume, level=0.1).check())
    True
    """
    _params.refuse_unknown("surface", unknown, ("level", "close", "array", "threads"))
    if not isinstance(volume, (Volume, str, bytes, os.PathLike)):
        raise MeshTypeError(
            f"surface takes a Volume, or the path or the bytes of a file with one, but is given {type(volume).__qualname__}; "
            "isomend.sdf(mesh) makes a volume of a mesh"
        )
    if not isinstance(volume, Volume):
        volume = read_volume(volume, array=array)
    elif array is not None:
        raise ParameterError("array names values in a file; a volume has one array only")
    at = _params.finite("level", level)
    workers = None if threads is None else _params.count("threads", threads)
    return Model._of(volume._core.surface(at, _params.flag("close", close), workers))


@overload
def signed_distance(
    points: ArrayLike, vertices: ArrayLike, faces: ArrayLike, *, threads: int | None = None
) -> NDArray[Any]: ...
@overload
def signed_distance(points: ArrayLike, vertices: Any, *, threads: int | None = None) -> NDArray[Any]: ...
def signed_distance(
    points: ArrayLike,
    vertices: Any,
    faces: ArrayLike | None = None,
    *,
    threads: int | None = None,
    **unknown: NoReturn,
) -> NDArray[Any]:
    """Computes signed distances of points from a mesh, negative inside, exact up to rounding.

    A point is inside if the magnitude of the generalized winding number exceeds one half, so open meshes have an inside too.

    Args:
        points: (k, 3), in the units of the mesh.
        vertices: (n, 3). Or a mesh, without ``faces``, as for :func:`isomend.fill`.
        faces: (m, 3).
        threads: Number of threads, one per core by default.

    Returns:
        float64 (k,), in the units of the mesh; NaN for points that are not finite.

    Raises:
        MeshError: The arrays are no valid mesh.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    >>> isomend.signed_distance([[0.125, 0.25, 0.25], [0, 0, 3]], vertices, faces).tolist()
    [-0.125, 2.0]
    """
    from isomend import _arrays

    _params.refuse_unknown("signed_distance", unknown, ("threads",))
    if threads is not None:
        threads = _params.count("threads", threads)
    at = _arrays.points("points", points)
    if faces is None:
        model = as_model(vertices)
        vertices, faces = model.vertices, model.faces
    return _isomend.signed_distance(at, _arrays.points("vertices", vertices), _arrays.faces(faces), threads)
