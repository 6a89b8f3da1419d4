"""The accessor of pyvista's meshes: ``mesh.isomend.fill()``. pyvista imports this when it is first asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pyvista

from isomend._adapters import as_model, fair_mesh, fill_mesh, repair_mesh, restore_mesh, triangles_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from isomend._check import Verdict
    from isomend._mesh import Inspection
    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask


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

    def check(
        self, *, thin: float | None = None, debris: float = 0.01, min_wall: float | None = None, threads: int | None = None
    ) -> Verdict:
        """Says whether the mesh is watertight and can be printed; see :func:`isomend.check`."""
        return as_model(self._mesh).check(thin=thin, debris=debris, min_wall=min_wall, threads=threads)

    def repair(self, *, return_report: bool = False, **options: Unpack[RepairOptions]) -> Any:
        """A mesh on which is mended what is wrong; see :func:`isomend.repair_mesh`."""
        return repair_mesh(self._mesh, return_report=return_report, **options)

    def fill(self, *, return_report: bool = False, **options: Unpack[FillOptions]) -> Any:
        """A mesh whose holes are filled, with ``return_report`` beside the report; see :func:`isomend.fill_mesh`."""
        return fill_mesh(self._mesh, return_report=return_report, **options)

    def restore(self, mark: Mask, *, return_report: bool = False, **options: Unpack[RestoreOptions]) -> Any:
        """A mesh whose marked faces are replaced; see :func:`isomend.restore`."""
        return restore_mesh(self._mesh, mark, return_report=return_report, **options)

    def fair(self, mark: Mask | None = None, *, return_report: bool = False, **options: Unpack[FairOptions]) -> Any:
        """A mesh that is faired; see :func:`isomend.fair`."""
        return fair_mesh(self._mesh, mark, return_report=return_report, **options)
