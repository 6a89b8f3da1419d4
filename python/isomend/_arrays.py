"""Arrays: from what callers have to what the library reads, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from isomend._errors import MeshError, ParameterError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Given = tuple[str, str, str, int, NDArray[np.float64]]
    Taken = tuple[str, str, int, NDArray[np.float64], "NDArray[np.bool_] | None"]

# Whole numbers beyond this are not all floats of 64 bits.
LARGEST_WHOLE = 2**53

ROLES = {
    "normal": ("normals", "normal"),
    "colour": ("colors", "colours", "color", "colour", "rgb", "rgba", "vertex_colors", "face_colors"),
    "uv": ("uv", "uvs", "texture coordinates", "texture_coordinates", "tcoords"),
}
COMPONENTS = {"normal": (3,), "colour": (3, 4), "uv": (2,)}


def unmasked(what: str, values: ArrayLike) -> NDArray[Any]:
    """An array, without values that are masked."""
    if np.ma.isMaskedArray(values) and np.any(np.ma.getmaskarray(values)):
        raise ParameterError(f"{what} is a masked array with masked values; fill these, or take them out")
    return np.asarray(values)


def table(what: str, values: ArrayLike) -> NDArray[Any]:
    """An array of n rows of three numbers."""
    try:
        array = unmasked(what, values)
    except ParameterError as error:
        raise MeshError(str(error)) from None
    if array.size == 0 and array.ndim < 2:
        array = array.reshape(0, 3)
    if array.dtype.kind not in "fiu":
        raise MeshError(f"{what} must be numbers, but are of the type {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        advice = "; cut quadrilaterals into triangles first" if array.shape[1:] == (4,) else ""
        raise MeshError(f"{what} must be an array of the shape (n, 3), but its shape is {array.shape}{advice}")
    return array


def points(what: str, values: ArrayLike) -> NDArray[np.float64]:
    """Coordinates, none of which changes."""
    array = table(what, values)
    if array.dtype.kind in "iu" and array.size and max(abs(int(array.min())), abs(int(array.max()))) > LARGEST_WHOLE:
        raise MeshError(f"{what} has whole numbers beyond 2**53, which floats of 64 bits cannot hold")
    exact = np.ascontiguousarray(array, dtype=np.float64)
    if array.dtype.kind == "f" and array.dtype.itemsize > 8 and not np.array_equal(exact, array, equal_nan=True):
        raise MeshError(f"{what} of the type {array.dtype} has numbers that floats of 64 bits cannot hold")
    return exact


def faces(values: ArrayLike) -> NDArray[np.int64]:
    """Vertex numbers."""
    array = table("faces", values)
    if array.dtype.kind == "f":
        # Not even a comparison is made of what is no number.
        if not np.all(np.isfinite(array)) or np.any(array != np.trunc(array)):
            raise MeshError("faces must be whole numbers")
    if array.dtype.kind != "i" and array.size and array.max() > np.iinfo(np.int64).max // 2:
        raise MeshError(f"faces refer to vertex {int(array.max())}, which is not there")
    return np.ascontiguousarray(array, dtype=np.int64)


def face_numbers(mask: ArrayLike, count: int) -> list[int]:
    """The numbers of the faces that are marked, by one mark for each face or by their numbers."""
    array = unmasked("the mask", mask)
    if array.ndim != 1:
        raise ParameterError(f"a mask must be an array of one dimension, but its shape is {array.shape}")
    if array.dtype.kind == "b":
        if len(array) != count:
            raise ParameterError(f"there are {len(array)} marks for {count} faces; one for each is needed")
        array = np.flatnonzero(array)
    elif array.size and array.dtype.kind not in "iu":
        raise ParameterError(f"a mask holds a mark for each face, or face numbers, but this one is of the type {array.dtype}")
    elif array.size > 1 and len(array) == count and array.max() <= 1 and array.min() >= 0:
        raise ParameterError(
            f"the mask has {count} whole numbers, one for each face, and all are 0 or 1: as marks they must be of the type bool, "
            "such as mask.astype(bool); as face numbers they would name the faces 0 and 1 alone"
        )
    numbers: list[int] = array.astype(np.int64).tolist()
    for number in numbers:
        if not 0 <= number < count:
            raise ParameterError(f"the mask names face {number}, but there are only {count}, numbered from 0")
    return numbers


def role(name: str, components: int) -> str:
    """What values mean, by their name: normals, colours and texture coordinates are continued as such."""
    for role, names in ROLES.items():
        if name.lower() in names and components in COMPONENTS[role]:
            return role
    return "other"


def given(what: str, data: Mapping[str, ArrayLike] | None, count: int) -> list[Given]:
    """Named values as the library takes them."""
    out: list[Given] = []
    for name, values in (data or {}).items():
        array = unmasked(f"{what} '{name}'", values)
        if array.dtype.kind == "b":
            array = array.astype(np.uint8)
        if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
            raise ParameterError(f"{what} '{name}' is of the type {array.dtype}, which cannot be continued on patches")
        if array.dtype == np.float16:
            array = array.astype(np.float32)
        if array.ndim == 0 or len(array) != count:
            raise ParameterError(f"{what} '{name}' has the shape {array.shape}, but there are {count} values to have")
        rows = array.reshape(count, -1) if count else array.reshape(0, 1)
        flat = np.ascontiguousarray(rows, dtype=np.float64).reshape(-1)
        if array.dtype.kind in "iu" and array.dtype.itemsize == 8 and flat.size and np.abs(flat).max() > LARGEST_WHOLE:
            raise ParameterError(f"{what} '{name}' has whole numbers beyond 2**53, which cannot be kept")
        kind = array.dtype.newbyteorder("=").name
        out.append((str(name), role(str(name), rows.shape[1]), kind, rows.shape[1], flat))
    return out


def taken(values: list[Taken], rows: tuple[int, ...] = ()) -> dict[str, NDArray[Any]]:
    """Named values as arrays of their types; of what is missing floats are NaN, whole numbers 0.

    ``rows`` are the first dimensions, where they are not one."""
    out: dict[str, NDArray[Any]] = {}
    for name, kind, components, flat, missing in values:
        array = flat.reshape(-1, components) if components != 1 else flat.copy()
        if missing is not None:
            array = array.copy()
            array[missing] = np.nan if kind.startswith("float") else 0
        array = array.astype(kind)
        if rows:
            array = array.reshape(*rows, *array.shape[1:])
        out[name if name not in out else f"{name} ({len(out)})"] = array
    return out


def restored_types(
    data: dict[str, NDArray[Any]], before: Mapping[str, ArrayLike] | None
) -> dict[str, NDArray[Any]]:
    """The same in the types and shapes that the values had before."""
    for name, values in (before or {}).items():
        array = np.asarray(values)
        if name in data:
            data[name] = data[name].reshape(-1, *array.shape[1:]).astype(array.dtype)
    return data
