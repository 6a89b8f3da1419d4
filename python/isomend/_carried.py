"""What results carry in the meshes of other packages: values of vertices, the report, expected errors; and results as trimesh meshes."""

from __future__ import annotations

import json
import logging
import re
from collections.abc import Mapping
from typing import Any

from isomend._remarks import beside_patches
from isomend._reports import Report

LOG = logging.getLogger("isomend")
# The name of the report.
REPORT = "isomend_report"
# The name of the expected errors of vertices, as in files.
SIGMA = "isomend_sigma"
# Names of texture coordinates of vertices: of other packages, and of the files that are read.
TEXTURE = re.compile(r"(uvs?|st|texture|tex_?coords?|tcoords|texture[ _]coordinates)[ _]?\d*", re.IGNORECASE)


def copied(data: Mapping[str, Any]) -> dict[str, Any]:
    """Copies of named values: the values of results are read-only, but what is in the mesh of another package belongs to the caller."""
    return {name: values.copy() for name, values in data.items()}


def values_of_vertices(mended: Any) -> tuple[dict[str, Any], list[str]]:
    """The named values of vertices for a mesh of another package, with expected errors; and remarks, which are also logged.

    Texture coordinates have no gaps, since other packages draw and write NaN as it is: a new vertex without any has the coordinates of
    the nearest vertex of the rim."""
    import numpy as np

    points, remarks = copied(mended.point_data), []
    for name, values in mended.point_data.items():
        if values.shape[1:] != (2,) or values.dtype.kind != "f" or not TEXTURE.fullmatch(name):
            continue
        points[name] = _without_gaps(values, mended)
        gaps = int(np.count_nonzero((np.isnan(values) & ~np.isnan(points[name])).any(axis=1)))
        if gaps:
            remarks.append(
                f"{name}: {gaps} new vertices have the texture coordinates of the nearest vertex of the rim in one chart of the "
                "texture; where OBJ, glTF and GLB files are written, isomend.read(path).fill().write(path) makes texels for such patches"
            )
    for remark in remarks:
        LOG.warning("%s", remark)
    return points | {SIGMA: expected_errors(mended)}, remarks


def _without_gaps(values: Any, mended: Any) -> Any:
    """Texture coordinates of vertices, in which new vertices without any have the coordinates of their nearest vertex along the edges of the
    patches: zero if no vertex of their patch has any. All come from one chart of the texture, so that faces of a patch do not run across charts."""
    import numpy as np

    whole, gap = values.copy(), np.isnan(values).any(axis=1)
    gap[: mended._core.kept_size()[0]] = False
    if not gap.any():
        return whole
    for vertex, source in _sources(gap, np.isnan(values).any(axis=1), mended).items():
        whole[vertex], gap[vertex] = values[source], False
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


def _sources(gap: Any, unknown: Any, mended: Any) -> dict[int, int]:
    """A patch across a seam has copies of the vertices of its rim: for each copy in `gap` the vertex of the input at its place, where that is
    in the chart of the texture to which most of the patch's rim belongs."""
    import numpy as np

    places, kept = mended.vertices, mended._core.kept_size()[0]
    rim = np.flatnonzero(~unknown[:kept] & np.isin(places[:kept, 0], places[gap, 0]))
    at: dict[tuple[float, ...], list[int]] = {}
    for vertex in rim.tolist():
        at.setdefault(tuple(places[vertex]), []).append(vertex)
    # A chart is a part of the mesh that is connected by the indices of its vertices.
    chart = _connected(len(places), mended.faces[~mended.is_patch])
    patch = _connected(len(places), mended.faces[mended.is_patch])
    found: dict[int, dict[int, dict[int, int]]] = {}
    for vertex in np.flatnonzero(gap).tolist():
        for source in at.get(tuple(places[vertex]), []):
            found.setdefault(int(patch[vertex]), {}).setdefault(int(chart[source]), {}).setdefault(vertex, source)
    largest = [max(charts.values(), key=len) for charts in found.values()]
    return {vertex: source for sources in largest for vertex, source in sources.items()}


def _connected(vertices: int, faces: Any) -> Any:
    """For each vertex the lowest index of a vertex of its connected component."""
    import numpy as np

    low, ends = np.arange(vertices), np.concatenate([faces[:, :2], faces[:, 1:]])
    while True:
        before = low.copy()
        # The lower end of each edge for both; then each vertex takes the index of its index, which halves the ways.
        np.minimum.at(low, before[ends[:, 0]], before[ends[:, 1]])
        np.minimum.at(low, before[ends[:, 1]], before[ends[:, 0]])
        low = low[low]
        if np.array_equal(low, before):
            return low


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
    notes = [*mended.report["notes"], *beside_patches(mended, mended._core.messages()), *remarks]
    return Report({**mended.report, "notes": list(dict.fromkeys(notes))})


def to_trimesh(mended: Any) -> Any:
    """The mesh as a ``trimesh.Trimesh``; see :meth:`isomend.Mended.to_trimesh`."""
    import trimesh

    points, remarks = values_of_vertices(mended)
    cells = copied(mended.cell_data)
    colours = {"vertex_colors": points.pop("vertex_colors", None), "face_colors": cells.pop("face_colors", None)}
    cells["isomend_patch"] = mended.is_patch.copy()
    return trimesh.Trimesh(
        vertices=mended.vertices.copy(), faces=mended.faces.copy(), vertex_attributes=points,
        face_attributes=cells, metadata={REPORT: json.dumps(reported(mended, remarks))}, process=False, validate=False,
        **{name: values for name, values in colours.items() if values is not None},
    )  # fmt: skip
