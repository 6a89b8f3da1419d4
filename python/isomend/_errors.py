"""The exceptions of isomend."""

from __future__ import annotations


class IsomendError(Exception):
    """What all exceptions of isomend are."""


class MeshError(IsomendError, ValueError):
    """A mesh that cannot be measured: without faces, with indices out of range, with coordinates that are not finite."""


class HoleIdError(IsomendError, IndexError):
    """The number of a hole that the mesh does not have."""


class EmptyMaskError(IsomendError, ValueError):
    """A mask that marks no face."""


class ParameterError(IsomendError, ValueError):
    """A parameter that makes no sense, or does not go with the mesh."""


class FileError(IsomendError, OSError):
    """A file that cannot be read or written, or whose content is damaged."""


class Cancelled(IsomendError):
    """The progress function asked to stop."""
