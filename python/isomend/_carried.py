"""What results carry in the meshes of other packages: values of vertices, the report, expected errors; and results as trimesh meshes."""

from __future__ import annotations

import json
import logging
import re
from typing import Any

from isomend._reports import Report

LOG = logging.getLogger("isomend")
# The name of the report.
REPORT = "isomend_report"
# The name of the expected errors of vertices, as in files.
SIGMA = "isomend_sigma"
# Names of texture coordinates of vertices: of other packages, and of the files that are read.
TEXTURE = re.compile(r"(uvs?|st|texture|tex_?coords?|tcoords|texture[ _]coordinates)[ _]?\d*", re.IGNORECASE)


def values_of_vertices(mended: Any) -> tuple[dict[str, Any], list[str]]:
    """The named values of vertices for a mesh of another package, with expected errors; and remarks, which are also logged.

    Texture coordinates have no gaps, since other packages draw and write NaN as it is: a new vertex without any has those of the nearest
    vertex along the edges of the patches."""
    import numpy as np

    points, remarks = dict(mended.point_data), []
    for name, values in mended.point_data.items():
        if values.shape[1:] != (2,) or values.dtype.kind != "f" or not TEXTURE.fullmatch(name):
            continue
        points[name] = _without_gaps(values, mended)
        gaps = int(np.count_nonzero((np.isnan(values) & ~np.isnan(points[name])).any(axis=1)))
        if gaps:
            remarks.append(
                f"{name}: {gaps} new vertices have the texture coordinates of the nearest vertex of the rim, which stretches the texture "
                "between them; where OBJ, glTF and GLB files are written, isomend.read(path).fill().write(path) makes texels for such patches"
            )
    for remark in remarks:
        LOG.warning("%s", remark)
    return points | {SIGMA: expected_errors(mended)}, remarks


def _without_gaps(values: Any, mended: Any) -> Any:
    """Values of vertices, in which new vertices without values have those of their nearest vertex along the edges of the patches: zero
    if no vertex of their patch has values."""
    import numpy as np

    whole, gap, places = values.copy(), np.isnan(values).any(axis=1), mended.vertices
    kept = mended._core.kept_size()[0]
    known = ~gap[:kept]
    gap[:kept] = False
    # A patch across a seam has copies of the vertices of its rim. Each takes the values of the first vertex at its place.
    rim = np.flatnonzero(known & np.isin(places[:kept, 0], places[gap, 0]))
    at = {tuple(places[v]): v for v in rim[::-1].tolist()}
    for v in np.flatnonzero(gap).tolist():
        if (first := at.get(tuple(places[v]))) is not None:
            whole[v], gap[v] = whole[first], False
    faces = mended.faces[mended.is_patch]
    pairs = np.concatenate([faces[:, [i, j]] for i, j in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))])
    pairs = pairs[gap[pairs[:, 1]]]
    # One ring of vertices after another: in each round, values pass over edges from vertices with values to those without.
    while len(across := pairs[~gap[pairs[:, 0]]]):
        whole[across[:, 1]] = whole[across[:, 0]]
        gap[across[:, 1]] = False
        pairs = pairs[gap[pairs[:, 1]]]
    whole[gap] = 0
    return whole


def expected_errors(mended: Any) -> Any:
    """The expected error of each vertex as files have it: 0 for the input's vertices, unless an earlier run gave them one; -1 where it
    is unknown."""
    import numpy as np

    sigma = np.where(np.isnan(mended.sigma), -1.0, mended.sigma)
    earlier = mended.model().point_data.get(SIGMA)
    if earlier is not None and earlier.ndim == 1:
        kept = mended._core.kept_size()[0]
        sigma[:kept] = earlier[:kept]
    return sigma


def reported(mended: Any, remarks: list[str]) -> Report:
    """The report, whose notes also have what could not be continued on patches, and the remarks."""
    # Remarks on patches are in the rows of their regions.
    of_patches = {text for _, text in mended._core.messages()}
    notes = [*mended.report["notes"], *(note for note in mended.notes if note not in of_patches), *remarks]
    return Report({**mended.report, "notes": list(dict.fromkeys(notes))})


def to_trimesh(mended: Any) -> Any:
    """The mesh as a ``trimesh.Trimesh``; see :meth:`isomend.Mended.to_trimesh`."""
    import trimesh

    points, remarks = values_of_vertices(mended)
    cells: dict[str, Any] = dict(mended.cell_data)
    colours = {"vertex_colors": points.pop("vertex_colors", None), "face_colors": cells.pop("face_colors", None)}
    cells["isomend_patch"] = mended.is_patch
    return trimesh.Trimesh(
        vertices=mended.vertices, faces=mended.faces, vertex_attributes=points,
        face_attributes=cells, metadata={REPORT: json.dumps(reported(mended, remarks))}, process=False, validate=False,
        **{name: values for name, values in colours.items() if values is not None},
    )  # fmt: skip
