"""Parameters: validates keywords and converts them to the library's JSON, by the library's tables of names, kinds, bounds and paths."""

from __future__ import annotations

import functools
import json
import operator
import os
import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

from isomend import _isomend
from isomend._errors import ParameterError
from isomend._holes import CreaseEnd, Hole

if TYPE_CHECKING:
    from numpy.typing import ArrayLike
    from typing_extensions import TypeAlias

Voxel: TypeAlias = "float | Literal['auto']"
Progress: TypeAlias = "Callable[[float, int, int], object]"
Mask: TypeAlias = "ArrayLike | Mapping[str, Any]"


class RunOptions(TypedDict, total=False):
    """Options of the call itself, not of the work."""

    threads: int | None
    progress: Progress | None
    strict: bool


RUN = ("threads", "progress", "strict")
# The keyword of a mask.
MARKED = {"restore": ("mark",), "fair": ("mark",)}
# The options of calls that do not mend.
CALL = {"check": ("threads",), "compare": ("threads",), "sdf": ("threads",)}

Row: TypeAlias = "dict[str, Any]"


@functools.lru_cache(maxsize=None)
def tables() -> dict[str, dict[str, Row]]:
    """The library's table of parameters: for each command its rows by name."""
    document = json.loads(_isomend.parameters())
    return {command: {row["name"]: row for row in rows} for command, rows in document.items()}


def taken_apart(options: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Splits options into options of the call (threads, progress, strict), validated, and parameters of the work."""
    run = {name: options[name] for name in RUN if options.get(name) is not None}
    if not callable(run.get("progress", callable)):
        raise ParameterError(f"progress must be a function, called as progress(part, done, regions), but is {run['progress']!r}")
    flag("strict", run.get("strict", False))
    return run, {name: value for name, value in options.items() if name not in RUN}


def whole(name: str, value: Any) -> int:
    """A whole number from 0; `True` and `False` are refused."""
    try:
        if is_bool(value):
            raise TypeError
        number = operator.index(value)
    except TypeError:
        raise ParameterError(f"{name} must be a whole number, but is {_shown(value)}") from None
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
    """A number of Python or numpy as a float; truth values and texts are refused."""
    try:
        if is_bool(value) or isinstance(value, (str, bytes)):
            raise TypeError
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(f"{name} must be a number, but is {value!r}") from None


def finite(name: str, value: Any) -> float:
    """A finite number."""
    given = number(name, value)
    if not abs(given) < float("inf"):
        raise ParameterError(f"{name} must be a finite number, but is {given:g}")
    return given


def positive(name: str, value: Any) -> float:
    """A positive number."""
    given = number(name, value)
    if not given > 0:
        raise ParameterError(f"{name} must be a positive number, but is {given:g}")
    return finite(name, given)


def bounded(row: Row, value: Any) -> float:
    """A number within the bounds of its parameter."""
    given, low, high = number(row["name"], value), row["low"], row["high"]
    above = given > low or (given == low and not row["open"])
    below = high is None or given < high or (given == high and not row["open"])
    if not (above and below):
        shown = value if isinstance(value, int) else f"{given:g}"
        raise ParameterError(f"{row['name']} must be {row['allowed']}, but is {shown}")
    if given == float("inf"):
        raise ParameterError(f"{row['name']} must be a finite number, but is inf; leave out what has no bound")
    return given


def word_or_bounded(row: Row, word: str, value: Any) -> float | None:
    """A number within the bounds of its parameter; None for the word that may stand in its place."""
    if isinstance(value, str) and value == word:
        return None
    try:
        return bounded(row, value)
    except ParameterError:
        shown = f"{value:g}" if isinstance(value, float) else repr(value)
        raise ParameterError(f"{row['name']} must be {row['allowed']} or {word!r}, but is {shown}") from None


def choice(name: str, value: Any, choices: tuple[str, ...]) -> str:
    """One of the choices."""
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


def wholes(name: str, values: Any, word: str | None = None) -> list[int]:
    """A list of numbers of holes, or of components for ``drop``; holes themselves stand for their numbers. A message also names the word
    that may stand in place of the list."""
    of_what, taken = ("component", ()) if name == "drop" else ("hole", Hole)
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        instead = f", or {word!r}" if word else ""
        raise ParameterError(f"{name} must be a list of {of_what} numbers, such as [1]{instead}, but is {_shown(values)}")
    return [value.id if isinstance(value, taken) else whole(f"each number of {name}", value) for value in values]


def _shown(value: Any) -> str:
    """A value in a message; a hole or a crease end by its number."""
    named = {Hole: "hole", CreaseEnd: "crease end"}.get(type(value))
    return f"the {named} {value.id}" if named else repr(value)


def listed(name: str, values: Any, example: str) -> list[Any]:
    """A list of groups."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise ParameterError(f"{name} must be a list such as {example}, but is {values!r}")
    return list(values)


def together(name: str, group: Any) -> list[int]:
    """A group of two or more different holes, by their numbers."""
    holes = wholes(f"each group of {name}", group)
    if len(set(holes)) < 2:
        raise ParameterError(f"each group of {name} must be the numbers of two different holes or more, but one is {holes}")
    return holes


def pair(name: str, ends: Any) -> list[int]:
    """A pair of different crease ends, by their numbers from 1."""
    if isinstance(ends, (str, bytes)) or not isinstance(ends, Iterable):
        raise ParameterError(f"{name} must be a list of pairs of crease ends (their numbers), but contains {ends!r}")
    given = [end.id if isinstance(end, CreaseEnd) else count(f"each number of {name}", end) for end in ends]
    if len(given) != 2 or given[0] == given[1]:
        raise ParameterError(f"each pair of {name} must be the numbers of two different crease ends, but one is {tuple(given)}")
    return given


def words(name: str, values: Any, known: tuple[str, ...]) -> list[str]:
    """A list of words, or one word."""
    listed = [values] if isinstance(values, str) else values
    if not isinstance(listed, Iterable):
        raise ParameterError(f"{name} must be a list of words from {', '.join(known)}, but is {values!r}")
    return [choice(name, value, known) for value in listed]


def like(name: str, value: Any) -> str:
    """A counterpart: ``mirror``, with or without a plane, or the path of a mesh; :mod:`isomend._files` makes paths of meshes."""
    try:
        text = os.fspath(value)
    except TypeError:
        text = b""
    if not isinstance(text, str) or not text:
        raise ParameterError(f"{name} must be 'mirror', 'mirror:x,y,z,nx,ny,nz' or the path of a mesh, but is {value!r}")
    return text


def plain(row: Row, value: Any) -> Any:
    """Validates the value of a parameter and converts it to the library's form."""
    name, kind = row["name"], row["kind"]
    if kind == "flag":
        return flag(name, value) == row["sets"]
    if kind == "choice":
        return choice(name, value, tuple(word["name"] for word in row["choices"]))
    if kind == "words":
        return words(name, value, tuple(word["name"] for word in row["choices"]))
    if kind == "holes":
        word = "all" if row["placeholder"].startswith("all") else None
        return None if word and isinstance(value, str) and value == word else wholes(name, value, word)
    if kind == "groups":
        return [together(name, group) for group in listed(name, value, "[[1, 2]]")]
    if kind == "like":
        return like(name, value)
    if kind == "pairs":
        return [pair(name, ends) for ends in listed(name, value, "[(1, 2)]")]
    if kind == "whole":
        return int(bounded(row, whole(name, value)))
    if kind == "voxel":
        length = word_or_bounded(row, "auto", value)
        return "auto" if length is None else {"length": length}
    if kind == "band":
        return word_or_bounded(row, "full", value)
    return bounded(row, value)


def params(command: str, given: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a command in the library's form. Parameters that are ``None`` are left out: the library uses its default."""
    rows = tables()[command]
    placed: dict[str, Any] = {}
    chosen = {name: value for name, value in given.items() if value is not None and value is not False}
    for name, value in given.items():
        if now := _isomend.in_place_of(command, name):
            raise ParameterError(f"{command} has no parameter {name!r} any more: use {now}")
        if name not in rows:
            refuse_unknown(command, (name,), (*rows, *MARKED.get(command, ()), *CALL.get(command, RUN)))
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


def refuse_unknown(function: str, unknown: Iterable[str], known: tuple[str, ...]) -> None:
    """A `ParameterError` if there are unknown keywords; it names the known ones, first the one that is spelt like the unknown one."""
    import difflib

    for name in unknown:
        similar = difflib.get_close_matches(name, known, 1)
        meant = f" (is {similar[0]} meant?)" if similar else ""
        raise ParameterError(f"{function} has no parameter {name!r}{meant}; it has {', '.join(known)}")


def mask_of(mask: Mask, faces: int) -> dict[str, Any]:
    """A mask in the library's form, from one truth value for each face, face indices, or a dictionary."""
    if isinstance(mask, Mapping):
        return {name: _part(name, value, faces) for name, value in mask.items()}
    if isinstance(mask, (str, bytes)) or not (hasattr(mask, "dtype") or isinstance(mask, Iterable)):
        raise ParameterError(
            "a mask must be one bool for each face, face numbers, or a dictionary such as {'colours': ['ff0000']} or "
            f"{{'balls': [[[0, 0, 1], 0.3]]}}, but is {mask!r}"
        )
    return _faces(mask, faces)


def _part(name: str, value: Any, faces: int) -> Any:
    """A part of a mask's dictionary, validated, so that errors name it."""
    if name not in PARTS:
        raise ParameterError(f"a mask has no part {name!r}; its parts are {', '.join(PARTS)}")
    if name == "faces":
        return _faces(value if hasattr(value, "dtype") else list(_items(name, value)), faces, "'faces' of the mask")["faces"]
    if name in ("grow", "shrink"):
        return None if value is None else positive(f"{name} of the mask", value)
    return [PARTS[name](f"each of the mask's {name}", item) for item in _items(name, value)]


def _items(name: str, value: Any) -> list[Any]:
    """The items of a part of a mask; a path, a colour or a name alone is one item."""
    value = [value] if name in NAMED and isinstance(value, (str, os.PathLike)) else unpacked(value)
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        raise ParameterError(f"{name} of a mask must be a list, but is {value!r}")
    return list(value)


def _point(what: str, value: Any) -> list[float]:
    """A point, or another triple of numbers."""
    value = unpacked(value)
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise ParameterError(f"{what} must have points of three numbers, but one is {value!r}")
    return [finite(f"each coordinate in {what}", x) for x in value]


def _box(what: str, value: Any) -> list[list[float]]:
    """A box: its smallest and its largest corner, as two points or as six numbers."""
    if isinstance(value, (list, tuple)) and len(value) == 6:
        value = [value[:3], value[3:]]
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ParameterError(f"{what} must be its smallest and its largest corner, [[x, y, z], [x, y, z]], but one is {value!r}")
    return [_point(what, corner) for corner in value]


def _ball(what: str, value: Any) -> list[Any]:
    """A ball: its centre and its radius, as a pair or as four numbers."""
    if isinstance(value, (list, tuple)) and len(value) == 4:
        value = [value[:3], value[3]]
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise ParameterError(f"{what} must be its centre and its radius, [[x, y, z], radius], but one is {value!r}")
    return [_point(what, value[0]), positive(f"the radius of {what}", value[1])]


def _file(what: str, value: Any) -> str:
    """The path of a file."""
    try:
        path: str = os.fspath(value)
    except TypeError:
        raise ParameterError(f"{what} must be the path of a file, but one is {value!r}") from None
    return path


def _closed(what: str, value: Any) -> str:
    """The path of the file of a closed mesh."""
    if not isinstance(value, (str, os.PathLike)):
        raise ParameterError(f"{what} must be a mesh or the path of a file, but one is {value!r}")
    return _file(what, value)


def _painted(what: str, value: Any) -> dict[str, Any]:
    """A colour of vertices: red, green and blue from 0 to 1, and a tolerance. Or a text as on the command line, such as ``ff8000,20``."""
    if isinstance(value, str):
        return _hexadecimal(what, value)
    if not isinstance(value, Mapping) or "rgb" not in value or not set(value) <= {"rgb", "tolerance"}:
        raise ParameterError(
            f"{what} must be a text such as 'ff8000' or 'ff8000,20', or {{'rgb': [1, 0.5, 0], 'tolerance': 0.1}}, but one is {value!r}"
        )
    rgb, tolerance = _point(f"rgb of {what}", value["rgb"]), finite(f"the tolerance of {what}", value.get("tolerance", 0.0))
    if not all(0 <= part <= 1 for part in (*rgb, tolerance)):
        raise ParameterError(f"{what} must have numbers from 0 to 1, but one is {value!r}")
    return {"rgb": rgb, "tolerance": tolerance}


def _hexadecimal(what: str, text: str) -> dict[str, Any]:
    """A colour of six hexadecimal digits, optionally with a tolerance from 0 to 255."""
    found = re.fullmatch(r"#?([0-9a-fA-F]{6})(?:,\s*([0-9.]+))?", text.strip())
    try:
        digits, tolerance = (found[1], float(found[2] or 0)) if found else ("", 256.0)
    except ValueError:
        tolerance = 256.0
    if tolerance > 255:
        raise ParameterError(
            f"{what} needs six hexadecimal digits, optionally with a tolerance from 0 to 255, such as 'ff8000,20', but one is {text!r}"
        )
    return {"rgb": [part / 255 for part in bytes.fromhex(digits)], "tolerance": tolerance / 255}


def _name(what: str, value: Any) -> str:
    """A name."""
    if not isinstance(value, str):
        raise ParameterError(f"{what} must be a name, but is {value!r}")
    return value


# The parts of a mask whose items are paths, colours or names.
NAMED = ("inside", "face_files", "colours", "materials")
# The parts of a mask, with the validation of an item.
PARTS: dict[str, Callable[[str, Any], Any]] = {
    "boxes": _box, "balls": _ball, "inside": _closed, "faces": whole, "face_files": _file, "colours": _painted, "materials": _name,
    "grow": positive, "shrink": positive,
}  # fmt: skip


def _faces(mask: Any, faces: int, what: str = "the mask") -> dict[str, Any]:
    from isomend import _arrays

    return {"faces": _arrays.face_numbers(mask, faces, what)}


def unpacked(value: Any) -> Any:
    """A value with Python's numbers and lists in place of numpy's, also within dictionaries and lists."""
    if isinstance(value, Mapping):
        return {name: unpacked(part) for name, part in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [unpacked(part) for part in value]
    return value


Work = Union[dict[str, Any], list[Any]]


def as_json(work: Work) -> str:
    """Work or parameters as JSON. A `ParameterError` if a number is not finite or a type has no JSON form."""
    try:
        return json.dumps(work, allow_nan=False)
    except ValueError:
        raise ParameterError("parameters must be finite numbers; leave out what has no bound") from None
    except TypeError as error:
        raise ParameterError(f"a parameter has a type that is not supported: {error}") from None
