"""The accessor of pyvista's meshes: ``mesh.isomend.fill()``. pyvista imports this module on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pyvista

from isomend._adapters import as_model, fair_mesh, fill_mesh, repair_mesh, restore_mesh
from isomend._foreign import triangles_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from isomend._check import Verdict
    from isomend._mesh import Inspection
    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask


@pyvista.register_dataset_accessor("isomend", pyvista.PolyData)
class Accessor:
    """The functions of isomend as methods of a ``pyvista.PolyData``."""

    def __init__(self, mesh: Any) -> None:
        self._mesh = mesh

    def inspect(self) -> Inspection:
        """Finds holes and defects; see :func:`isomend.inspect`."""
        import isomend

        mesh, faces = triangles_of(self._mesh)
        return isomend.inspect(mesh.points, faces)

    def check(
        self, *, thin: float | None = None, debris: float = 0.01, min_wall: float | None = None, threads: int | None = None
    ) -> Verdict:
        """Checks whether the mesh is watertight and can be printed; see :func:`isomend.check`."""
        return as_model(self._mesh).check(thin=thin, debris=debris, min_wall=min_wall, threads=threads)

    def repair(self, *, return_report: bool = False, **options: Unpack[RepairOptions]) -> Any:
        """The repaired mesh, with ``return_report`` the mesh and the report; see :func:`isomend.repair_mesh`."""
        return repair_mesh(self._mesh, return_report=return_report, **options)

    def fill(self, *, return_report: bool = False, **options: Unpack[FillOptions]) -> Any:
        """The mesh with its holes filled, with ``return_report`` the mesh and the report; see :func:`isomend.fill_mesh`."""
        return fill_mesh(self._mesh, return_report=return_report, **options)

    def restore(self, mark: Mask, *, return_report: bool = False, **options: Unpack[RestoreOptions]) -> Any:
        """The mesh with its marked faces replaced, with ``return_report`` the mesh and the report; see :func:`isomend.restore_mesh`."""
        return restore_mesh(self._mesh, mark, return_report=return_report, **options)

    def fair(self, mark: Mask | None = None, *, return_report: bool = False, **options: Unpack[FairOptions]) -> Any:
        """The faired mesh, with ``return_report`` the mesh and the report; see :func:`isomend.fair_mesh`."""
        return fair_mesh(self._mesh, mark, return_report=return_report, **options)
