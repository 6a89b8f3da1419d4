"""Parameters: from keywords to the JSON that the library reads. Names, kinds, bounds and paths are those of the library's tables."""

from __future__ import annotations

import functools
import json
import operator
import os
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

from isomend import _isomend
from isomend._errors import ParameterError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import TypeAlias

Voxel: TypeAlias = "float | Literal['auto']"
Progress: TypeAlias = "Callable[[float, int, int], object]"
Mask: TypeAlias = "ArrayLike | Mapping[str, Any]"


class RunOptions(TypedDict, total=False):
    """How a call is run."""

    threads: int | None
    progress: Progress | None
    strict: bool


RUN = ("threads", "progress", "strict")

Row: TypeAlias = "dict[str, Any]"


@functools.lru_cache(maxsize=None)
def tables() -> dict[str, dict[str, Row]]:
    """The parameters of each command by their names, as the library declares them."""
    document = json.loads(_isomend.parameters())
    return {command: {row["name"]: row for row in rows} for command, rows in document.items()}


def taken_apart(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """How the call is run, and the parameters of the work."""
    run = {name: options[name] for name in RUN if options.get(name) is not None}
    return run, {name: value for name, value in options.items() if name not in RUN}


def whole(name: str, value: Any) -> int:
    """A whole number. `True` and `False` are none."""
    try:
        if is_bool(value):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise ParameterError(f"{name} must be a whole number, but is {value!r}") from None
    if number < 0:
        raise ParameterError(f"{name} must not be negative, but is {number}")
    return number


def count(name: str, value: Any) -> int:
    """A whole number from 1."""
    number = whole(name, value)
    if number == 0:
        raise ParameterError(f"{name} must be a whole number from 1, but is 0")
    return number


def number(name: str, value: Any) -> float:
    """A number, as Python's or numpy's. `True` and `False` are none."""
    try:
        if is_bool(value):
            raise TypeError
        return float(value)
    except (TypeError, ValueError):
        raise ParameterError(f"{name} must be a number, but is {value!r}") from None


def finite(name: str, value: Any) -> float:
    """A finite number."""
    given = number(name, value)
    if not abs(given) < float("inf"):
        raise ParameterError(f"{name} must be a finite number, but is {given:g}")
    return given


def positive(name: str, value: Any) -> float:
    """A positive number. Infinite ones are refused with all others; see :func:`as_json`."""
    given = number(name, value)
    if not given > 0:
        raise ParameterError(f"{name} must be a positive number, but is {given:g}")
    return given


def bounded(row: Row, value: Any) -> float:
    """A number that keeps the bounds of its parameter. Infinite ones are refused with all others; see :func:`as_json`."""
    given, low, high = number(row["name"], value), row["low"], row["high"]
    above = given > low or (given == low and not row["open"])
    below = high is None or given < high or (given == high and not row["open"])
    if not (above and below):
        shown = value if isinstance(value, int) else f"{given:g}"
        raise ParameterError(f"{row['name']} must be {row['allowed']}, but is {shown}")
    return given


def choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """One of some words."""
    if not isinstance(value, str) or value not in choices:
        words = ", ".join(repr(word) for word in choices)
        raise ParameterError(f"{name} must be one of {words}, but is {value!r}")
    return value


def is_bool(value: Any) -> bool:
    """Whether a value is a truth value of Python or numpy."""
    return isinstance(value, bool) or type(value).__name__ in ("bool_", "bool")


def flag(name: str, value: Any) -> bool:
    """A truth value."""
    if not is_bool(value):
        raise ParameterError(f"{name} must be True or False, but is {value!r}")
    return bool(value)


def wholes(name: str, values: Any) -> list[int]:
    """A list of whole numbers."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise ParameterError(f"{name} must be a list of hole numbers, but is {values!r}")
    return [whole(name, value) for value in values]


def pair(name: str, ends: Any) -> list[int]:
    """Two different whole numbers from 1."""
    if isinstance(ends, (str, bytes)) or not isinstance(ends, Iterable):
        raise ParameterError(f"{name} must be a list of pairs of numbers of crease ends, but has {ends!r}")
    given = [count(f"each number of {name}", end) for end in ends]
    if len(given) != 2 or given[0] == given[1]:
        raise ParameterError(f"each pair of {name} must be two different numbers of crease ends, but one is {tuple(given)}")
    return given


def like(name: str, value: Any) -> str:
    """What holes are filled after: ``mirror``, with a plane or without, or the path of a mesh."""
    try:
        text = os.fspath(value)
    except TypeError:
        text = b""
    if not isinstance(text, str) or not text:
        raise ParameterError(f"{name} must be 'mirror', 'mirror:x,y,z,nx,ny,nz' or the path of a mesh, but is {value!r}")
    return text


def plain(row: Row, value: Any) -> Any:
    """A value of a parameter in the library's form."""
    name, kind = row["name"], row["kind"]
    if kind == "flag":
        return flag(name, value) == row["sets"]
    if kind == "choice":
        return choice(name, value, tuple(word["name"] for word in row["choices"]))
    if kind == "holes":
        return wholes(name, value)
    if kind == "groups":
        return [wholes(f"each group of {name}", group) for group in value]
    if kind == "like":
        return like(name, value)
    if kind == "pairs":
        return [pair(name, ends) for ends in value]
    if kind == "whole":
        return int(bounded(row, whole(name, value)))
    if kind == "voxel":
        return value if isinstance(value, str) and value == "auto" else {"length": bounded(row, value)}
    if kind == "band":
        return None if isinstance(value, str) and value == "full" else bounded(row, value)
    return bounded(row, value)


def params(command: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a command in the library's form; those that are ``None`` are left to it."""
    rows = tables()[command]
    placed: dict[str, Any] = {}
    chosen = {name: value for name, value in given.items() if value is not None and value is not False}
    for name, value in given.items():
        if name not in rows:
            raise ParameterError(f"{command} has no parameter {name!r}; it has {', '.join(rows)}")
        if value is None or not rows[name]["path"]:
            continue
        *steps, last = rows[name]["path"]
        inner = placed
        for step in steps:
            inner = inner.setdefault(step, {})
        inner[last] = plain(rows[name], value)
        if name in chosen and rows[name]["excludes"] in chosen:
            raise ParameterError(f"{name} and {rows[name]['excludes']} exclude each other; give one of them")
    return placed


def fill_work(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The work of a fill, which may be one that repairs the rest first."""
    fill, repairs = params("fill", parameters), flag("repair", parameters.get("repair") or False)
    return {"repair": {"fill": fill}} if repairs else {"fill": fill}


def region_params(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a fill region by region, which repairs nothing else."""
    if flag("repair", parameters.get("repair") or False):
        raise ParameterError("regions are those of a fill: call repair() first, or fill(…, repair=True) for both in one")
    return params("fill", parameters)


def mask_of(mask: Mask, faces: int) -> dict[str, Any]:
    """A mask in the library's form: from one mark for each face, from face numbers, or as it is."""
    if isinstance(mask, Mapping):
        return {name: _part(name, value, faces) for name, value in mask.items()}
    return _faces(mask, faces)


def _part(name: str, value: Any, faces: int) -> Any:
    """A part of a mask; face numbers as an array are checked like a mask of their own."""
    return _faces(value, faces)["faces"] if name == "faces" and hasattr(value, "dtype") else unpacked(value)


def _faces(mask: Any, faces: int) -> dict[str, Any]:
    from isomend import _arrays

    return {"faces": _arrays.face_numbers(mask, faces)}


def unpacked(value: Any) -> Any:
    """A part of a mask with Python's numbers and lists in place of numpy's."""
    if isinstance(value, Mapping):
        return {name: unpacked(part) for name, part in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [unpacked(part) for part in value]
    return value


Work = Union[dict[str, Any], list[Any]]


def as_json(work: Work) -> str:
    """The JSON of what the library reads."""
    try:
        return json.dumps(work, allow_nan=False)
    except ValueError:
        raise ParameterError("parameters must be finite numbers; leave out what has no bound") from None
    except TypeError as error:
        raise ParameterError(f"a parameter is of a type that cannot be passed on: {error}") from None
