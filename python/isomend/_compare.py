"""Two meshes beside each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from isomend._reports import report_of


@dataclass(frozen=True)
class SurfaceFacts:
    """One mesh by itself.

    Attributes:
        vertices: Number of vertices.
        faces: Number of faces.
        area: Area in the units of the mesh squared.
        willmore_energy: Half the integral of h squared, h the sum of the principal curvatures: 8 pi for a sphere. Without the
            vertices of the border.
        border_vertices: Number of vertices of the border.
    """

    vertices: int
    faces: int
    area: float
    willmore_energy: float
    border_vertices: int


@dataclass(frozen=True)
class Distances:
    """Distances from samples of one mesh to another one, in the units of the meshes.

    Attributes:
        samples: Number of samples, spread evenly over the area.
        max: Largest distance of a sample or a vertex.
        max_at: Where it is (x, y, z).
        rms: Root mean square distance of the samples.
        mean: Mean distance of the samples.
        normal_mean: Mean angle between the normals at a sample and at its closest point, in degrees.
        normal_max: Largest such angle.
    """

    samples: int
    max: float
    max_at: tuple[float, float, float]
    rms: float
    mean: float
    normal_mean: float
    normal_max: float


@dataclass(frozen=True)
class Kept:
    """What of the first mesh is bit for bit in the second one.

    Attributes:
        vertices: Vertices whose position is that of a vertex of the second mesh.
        vertices_in_order: Vertices, from the first on, that have the same number in it.
        faces: Faces whose corners' positions are those of a face of it, in the same sense of rotation.
        faces_in_order: Faces, from the first on, with the same number and the same vertex numbers in it.
    """

    vertices: int
    vertices_in_order: int
    faces: int
    faces_in_order: int


@dataclass(frozen=True)
class Comparison:
    """Two meshes beside each other; see :func:`isomend.compare`.

    Attributes:
        a: The first mesh by itself.
        b: The second mesh by itself.
        a_to_b: Distances from samples of the first mesh to the second one.
        b_to_a: Distances from samples of the second mesh to the first one.
        kept: What of the first mesh is in the second one.
        report: What ``isomend compare --json -`` tells.
    """

    a: SurfaceFacts
    b: SurfaceFacts
    a_to_b: Distances
    b_to_a: Distances
    kept: Kept
    report: dict[str, Any]


def comparison(document: str) -> Comparison:
    """A comparison from its document."""
    report = report_of(document)
    a_to_b, b_to_a = (Distances(**dict(report[name], max_at=tuple(report[name]["max_at"]))) for name in ("a_to_b", "b_to_a"))
    facts = {name: SurfaceFacts(**report[name]) for name in ("a", "b")}
    return Comparison(**facts, a_to_b=a_to_b, b_to_a=b_to_a, kept=Kept(**report["kept"]), report=report)
