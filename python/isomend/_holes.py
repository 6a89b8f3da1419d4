"""The holes of a mesh, and the sharp edges that end at their rims."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from isomend._frozen import read_only
from isomend._reports import shortened

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, repr=False)
class Hole:
    """A hole: one closed loop of boundary edges. Lengths are in the units of the mesh.

    Attributes:
        id: Its number, from 1, in the order of falling length; ``holes``, ``keep_open``, ``flat`` and ``bridge`` take these numbers, or
            the holes themselves.
        rim: int64 (k,), read-only, its vertices in order, as indices into the mesh's vertices.
        edges: Number of edges.
        length: Length of the rim.
        diameter: Largest distance of two vertices of the rim.
        width: Five times the area over the length, at most the diameter: the diameter for a circle whose rim zigzags in the usual way.
        planarity: Root mean square distance of the rim from its best plane over the diameter; 0 is planar.
        height: Extent of the rim along its normal.
        centre: Mean of the rim (x, y, z).
        normal: Unit normal of the rim's best plane, pointing out of the surface.
        component: The connected component of the mesh that it bounds, from 0.
        is_outer_boundary: Whether it is probably the outer boundary of an open sheet, which is filled only if ``holes`` names it.
        object: The object of a 3MF file that it belongs to, and its part; None if the file has one object.
    """

    id: int
    rim: NDArray[Any]
    edges: int
    length: float
    diameter: float
    width: float
    planarity: float
    height: float
    centre: tuple[float, float, float]
    normal: tuple[float, float, float]
    component: int
    is_outer_boundary: bool
    object: str | None = None

    def __repr__(self) -> str:
        return shortened(self, {"rim": "vertices"})


@dataclass(frozen=True)
class CreaseEnd:
    """A vertex of a hole's rim at which a sharp edge of the mesh ends.

    Attributes:
        id: Its number, from 1; ``crease`` takes pairs of these numbers, or of the ends themselves.
        hole: The number of its hole.
        vertex: The vertex of the rim, as an index into the mesh's vertices.
        position: Its position (x, y, z).
        angle: Angle in degrees between the normals of the two smooth sides of the sharp edge.
    """

    id: int
    hole: int
    vertex: int
    position: tuple[float, float, float]
    angle: float


def crease_end_of(row: dict[str, Any]) -> CreaseEnd:
    return CreaseEnd(**{**row, "position": tuple(row["position"])})


def hole_of(row: dict[str, Any], rim: NDArray[Any]) -> Hole:
    names = ("id", "edges", "length", "diameter", "width", "planarity", "height", "component")
    own = {name: row[name] for name in names}
    own["object"] = row.get("object")
    centre, normal = tuple(row["centre"]), tuple(row["normal"])
    return Hole(rim=read_only(rim), centre=centre, normal=normal, is_outer_boundary=row["outer_boundary"], **own)
