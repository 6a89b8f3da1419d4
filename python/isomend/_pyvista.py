"""The accessor of pyvista's meshes: ``mesh.isomend.fill()``. pyvista imports this when it is first asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pyvista

from isomend._adapters import mend_mesh, triangles_of

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

        mesh, faces = triangles_of(self._mesh)
        return isomend.inspect(mesh.points, faces)

    def fill(self, *, return_report: bool = False, **options: Unpack[FillOptions]) -> Any:
        """A mesh whose holes are filled, with ``return_report`` beside the report; see :func:`isomend.fill_mesh`."""
        return mend_mesh(self._mesh, lambda model: model.fill(**options), return_report)

    def restore(self, mark: Mask, *, return_report: bool = False, **options: Unpack[RestoreOptions]) -> Any:
        """A mesh whose marked faces are replaced; see :func:`isomend.restore`."""
        return mend_mesh(self._mesh, lambda model: model.restore(mark, **options), return_report)

    def fair(self, mark: Mask | None = None, *, return_report: bool = False, **options: Unpack[FairOptions]) -> Any:
        """A mesh that is faired; see :func:`isomend.fair`."""
        return mend_mesh(self._mesh, lambda model: model.fair(mark, **options), return_report)
