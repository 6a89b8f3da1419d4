"""Parameters: from keywords to the JSON that the library reads. Names, defaults and bounds are the library's."""

from __future__ import annotations

import json
import operator
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Union

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


class SolveOptions(RunOptions, total=False):
    """The parameters that all works with patches have."""

    voxel: Voxel
    finish: Literal["auto", "willmore", "none"]
    energy: Literal["willmore", "curvature-variation"]
    variant: Literal["I", "II", "gauss-newton"]
    steps: int | None
    time_step: float | None
    edge_ratio: float | None


class FillOptions(SolveOptions, total=False):
    """The parameters of a fill; see :func:`isomend.fill`."""

    holes: Iterable[int] | None
    keep_open: Iterable[int]
    bridge: Iterable[Iterable[int]]
    flat: Iterable[int]
    max_diameter: float | None
    surface: Literal["stitched", "whole"]
    repair: bool


class RepairOptions(SolveOptions, total=False):
    """The parameters of a repair; see :func:`isomend.repair`."""

    weld: float | None
    debris: float | None
    drop_inside: bool
    keep_duplicates: bool
    keep_orientation: bool
    keep_non_manifold: bool
    keep_crossings: bool
    drop_unused: bool
    keep_holes: bool
    close_borders: bool
    max_diameter: float | None


class RestoreOptions(SolveOptions, total=False):
    """The parameters of a restoration; see :func:`isomend.restore`."""

    keep_shape: float
    keep_vertices: bool


class FairOptions(RunOptions, total=False):
    """The parameters of a fairing; see :func:`isomend.fair`."""

    strength: float | None
    time: float | None
    voxel: Voxel
    variant: Literal["I", "II", "gauss-newton"]
    edge_ratio: float | None
    keep_vertices: bool


CHOICES = {
    "surface": ("stitched", "whole"),
    "finish": ("auto", "willmore", "none"),
    "energy": ("willmore", "curvature-variation"),
    "variant": ("I", "II", "gauss-newton"),
}

RUN = ("threads", "progress", "strict")

# The flags of a repair: what the library calls the step, and whether the flag leaves it out.
REPAIR_FLAGS = {
    "drop_inside": ("drop_inside", False),
    "keep_duplicates": ("clean", True),
    "keep_orientation": ("orient", True),
    "keep_non_manifold": ("split", True),
    "keep_crossings": ("crossings", True),
    "drop_unused": ("drop_unused", False),
    "keep_holes": ("holes", True),
    "close_borders": ("borders", False),
}


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


def within(name: str, value: Any, least: float, most: float) -> float:
    """A number between two bounds."""
    given = number(name, value)
    if not least <= given <= most:
        raise ParameterError(f"{name} must lie between {least:g} and {most:g}, but is {given:g}")
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


def band(value: Any) -> float | None:
    """The length at which distances are cut off; none for ``"full"``."""
    return None if isinstance(value, str) and value == "full" else positive("band", value)


def wholes(name: str, values: Any) -> list[int]:
    """A list of whole numbers."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise ParameterError(f"{name} must be a list of hole numbers, but is {values!r}")
    return [whole(name, value) for value in values]


def plain(name: str, value: Any) -> Any:
    """A parameter in the library's form."""
    if name in ("holes", "keep_open", "flat"):
        return wholes(name, value)
    if name == "bridge":
        return [wholes("each group of bridge", group) for group in value]
    if name == "voxel":
        return value if isinstance(value, str) and value == "auto" else {"length": positive(name, value)}
    if name in ("max_diameter", "time_step", "strength", "time", "weld", "thin"):
        return positive(name, value)
    if name == "edge_ratio":
        return within(name, value, 0.05, 20.0)
    if name in ("keep_shape", "debris"):
        return within(name, value, 0.0, 1.0)
    if name == "steps":
        return count(name, value)
    if name in CHOICES:
        return choice(name, value, CHOICES[name])
    return value


def plain_all(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters in the library's form; those that are ``None`` are left to it."""
    return {name: plain(name, value) for name, value in parameters.items() if value is not None}


def _without_repair(parameters: Mapping[str, Any]) -> tuple[dict[str, Any], bool]:
    """The parameters of a fill in the library's form, and whether the rest is to be repaired first."""
    rest = dict(parameters)
    repairs = flag("repair", rest.pop("repair", False))
    return plain_all(rest), repairs


def fill_work(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The work of a fill, which may be one that repairs the rest first."""
    fill, repairs = _without_repair(parameters)
    return {"repair": {"fill": fill}} if repairs else {"fill": fill}


def region_params(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a fill region by region, which repairs nothing else."""
    fill, repairs = _without_repair(parameters)
    if repairs:
        raise ParameterError("regions are those of a fill: call repair() first, or fill(…, repair=True) for both in one")
    return fill


def repair_params(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a repair, those of its fill among them."""
    given = plain_all(parameters)
    flags = {name: flag(name, given.pop(name)) for name in REPAIR_FLAGS if name in given}
    if flags.get("keep_holes") and flags.get("close_borders"):
        raise ParameterError("keep_holes leaves open what close_borders closes; give one of them")
    steps: dict[str, Any] = {REPAIR_FLAGS[name][0]: value != REPAIR_FLAGS[name][1] for name, value in flags.items()}
    own = {name: given.pop(name) for name in ("weld", "debris") if name in given}
    return steps | own | {"fill": given}


def restore_params(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a restoration, those of its fill among them."""
    own = ("keep_shape", "keep_vertices")
    given = plain_all(parameters)
    fill = {name: value for name, value in given.items() if name not in own}
    return {name: given[name] for name in own if name in given} | {"fill": fill}


def fair_params(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The parameters of a fairing."""
    given = plain_all(parameters)
    extents = {name: given.pop(name) for name in ("time", "strength") if name in given}
    if len(extents) > 1:
        raise ParameterError("time and strength say the same in two ways; give one of them")
    return given | ({"extent": extents} if extents else {})


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
