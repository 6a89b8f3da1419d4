"""What results carry in the meshes of other packages: the report and expected errors, by their names; and results as trimesh meshes."""

from __future__ import annotations

import json
from typing import Any

# The name of the report.
REPORT = "isomend_report"
# The name of the expected errors of vertices, as in files.
SIGMA = "isomend_sigma"


def expected_errors(mended: Any) -> dict[str, Any]:
    """The expected error of each vertex as files have it, by its name: 0 for the input's vertices, -1 where it is unknown. Empty if no
    patch has one."""
    import numpy as np

    sigma = mended.sigma
    if not np.any(sigma > 0):
        return {}
    return {SIGMA: np.where(np.isnan(sigma), -1.0, sigma)}


def to_trimesh(mended: Any) -> Any:
    """The mesh as a ``trimesh.Trimesh``; see :meth:`isomend.Mended.to_trimesh`."""
    import trimesh

    points: dict[str, Any] = dict(mended.point_data) | expected_errors(mended)
    cells: dict[str, Any] = dict(mended.cell_data)
    colours = {"vertex_colors": points.pop("vertex_colors", None), "face_colors": cells.pop("face_colors", None)}
    cells["isomend_patch"] = mended.is_patch
    return trimesh.Trimesh(
        vertices=mended.vertices, faces=mended.faces, vertex_attributes=points,
        face_attributes=cells, metadata={REPORT: json.dumps(mended.report)}, process=False, validate=False,
        **{name: values for name, values in colours.items() if values is not None},
    )  # fmt: skip
