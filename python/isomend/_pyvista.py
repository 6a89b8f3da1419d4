"""The accessor of pyvista's meshes: ``mesh.isomend.fill()``. pyvista imports this when it is first asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pyvista

from isomend._adapters import mend_mesh

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from isomend._mesh import Inspection
    from isomend._params import FairOptions, FillOptions, Mask, RestoreOptions


@pyvista.register_dataset_accessor("isomend", pyvista.PolyData)
class Accessor:
    """isomend for a ``pyvista.PolyData``."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh

    def inspect(self) -> Inspection:
        """Finds holes and defects; see :func:`isomend.inspect`."""
        import isomend

        mesh = self._mesh if self._mesh.is_all_triangles else self._mesh.triangulate()
        return isomend.inspect(mesh.points, mesh.regular_faces)

    def fill(self, **options: Unpack[FillOptions]) -> Any:
        """A mesh whose holes are filled; see :func:`isomend.fill`."""
        return mend_mesh(self._mesh, lambda model: model.fill(**options))

    def restore(self, mark: Mask, **options: Unpack[RestoreOptions]) -> Any:
        """A mesh whose marked faces are replaced; see :func:`isomend.restore`."""
        return mend_mesh(self._mesh, lambda model: model.restore(mark, **options))

    def fair(self, mark: Mask | None = None, **options: Unpack[FairOptions]) -> Any:
        """A mesh that is faired; see :func:`isomend.fair`."""
        return mend_mesh(self._mesh, lambda model: model.fair(mark, **options))
