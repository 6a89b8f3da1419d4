"""The verdict of a check: whether a mesh is watertight and printable, and its defects."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from isomend import _isomend
from isomend._frozen import read_only
from isomend._reports import Drawn, report_of, shortened

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False, repr=False)
class Defect:
    """All defects of one kind.

    Attributes:
        kind: ``boundary_edge`` (edges with one face only), ``non_manifold_edge``, ``non_manifold_vertex``, ``misoriented``, ``inside_out``,
            ``degenerate``, ``duplicate``, ``self_intersection`` (faces that intersect others), ``thin`` or ``thin_wall``.
        count: Number of edges, vertices, faces or components with the defect, depending on the kind.
        faces: int64 (k,), read-only, indices of the faces at the defects, ascending.
        places: float64 (p, 3), read-only, the centre of each connected group of these faces, in the units of the mesh.
    """

    kind: str
    count: int
    faces: NDArray[Any]
    places: NDArray[Any]

    def __repr__(self) -> str:
        return shortened(self, {"faces": "faces", "places": "places"})


class Defects(dict[str, Defect]):
    """The defects found, by kind. Of a kind that was not found, ``defects[kind]`` has the count 0."""

    def __missing__(self, kind: str) -> Defect:
        import numpy as np

        kinds = _isomend.defect_kinds()
        if kind not in kinds:
            raise KeyError(f"there is no kind of defect {kind!r}; there are {', '.join(kinds)}")
        return Defect(kind, 0, read_only(np.zeros(0, np.int64)), read_only(np.zeros((0, 3))))


class Verdict(Drawn):
    """The verdict of a check. It is true if no defect was found: the mesh is watertight and can be printed.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> verdict = isomend.check(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    >>> bool(verdict), verdict.reasons, verdict.defects["boundary_edge"].faces.tolist()
    (False, ['1 hole is open'], [0, 1, 2])
    """

    def __init__(self, core: _isomend.Checked, again: tuple[Any, Mapping[str, Any]]) -> None:
        self._core: _isomend.Checked = core
        # The model and the options: unpickling repeats the check with them.
        self._again = again
        #: The JSON document of ``isomend check --json -`` as a dictionary; lists in it have at most a thousand entries.
        self.report: dict[str, Any] = report_of(core.document())
        #: Whether no defect was found: the mesh is watertight and can be printed.
        self.sound: bool = self.report["sound"]
        #: Why the mesh is not sound, one phrase for each reason.
        self.reasons: list[str] = self.report["reasons"]
        #: Whether every edge is in exactly two faces.
        self.watertight: bool = self.report["watertight"]
        #: Whether no edge is in one face only.
        self.closed: bool = self.report["closed"]
        #: Whether no edge has more than two faces, and the faces at each vertex are connected through edges.
        self.manifold: bool = self.report["manifold"]
        #: Whether the two faces of every edge run through it in opposite directions.
        self.oriented: bool = self.report["oriented"]
        #: The walls of closed components: the ``least`` and the ``mean`` thickness in the mesh's units, the number of the ``component``
        #: with the thinnest wall, from 1 in the order of first faces, and its position (``at``). None if there are no walls.
        self.walls: dict[str, Any] | None = self.report["walls"]
        #: The defects found, by kind, with all their faces and places. ``defects[kind]`` of a kind that was not found has the count 0.
        self.defects: Defects = Defects((row[0], Defect(*row[:2], *map(read_only, row[2:]))) for row in core.defects())

    def __bool__(self) -> bool:
        return self.sound

    def __str__(self) -> str:
        """The lines that ``isomend check`` prints."""
        return "\n".join(self._core.lines())

    def __repr__(self) -> str:
        return f"<isomend.Verdict: {self._core.lines()[0]}>"

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the mesh and the options; unpickling repeats the check."""
        return _checked_again, self._again


def _checked_again(model: Any, options: Mapping[str, Any]) -> Any:
    return model.check(**options)
