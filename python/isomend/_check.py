"""Verdicts on meshes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from isomend import _isomend
from isomend._reports import Drawn, report_of

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Defect:
    """All defects of a kind.

    Attributes:
        kind: ``border``, ``non_manifold_edge``, ``non_manifold_vertex``, ``misoriented``, ``inside_out``, ``degenerate``,
            ``duplicate``, ``crossing``, ``thin`` or ``thin_wall``.
        count: Number of edges, vertices, faces or components that have it, by the kind.
        faces: int64 (k,), the faces at them, in rising order.
        places: float64 (p, 3), the middle of each connected group of these faces, in the units of the mesh.
    """

    kind: str
    count: int
    faces: NDArray[Any]
    places: NDArray[Any]


class Verdict(Drawn):
    """What is wrong with a mesh. It is true where nothing is: the mesh is watertight and can be printed.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> verdict = isomend.check(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    >>> bool(verdict), verdict.reasons, verdict.defects["border"].faces.tolist()
    (False, ['1 hole is open'], [0, 1, 2])
    """

    def __init__(self, core: _isomend.Checked, again: tuple[Any, Mapping[str, Any]]) -> None:
        self._core: _isomend.Checked = core
        # The model and the options, with which a verdict that was pickled is made again.
        self._again = again
        #: What ``isomend check --json -`` tells; lists in it end after a thousand entries.
        self.report: dict[str, Any] = report_of(core.document())
        #: Whether nothing is wrong: the mesh is watertight and can be printed.
        self.sound: bool = self.report["sound"]
        #: Why it is not, in words.
        self.reasons: list[str] = self.report["reasons"]
        #: Whether every edge is in exactly two faces.
        self.watertight: bool = self.report["watertight"]
        #: Whether no edge is in one face only.
        self.closed: bool = self.report["closed"]
        #: Whether no edge has more than two faces, and surfaces meet nowhere in a point only.
        self.manifold: bool = self.report["manifold"]
        #: Whether all edges of two faces run through them in opposite directions.
        self.oriented: bool = self.report["oriented"]
        #: The walls of closed components: the ``least`` and the ``mean`` thickness in the mesh's units, the number of the ``component``
        #: with the least, from 1 in the order of their first faces, and where it is (``at``). None where there are no walls.
        self.walls: dict[str, Any] | None = self.report["walls"]
        #: The kinds of defects that there are, by name, with all their faces and places.
        self.defects: dict[str, Defect] = {row[0]: Defect(*row) for row in core.defects()}

    def __bool__(self) -> bool:
        return self.sound

    def __str__(self) -> str:
        """The lines that ``isomend check`` prints."""
        return "\n".join(self._core.lines())

    def __repr__(self) -> str:
        return f"<isomend.Verdict: {self._core.lines()[0]}>"

    def __reduce__(self) -> tuple[Any, ...]:
        """A verdict goes through pickle as its mesh, which is checked again."""
        return _checked_again, self._again


def _checked_again(model: Any, options: Mapping[str, Any]) -> Any:
    return model.check(**options)
