"""Volumes: values on the nodes of a box-shaped lattice, such as signed distances."""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from isomend import _isomend, _params
from isomend._errors import ParameterError
from isomend._frozen import read_only
from isomend._reports import report_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class Volume:
    """Values on the nodes of a lattice, from :func:`isomend.sdf`, :func:`isomend.read_volume` or an array.

    >>> import isomend
    >>> import numpy as np
    >>> x, y, z = np.meshgrid(*[np.linspace(-1, 1, 9)] * 3, indexing="ij")
    >>> ball = isomend.Volume(x**2 + y**2 + z**2, origin=(-1, -1, -1), spacing=0.25)
    >>> ball
    <isomend.Volume of 9 x 9 x 9 nodes>
    >>> bool(isomend.surface(ball, level=0.5).check())
    True
    """

    def __init__(
        self,
        values: ArrayLike,
        origin: Iterable[float] = (0.0, 0.0, 0.0),
        spacing: float | Iterable[float] = 1.0,
    ) -> None:
        """A volume from an array.

        Args:
            values: (nx, ny, nz), numbers: ``values[i, j, k]`` belongs to the node at ``origin + spacing * (i, j, k)``.
            origin: Position of the first node.
            spacing: Distance of neighbouring nodes, positive; one number, or one for each axis.

        Raises:
            ParameterError: The array has another shape or type, or ``origin`` or ``spacing`` is not valid.
        """
        import numpy as np

        from isomend import _arrays

        array = _arrays.unmasked("values", values)
        if array.ndim != 3 or array.dtype.kind not in "biuf":
            raise ParameterError(
                f"values must be numbers in an array of the shape (nx, ny, nz), but its shape is {array.shape} and its type {array.dtype}"
            )
        steps = _three("spacing", spacing if isinstance(spacing, Iterable) else (spacing,) * 3)
        for step in steps:
            _params.positive("spacing", step)
        flat = np.asarray(array, dtype=np.float64).ravel(order="F")
        self._core: _isomend.Volume = _isomend.Volume.from_arrays(flat, list(array.shape), _three("origin", origin), steps)

    @classmethod
    def _of(cls, core: _isomend.Volume) -> Volume:
        volume = cls.__new__(cls)
        volume._core = core
        return volume

    def __repr__(self) -> str:
        return f"<isomend.Volume of {' x '.join(map(str, self.dims))} nodes>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the values, the origin and the spacing, without the report."""
        return _volume, (self.values, self.origin, self.spacing)

    @property
    def values(self) -> NDArray[Any]:
        """float64 (nx, ny, nz), read-only: ``values[i, j, k]`` belongs to the node at ``origin + spacing * (i, j, k)``. Change a copy, and make a
        volume of it by :class:`isomend.Volume`."""
        return read_only(self._core.values().reshape(self.dims, order="F"))

    @property
    def dims(self) -> tuple[int, int, int]:
        """Number of nodes along x, y and z."""
        x, y, z = self._core.dims()
        return x, y, z

    @property
    def origin(self) -> tuple[float, float, float]:
        """Position of the first node."""
        x, y, z = self._core.origin()
        return x, y, z

    @property
    def spacing(self) -> tuple[float, float, float]:
        """Distance of neighbouring nodes along x, y and z."""
        x, y, z = self._core.spacing()
        return x, y, z

    @property
    def report(self) -> dict[str, Any] | None:
        """The JSON document of ``isomend sdf --json -`` as a dictionary; None unless the volume comes from :func:`isomend.sdf`."""
        document = self._core.document()
        return None if document is None else report_of(document)

    def write(self, path: str | os.PathLike[str], *, array: str = "distance", f64: bool = False) -> None:
        """Writes a VTI file, compressed with zlib: the same bytes as the command line's. If it fails, no partial file is left.

        Args:
            path: The file; its name must end in ``.vti``.
            array: Name of the values in the file.
            f64: Write 64-bit floats instead of 32-bit floats.

        Raises:
            FileError: The file cannot be written, or a value is not finite or too large for the type.
            ParameterError: The name does not end in ``.vti``.
        """
        name = os.fspath(path)
        if not name.lower().endswith(".vti"):
            raise ParameterError(f"volumes are written as VTI: end the name {name} in .vti")
        self._core.write(name, array, f64)

    def to_bytes(self, *, array: str = "distance", f64: bool = False) -> bytes:
        """The bytes of a VTI file; see :meth:`write`."""
        return self._core.write(None, array, f64)


def _three(name: str, values: Iterable[float]) -> list[float]:
    """Three finite numbers."""
    if not isinstance(values, Iterable) or isinstance(values, (str, bytes)):
        raise ParameterError(f"{name} must be three numbers, but is {values!r}")
    numbers = [_params.number(name, value) for value in values]
    if len(numbers) != 3 or not all(abs(number) < float("inf") for number in numbers):
        raise ParameterError(f"{name} must be three finite numbers, but is {numbers}")
    return numbers


def _volume(values: Any, origin: Any, spacing: Any) -> Volume:
    return Volume(values, origin, spacing)
