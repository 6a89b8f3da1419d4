"""The result of a comparison of two meshes: distances, normals, areas, bending energies, kept vertices and faces."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from isomend._reports import report_of


@dataclass(frozen=True)
class SurfaceFacts:
    """Measurements of one mesh.

    Attributes:
        vertices: Number of vertices.
        faces: Number of faces.
        area: Area in the units of the mesh squared.
        willmore_energy: Half the integral of h squared, h the sum of the principal curvatures: 8 pi for a sphere. Vertices on the
            mesh's boundary are left out.
        boundary_vertices: Number of vertices on the boundary: on edges with one face only.
    """

    vertices: int
    faces: int
    area: float
    willmore_energy: float
    boundary_vertices: int


@dataclass(frozen=True)
class Distances:
    """Distances from samples on one mesh to the other mesh, in the units of the meshes.

    Attributes:
        samples: Number of samples, spread evenly over the area.
        max: Largest distance of a sample or a vertex.
        max_at: The position (x, y, z) of this sample or vertex.
        rms: Root mean square distance of the samples.
        mean: Mean distance of the samples.
        normal_mean: Mean angle between the normals at a sample and at its closest point, in degrees.
        normal_max: Largest of these angles, in degrees.
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
    """Number of vertices and faces of the first mesh that the second mesh has bit for bit.

    Attributes:
        vertices: Vertices at whose position the second mesh has a vertex.
        vertices_in_order: Leading vertices that have the same index in the second mesh.
        faces: Faces with the same corner positions, in the same orientation, as a face of the second mesh.
        faces_in_order: Leading faces that have the same index and the same vertex indices in the second mesh.
    """

    vertices: int
    vertices_in_order: int
    faces: int
    faces_in_order: int


@dataclass(frozen=True, repr=False)
class Comparison:
    """The comparison of two meshes; see :func:`isomend.compare`. It prints as a table.

    Attributes:
        a: Measurements of the first mesh.
        b: Measurements of the second mesh.
        a_to_b: Distances from samples on the first mesh to the second mesh.
        b_to_a: Distances from samples on the second mesh to the first mesh.
        kept: Vertices and faces of the first mesh that the second mesh has.
        report: The JSON document of ``isomend compare --json -`` as a dictionary.
    """

    a: SurfaceFacts
    b: SurfaceFacts
    a_to_b: Distances
    b_to_a: Distances
    kept: Kept
    report: dict[str, Any]
    _lines: tuple[str, ...] = field(default=(), compare=False)

    def __repr__(self) -> str:
        # Distances far below the size of the meshes are rounding errors.
        rounding = 1e-12 * max(self.a.area, self.b.area) ** 0.5
        a, b = (0.0 if each.max < rounding else each.max for each in (self.a_to_b, self.b_to_a))
        kept = f"{self.kept.faces} of {self.a.faces} faces of A are in B"
        return f"<isomend.Comparison: A to B at most {a:.4g}, B to A at most {b:.4g}; {kept}>"

    def __str__(self) -> str:
        """Sizes, distances in both directions, and what of A is kept in B, as a table."""
        return "\n".join(self._lines)


def comparison(document: str, lines: list[str]) -> Comparison:
    """A comparison from its JSON document and its table."""
    report = report_of(document)
    a_to_b, b_to_a = (Distances(**dict(report[name], max_at=tuple(report[name]["max_at"]))) for name in ("a_to_b", "b_to_a"))
    facts = {name: SurfaceFacts(**report[name]) for name in ("a", "b")}
    return Comparison(**facts, a_to_b=a_to_b, b_to_a=b_to_a, kept=Kept(**report["kept"]), report=report, _lines=tuple(lines))
