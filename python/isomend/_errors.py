"""The exceptions of isomend."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class IsomendError(Exception):
    """Base class of all exceptions of isomend."""

    __module__ = "isomend"


class MeshError(IsomendError, ValueError):
    """A mesh that is not valid: it has no faces, vertex indices out of range, or coordinates that are not finite."""

    __module__ = "isomend"


class MeshTypeError(IsomendError, TypeError):
    """An argument that is no mesh of a type that the function takes."""

    __module__ = "isomend"


class HoleIdError(IsomendError, IndexError):
    """A hole number that the mesh does not have."""

    __module__ = "isomend"


class EmptyMaskError(IsomendError, ValueError):
    """A mask that marks no face."""

    __module__ = "isomend"


class ParameterError(IsomendError, ValueError):
    """A parameter that is not valid, by itself or for this mesh."""

    __module__ = "isomend"


class FileError(IsomendError, OSError):
    """A file that cannot be read or written, or has damaged content. ``filename`` names it, and ``errno`` is the
    system's number of the error; both are ``None`` where they are not known."""

    __module__ = "isomend"

    def __str__(self) -> str:
        """The message; Python's own text of a file error would replace it."""
        return " ".join(str(part) for part in self.args)


class Cancelled(IsomendError):
    """The run was stopped: the progress function returned ``False``."""

    __module__ = "isomend"


# What messages on files advise on the command line, and what in Python.
FUNCTIONS = {
    "'isomend surface' extracts its zero level": "isomend.read_volume reads it, isomend.surface extracts its zero level",
    "STRUCTURED_POINTS, not a surface; extract a surface first and save it as POLYDATA": (
        "STRUCTURED_POINTS, not a surface; it is a volume: isomend.read_volume reads it, isomend.surface extracts its zero level"
    ),
    "'isomend surface' and 'isomend sdf' turn": "isomend.surface and isomend.sdf turn",
}


@contextmanager
def functions_named() -> Iterator[None]:
    """Within it, file errors name functions of Python where they would name commands."""
    try:
        yield
    except FileError as error:
        error.args = tuple(_with_functions(part) for part in error.args)
        raise


def _with_functions(part: object) -> object:
    for command, function in FUNCTIONS.items():
        part = part.replace(command, function) if isinstance(part, str) else part
    return part
