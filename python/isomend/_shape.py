"""The arrays of a mesh, and its files."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from isomend._frozen import read_only, values_of

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from isomend._isomend import Mended as CoreMended, Model as CoreModel

T = TypeVar("T")


class Shape:
    """The arrays of a mesh, made when first used. They are read-only: change a copy, and make a model of it by :class:`isomend.Model`."""

    _core: CoreModel | CoreMended
    _made: dict[str, Any]
    _given: tuple[Mapping[str, ArrayLike] | None, Mapping[str, ArrayLike] | None]

    def _once(self, name: str, make: Callable[[], T]) -> T:
        if name not in self._made:
            self._made[name] = make()
        made: T = self._made[name]
        return made

    @property
    def vertices(self) -> NDArray[Any]:
        """float64 (n, 3), read-only: coordinates in the units of the mesh. ``isomend.Model(2 * mesh.vertices, mesh.faces)`` is twice as large."""
        return self._once("vertices", lambda: read_only(self._core.vertices()))

    @property
    def faces(self) -> NDArray[Any]:
        """int64 (m, 3), read-only: vertex indices of each triangle, counter-clockwise from outside."""
        return self._once("faces", lambda: read_only(self._core.faces()))

    @property
    def point_data(self) -> dict[str, NDArray[Any]]:
        """Named values of vertices: (n,) or (n, k) each, in their own types, read-only."""
        return self._once("point_data", lambda: self._data(self._core.point_data(), self._given[0]))

    @property
    def cell_data(self) -> dict[str, NDArray[Any]]:
        """Named values of faces: (m,) or (m, k) each, in their own types, read-only."""
        return self._once("cell_data", lambda: self._data(self._core.cell_data(), self._given[1]))

    @property
    def corner_data(self) -> dict[str, NDArray[Any]]:
        """Named values of the corners of faces, such as texture coordinates with seams: (m, 3, k) each, read-only, NaN where a value
        is missing."""
        from isomend import _arrays

        rows = (self._core.size()[1], 3)
        return self._once("corner_data", lambda: values_of(_arrays.taken(self._core.corner_data(), rows)))

    @property
    def notes(self) -> list[str]:
        """Remarks: of the reader, on values that could not be continued on patches, and on patches that need attention."""
        return list(self._core.notes())

    @staticmethod
    def _data(values: Any, given: Mapping[str, ArrayLike] | None) -> dict[str, NDArray[Any]]:
        from isomend import _arrays

        return values_of(_arrays.restored_types(_arrays.taken(values), given))

    def write(
        self,
        path: str | os.PathLike[str],
        *,
        format: str | None = None,
        ascii: bool = False,
        report: str | os.PathLike[str] | None = None,
        picture: str | os.PathLike[str] | None = None,
    ) -> list[str]:
        """Writes the mesh with all of its values, atomically; the same bytes as from the command line.

        Args:
            path: The file. Its extension chooses the format: obj, ply, stl, gltf, glb, vtk, vtp, off, 3mf, usda or usdz.
            format: The format, whatever the extension.
            ascii: Text instead of binary: PLY, STL and VTK legacy.
            report: An HTML file with a 3D view, plots and tables of the written mesh.
            picture: A PNG file with a picture of it.

        Returns:
            Remarks, such as on values that the format cannot hold.

        Raises:
            FileError: A file cannot be written.
            ParameterError: There is no such format, or a page or picture has the name of another kind of file.
        """
        files = [None if file is None else os.fspath(file) for file in (report, picture)]
        return self._core.write(os.fspath(path), format, ascii, *files)[0]

    def to_bytes(self, format: str, *, ascii: bool = False) -> bytes:
        """The bytes of a file in a format; see :meth:`write`."""
        return self._core.write(None, format, ascii, None, None)[1]
