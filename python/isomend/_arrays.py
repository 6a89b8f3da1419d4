"""Validation and conversion of arrays: from callers' arrays to the library's form, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from isomend._errors import MeshError, ParameterError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    Given = tuple[str, str, str, int, NDArray[np.float64]]
    Taken = tuple[str, str, int, NDArray[np.float64], "NDArray[np.bool_] | None"]

# Up to this magnitude a 64-bit float holds every integer exactly.
LARGEST_WHOLE = 2**53

# Names (in lower case) of values that are continued as normals, colours and texture coordinates; others are plain numbers.
ROLES = {
    "normal": ("normals", "normal"),
    "colour": ("colors", "colours", "color", "colour", "rgb", "rgba", "vertex_colors", "face_colors"),
    "uv": ("uv", "uvs", "texture coordinates", "texture_coordinates", "tcoords"),
}
# Numbers of components that values of a role can have.
COMPONENTS = {"normal": (3,), "colour": (3, 4), "uv": (2,)}


def unmasked(what: str, values: ArrayLike) -> NDArray[Any]:
    """`values` as an array. A `ParameterError`, which names it `what`, if values are masked, or are lists that are no array."""
    if np.ma.isMaskedArray(values) and np.any(np.ma.getmaskarray(values)):
        raise ParameterError(f"{what} is a masked array with masked values; fill these values, or remove them")
    try:
        return np.asarray(values)
    except ValueError as error:
        raise ParameterError(f"{what} cannot be made an array, such as rows of different lengths: {error}") from None


def table(what: str, values: ArrayLike) -> NDArray[Any]:
    """An array (n, 3) of numbers. A `MeshError`, which names it `what`, if the shape or the type is another one."""
    try:
        array = unmasked(what, values)
    except ParameterError as error:
        raise MeshError(str(error)) from None
    if array.size == 0 and array.ndim < 2:
        array = array.reshape(0, 3)
    if array.dtype.kind not in "fiu":
        raise MeshError(f"{what} must be numbers, but have the type {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        advice = "; cut quadrilaterals into triangles first" if array.shape[1:] == (4,) else ""
        raise MeshError(f"{what} must be an array of the shape (n, 3), but the shape is {array.shape}{advice}")
    return array


def points(what: str, values: ArrayLike) -> NDArray[np.float64]:
    """Coordinates (n, 3) as 64-bit floats. A `MeshError` if a 64-bit float cannot hold one of them exactly."""
    array = table(what, values)
    if array.dtype.kind in "iu" and array.size and max(abs(int(array.min())), abs(int(array.max()))) > LARGEST_WHOLE:
        raise MeshError(f"{what} has whole numbers beyond 2**53, which 64-bit floats cannot hold")
    exact = np.ascontiguousarray(array, dtype=np.float64)
    if array.dtype.kind == "f" and array.dtype.itemsize > 8 and not np.array_equal(exact, array, equal_nan=True):
        raise MeshError(f"{what} of the type {array.dtype} has numbers that 64-bit floats cannot hold")
    return exact


def faces(values: ArrayLike) -> NDArray[np.int64]:
    """Faces (m, 3) as 64-bit vertex indices. A `MeshError` if they are no integers, or too large for the library's check."""
    array = table("faces", values)
    if array.dtype.kind == "f":
        # Tested first, as NaN and infinity are not to be compared with their truncation.
        if not np.all(np.isfinite(array)) or np.any(array != np.trunc(array)):
            raise MeshError("faces must be whole numbers")
    if array.dtype.kind != "i" and array.size and array.max() > np.iinfo(np.int64).max // 2:
        raise MeshError(f"faces refer to vertex {int(array.max())}, which is not there: there are fewer vertices")
    return np.ascontiguousarray(array, dtype=np.int64)


def face_numbers(mask: ArrayLike, count: int, what: str = "the mask") -> list[int]:
    """The indices of marked faces, from one truth value for each of `count` faces or from face indices; else a `ParameterError` that
    names `what`."""
    array = unmasked(what, mask)
    if array.ndim != 1:
        raise ParameterError(f"{what} must be an array with one dimension, but its shape is {array.shape}")
    if array.dtype.kind == "b":
        if len(array) != count:
            raise ParameterError(f"{what} has {len(array)} marks for {count} faces, the shape {array.shape}; one for each face is needed")
        array = np.flatnonzero(array)
    elif array.size and array.dtype.kind not in "iu":
        raise ParameterError(f"{what} must be of the type bool, or face numbers, but its type is {array.dtype}")
    elif array.size > 1 and len(array) == count and array.max() <= 1 and array.min() >= 0:
        raise ParameterError(
            f"{what} has {count} whole numbers, one for each face, and all are 0 or 1; if they are marks, use the type bool: "
            "mask.astype(bool); as face numbers they would name only the faces 0 and 1"
        )
    numbers: list[int] = array.astype(np.int64).tolist()
    for number in numbers:
        if not 0 <= number < count:
            raise ParameterError(f"{what} names face {number}, but there are only {count} faces, numbered from 0")
    return numbers


def role(name: str, components: int) -> str:
    """The role of values, by their name: normals, colours and texture coordinates are continued accordingly."""
    for role, names in ROLES.items():
        if name.lower() in names and components in COMPONENTS[role]:
            return role
    return "other"


def given(what: str, data: Mapping[str, ArrayLike] | None, count: int) -> list[Given]:
    """Named values in the library's form. A `ParameterError` if there are not `count` of them, or their type is not supported."""
    out: list[Given] = []
    if data is not None and not isinstance(data, Mapping):
        raise ParameterError(f"{what} must be a dictionary of names and arrays, such as {{'heat': values}}, but is {type(data).__name__}")
    for name, values in (data or {}).items():
        array = unmasked(f"{what} '{name}'", values)
        if array.dtype.kind == "b":
            array = array.astype(np.uint8)
        if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
            raise ParameterError(f"{what} '{name}' has the type {array.dtype}, which cannot be continued on patches")
        if array.dtype == np.float16:
            array = array.astype(np.float32)
        if array.ndim == 0 or len(array) != count:
            raise ParameterError(f"{what} '{name}' has the shape {array.shape}, but its first dimension must be {count}")
        rows = array.reshape(count, -1) if count else array.reshape(0, 1)
        flat = np.ascontiguousarray(rows, dtype=np.float64).reshape(-1)
        if array.dtype.kind in "iu" and array.dtype.itemsize == 8 and flat.size and np.abs(flat).max() > LARGEST_WHOLE:
            raise ParameterError(f"{what} '{name}' has whole numbers beyond 2**53, which are not supported")
        kind = array.dtype.newbyteorder("=").name
        out.append((str(name), role(str(name), rows.shape[1]), kind, rows.shape[1], flat))
    return out


def taken(values: list[Taken], rows: tuple[int, ...] = ()) -> dict[str, NDArray[Any]]:
    """Named values from the library's form, in their types. Missing values are NaN in floats and 0 in integers.

    ``rows`` are the leading dimensions of the arrays, if there is more than one."""
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
    """`data` with the types and trailing dimensions of the caller's values `before`."""
    for name, values in (before or {}).items():
        array = np.asarray(values)
        if name in data:
            data[name] = data[name].reshape(-1, *array.shape[1:]).astype(array.dtype)
    return data
