"""Meshes, inspections and mended meshes."""

from __future__ import annotations

import contextlib
import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, NoReturn

from isomend import _isomend, _params
from isomend._check import Verdict
from isomend._errors import EmptyMaskError, IsomendError, ParameterError, functions_named
from isomend._files import in_files
from isomend._foreign import model_of_other
from isomend._frozen import read_only
from isomend._holes import CreaseEnd, Hole, crease_end_of, hole_of
from isomend._isomend import Found, Mended as CoreMended, Model as CoreModel
from isomend._remarks import incomplete, not_continued
from isomend._reports import Drawn, report_of
from isomend._shape import Shape
from isomend._volume import Volume

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Unpack

    from isomend._options import FairOptions, FillOptions, RepairOptions, RestoreOptions
    from isomend._params import Mask, Voxel

LOG = logging.getLogger("isomend")


class Model(Shape):
    """A mesh with its named values and materials, from :func:`isomend.read` or from arrays. It can be pickled without loss.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> model = isomend.Model(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    >>> [hole.length > 4 for hole in model.inspect().holes]
    [True]
    """

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        point_data: Mapping[str, ArrayLike] | None = None,
        cell_data: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """A mesh from arrays.

        Args:
            vertices: (n, 3), numbers of any type whose values 64-bit floats hold.
            faces: (m, 3), indices from 0.
            point_data: Named values of vertices, (n,) or (n, k). ``normals``, ``colors`` and ``uv`` are continued on patches as
                such, others harmonically; integers are copied from the nearest vertex.
            cell_data: Named values of faces, (m,) or (m, k).

        Raises:
            MeshError: The arrays are not a mesh.
            ParameterError: Values cannot be stored, or their number differs from the number of vertices or faces.
        """
        from isomend import _arrays

        points, triangles = _arrays.points("vertices", vertices), _arrays.faces(faces)
        of_points = _arrays.given("point_data", point_data, len(points))
        of_faces = _arrays.given("cell_data", cell_data, len(triangles))
        core = CoreModel.from_arrays(points, triangles, of_points, of_faces)
        self._core: CoreModel = core
        self._made, self._given = {}, (point_data, cell_data)

    @classmethod
    def _read(cls, source: str | bytes, format: str | None = None) -> Model:
        with functions_named():
            return cls._of(CoreModel.read_bytes(source, format) if isinstance(source, bytes) else CoreModel.read(source, format))

    @classmethod
    def _of(cls, core: CoreModel) -> Model:
        model = cls.__new__(cls)
        model._core, model._made, model._given = core, {}, (None, None)
        return model

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the mesh with all of its values."""
        return _model_from, (self._core.packed(), _templates(self._given))

    def __repr__(self) -> str:
        vertices, faces = self._core.size()
        return f"<isomend.Model of {vertices} vertices and {faces} faces>"

    def inspect(self) -> Inspection:
        """Finds holes and defects once, for any number of fills; see :func:`isomend.inspect`."""
        return Inspection(self)

    def fill(self, **options: Unpack[FillOptions]) -> Mended:
        """Fills holes; see :func:`isomend.fill` for the options."""
        return _mended(self, self._core, "fill", None, options)

    def restore(self, mark: Mask, **options: Unpack[RestoreOptions]) -> Mended:
        """Replaces the marked faces; see :func:`isomend.restore`."""
        return _mended(self, self._core, "restore", mark, options)

    def fair(self, mark: Mask | None = None, **options: Unpack[FairOptions]) -> Mended:
        """Fairs the surface, or the marked faces; see :func:`isomend.fair`."""
        return _mended(self, self._core, "fair", mark, options)

    def repair(self, **options: Unpack[RepairOptions]) -> Mended:
        """Repairs defects; see :func:`isomend.repair` for the options."""
        return _mended(self, self._core, "repair", None, options)

    def check(
        self,
        *,
        thin: float | None = None,
        debris: float = 0.01,
        min_wall: float | None = None,
        threads: int | None = None,
        **unknown: NoReturn,
    ) -> Verdict:
        """Checks whether the mesh is watertight and printable, and why not; see :func:`isomend.check`."""
        parameters = {"thin": thin, "debris": debris, "min_wall": min_wall}
        options = {**parameters, "threads": threads}
        params = _params.as_json(_params.params("check", {**parameters, **unknown}))
        return Verdict(_isomend.check(self._core, params, _threads(threads)), (self, options))

    def sdf(
        self,
        *,
        voxel: Voxel = "auto",
        band: float | Literal["full"] = "full",
        threads: int | None = None,
        **unknown: NoReturn,
    ) -> Volume:
        """The signed distance of the mesh as a volume; see :func:`isomend.sdf`."""
        params = _params.as_json(_params.params("sdf", {"voxel": voxel, "band": band, **unknown}))
        return Volume._of(_isomend.sdf(self._core, params, _threads(threads)))

    def plan(self, **options: Unpack[FillOptions]) -> dict[str, Any]:
        """What :meth:`fill` would do with the same options, as ``isomend fill --dry-run --json -`` prints it."""
        _, parameters = _params.taken_apart(options)
        with in_files(None, parameters, model_from) as (_, chosen):
            return report_of(self._core.plan(_params.as_json(_work("fill", None, chosen, 0))))


class Inspection(Drawn):
    """The holes and defects of a mesh. They are found once, for any number of fills, restorations and fairings.

    >>> import isomend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    >>> found = isomend.inspect(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
    >>> found.holes[0].rim.tolist()
    [1, 2, 3]
    >>> found.fill(holes=[1]).report["complete"]
    True
    """

    def __init__(self, model: Model) -> None:
        """Inspects a mesh.

        Raises:
            MeshError: The mesh cannot be measured.
        """
        self._model = model
        self._core: Found = model._core.inspect()
        #: The document of ``isomend inspect --json -``: bounds, components, defects, boundary chains that do not close.
        self.report: dict[str, Any] = report_of(self._core.document())
        rims = self._core.rims()
        #: The holes, the longest first.
        self.holes: tuple[Hole, ...] = tuple(map(hole_of, self.report["holes"], rims))
        #: The ends of sharp edges at the rims of holes, in the order of their numbers.
        self.crease_ends: tuple[CreaseEnd, ...] = tuple(map(crease_end_of, self.report["crease_ends"]))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the mesh alone; unpickling inspects it again."""
        return type(self), (self._model,)

    def __repr__(self) -> str:
        holes = {0: "no holes", 1: "1 hole"}.get(len(self.holes), f"{len(self.holes)} holes")
        return f"<isomend.Inspection of {self._model!r} with {holes}>"

    def fill(self, **options: Unpack[FillOptions]) -> Mended:
        """Fills holes; see :func:`isomend.fill` for the options."""
        return _mended(self._model, self._core, "fill", None, options)

    def restore(self, mark: Mask, **options: Unpack[RestoreOptions]) -> Mended:
        """Replaces the marked faces; see :func:`isomend.restore`."""
        return _mended(self._model, self._core, "restore", mark, options)

    def fair(self, mark: Mask | None = None, **options: Unpack[FairOptions]) -> Mended:
        """Fairs the surface, or the marked faces; see :func:`isomend.fair`."""
        return _mended(self._model, self._core, "fair", mark, options)

    def each_task(self, take: Callable[[bytes], object], **options: Unpack[FillOptions]) -> None:
        """Calls ``take`` with the task of each region of a fill in order: bytes for :func:`isomend.solve_task`, in this process or
        another. :meth:`assemble` with the same options joins the patches, in the same order."""
        with _fill_params(options) as params:
            self._core.each_task(params, take)

    def wide_task(self, region: int, **options: Unpack[FillOptions]) -> bytes:
        """The task of a region, by its index from 0, with all of the mesh that the region may use; see :func:`isomend.is_cramped`."""
        with _fill_params(options) as params:
            return self._core.wide_task(params, region)

    def region_count(self, **options: Unpack[FillOptions]) -> int:
        """Number of regions of a fill. A region is one hole, or several that are filled together."""
        with _fill_params(options) as params:
            return self._core.region_count(params)

    def assemble(self, patches: Sequence[bytes], **options: Unpack[FillOptions]) -> Mended:
        """The mesh with the patches of all regions: the same, to the byte, as from :meth:`fill`.

        >>> import isomend
        >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> found = isomend.inspect(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]])
        >>> tasks = []
        >>> found.each_task(tasks.append, holes=[1])
        >>> patches = [isomend.solve_task(task) for task in tasks]
        >>> found.assemble(patches, holes=[1]).faces.shape
        (4, 3)
        """
        run, parameters = _params.taken_apart(options)
        with in_files(None, parameters, model_from) as (_, chosen):
            core = self._core.assemble(_params.as_json(_work("fill", None, chosen, 0)), list(patches))
        return _judged(Mended._made_of(self._model, core), run)


class Mended(Shape, Drawn):
    """A mended mesh: first the kept vertices and faces of the input, bit for bit and in order, then the new ones.

    It can be pickled without loss: with corner data, materials, other content of a glTF file, and its report."""

    _core: CoreMended

    @classmethod
    def _made_of(cls, model: Model, core: CoreMended) -> Mended:
        mended = cls.__new__(cls)
        mended._core, mended._made, mended._given = core, {}, model._given
        return mended

    def __iter__(self) -> Iterator[NDArray[Any]]:
        """The vertices, then the faces: ``vertices, faces = isomend.fill(…)``."""
        return iter((self.vertices, self.faces))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the result with all of its values and its report."""
        return _mended_from, (self._core.packed(), _templates(self._given))

    def __repr__(self) -> str:
        vertices, faces = self._core.size()
        new = faces - self._core.kept_size()[1]
        return f"<isomend.Mended of {vertices} vertices and {faces} faces, {new} of them new: {self._core.state()}>"

    def __str__(self) -> str:
        """What was done: the patches as a table with their expected errors, remarks, holes left open and why, the outcome last."""
        return "\n".join(self._core.lines())

    @property
    def is_patch(self) -> NDArray[Any]:
        """bool (m,), read-only: whether each face is new."""
        import numpy as np

        kept = self._core.kept_size()[1]
        return self._once("is_patch", lambda: read_only(np.arange(self._core.size()[1]) >= kept))

    @property
    def sigma(self) -> NDArray[Any]:
        """float64 (n,), read-only: expected error of each vertex, in the mesh's units; 0 for the input's vertices, NaN where unknown."""
        return self._once("sigma", lambda: read_only(self._core.sigma()))

    @property
    def report(self) -> dict[str, Any]:
        """The report of the run: the JSON document that ``--json`` of the command line writes."""
        return self._once("report", lambda: report_of(self._core.document()))

    @property
    def holes(self) -> list[dict[str, Any]]:
        """The holes and what became of each, as in ``report["holes"]``: number, sizes, outcome and region; and the ``expected_error`` of
        its patch, as in ``report["invented"]``: ``mean``, ``largest`` and ``unknown_percent``, or None if it has no patch or none is
        known."""
        patches = self.report.get("invented", {}).get("patches", [])
        errors = {hole: patch["expected_error"] for patch in patches for hole in patch["holes"]}
        return [{**row, "expected_error": errors.get(row["id"])} for row in self.report.get("holes", [])]

    def to_trimesh(self) -> Any:
        """The mesh as a ``trimesh.Trimesh`` with its named values, ``isomend_sigma`` and ``isomend_patch``, and with the report as JSON
        under ``isomend_report`` in its metadata. It takes trimesh, which isomend does not install."""
        from isomend._carried import to_trimesh

        return to_trimesh(self)

    @property
    def kept_vertices(self) -> NDArray[Any] | None:
        """bool, read-only: whether each vertex of the input is kept; ``None`` if nothing was cut out."""
        kept = self._core.kept()
        return read_only(kept[0]) if kept else None

    @property
    def kept_faces(self) -> NDArray[Any] | None:
        """bool, read-only: whether each face of the input is kept; ``None`` if nothing was cut out."""
        kept = self._core.kept()
        return read_only(kept[1]) if kept else None

    @property
    def complete(self) -> bool:
        """Whether nothing that was to be filled is open: no hole, and unless ``holes`` names holes, no boundary chain that does not
        close (``report["open_chains"]``), as at edges with more than two faces. Holes left open on request (``holes``,
        ``max_diameter``, ``keep_open``) and outer borders of open sheets do not count: ``report["outcomes"]["left"]`` is their number.
        After a repair, whether the mesh has no defects any more."""
        return self._core.complete()

    @property
    def flawless(self) -> bool:
        """Whether every requested hole of more than four edges got a converged surface that is joined to its rim and intersects
        nothing, and all sharp edges that end at its rim were continued."""
        return self._core.flawless()

    def model(self) -> Model:
        """The mended mesh as a new model, to be mended again."""
        return Model._of(CoreModel.of(self._core))

    def check(
        self,
        *,
        thin: float | None = None,
        debris: float = 0.01,
        min_wall: float | None = None,
        threads: int | None = None,
        **unknown: NoReturn,
    ) -> Verdict:
        """Checks whether the mended mesh is watertight and printable, and why not; see :func:`isomend.check`."""
        return self.model().check(thin=thin, debris=debris, min_wall=min_wall, threads=threads, **unknown)

    def patches(self) -> Model:
        """The new faces alone, one component for each hole. ``cell_data["isomend_hole"]`` has the numbers of the holes,
        ``point_data["isomend_sigma"]`` the expected errors, -1 where unknown."""
        return Model._of(CoreModel.patches_of(self._core))

    def piece(self) -> Model:
        """The missing piece as a printable solid, after a restoration: between the faces that were cut out and the patches.

        Raises:
            ParameterError: There is no such solid; the message says why.
        """
        return Model._of(CoreModel.piece_of(self._core))

    def delivering(
        self,
        *,
        patches: str | os.PathLike[str] | None = None,
        piece: str | os.PathLike[str] | None = None,
        mark: str | None = None,
        unit: Literal["um", "mm", "cm", "m", "in", "ft"] | None = None,
        tolerance: float | None = None,
        texture: bool = True,
        paint: Literal["none", "continue"] = "none",
        clearance: float | None = None,
    ) -> Mended:
        """The same result with further files and marks for :meth:`write`, as by the options of ``isomend restore``.

        Args:
            patches: A file for the new faces alone.
            piece: A file for the missing piece.
            mark: A colour for the patches: ``"colour=RRGGBB"``, or ``"hatch"`` for orange stripes.
            unit: The unit of the coordinates. With a unit or a tolerance, ``report`` and pages contain no run times, so that equal runs
                give equal bytes.
            tolerance: The largest error allowed: ``report["invented"]`` then lists the holes whose patches exceed it.
            texture: Whether patches across seams of a texture get texels of their own in OBJ, glTF and GLB files.
            paint: ``"continue"`` paints patches as the triangles beside them, where a 3MF file with the paint of a slicer was read and is
                written.
            clearance: How far the contact surface of the piece is moved inward; the rim of the patch stays.

        Raises:
            ParameterError: The options contradict each other or do not suit this result.

        >>> import isomend
        >>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
        >>> filled = isomend.fill(vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]], holes=[1])
        >>> report = filled.delivering(unit="mm", tolerance=2).report
        >>> report["unit"], round(report["invented"]["area"], 3), report["invented"]["beyond_tolerance"]
        ('mm', 0.866, [])
        """
        core = self._core.delivering(
            (None if patches is None else os.fspath(patches), None if piece is None else os.fspath(piece)),
            mark,
            unit,
            None if tolerance is None else _params.number("tolerance", tolerance),
            [texture, _continues(paint)],
            None if clearance is None else _params.number("clearance", clearance),
        )
        mended = Mended.__new__(Mended)
        mended._core, mended._made, mended._given = core, {}, self._given
        return mended


def _continues(paint: str) -> bool:
    """Whether patches are painted as their neighbours."""
    if paint not in ("none", "continue"):
        raise ParameterError(f'paint is {paint!r}; give "none" or "continue"')
    return paint == "continue"


def _templates(given: Any) -> Any:
    """Empty arrays with the types and shapes of named values."""
    import numpy as np

    from isomend import _arrays

    def empty(values: Any) -> Any:
        array = _arrays.unmasked("values", values)
        return np.empty((0, *array.shape[1:]), array.dtype)

    return tuple(data and {name: empty(values) for name, values in data.items()} for data in given)


def _model_from(packed: bytes, given: Any) -> Model:
    model = Model._of(CoreModel.unpacked(packed))
    model._given = given
    return model


def _mended_from(packed: bytes, given: Any) -> Mended:
    mended = Mended.__new__(Mended)
    mended._core, mended._made, mended._given = CoreMended.unpacked(packed), {}, given
    return mended


class StrictError(IsomendError):
    """With ``strict=True``: some hole is not closed well, or a boundary chain does not close, or a repaired mesh is not sound.

    Attributes:
        result: The result nevertheless; its ``report`` says what is wrong.
    """

    __module__ = "isomend"

    def __init__(self, message: str, result: Mended) -> None:
        super().__init__(message)
        self.result = result

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles the error with its result."""
        return type(self), (str(self), self.result)


def model_from(mesh: Any) -> Model:
    """The model of a mesh that is not in a file, as :func:`isomend.as_model` takes it."""
    if isinstance(mesh, Model):
        return mesh
    model: Model = mesh.model() if isinstance(mesh, Mended) else model_of_other(mesh, Model)
    return model


def _work(command: str, mark: Mask | None, parameters: Mapping[str, Any], faces: int) -> dict[str, Any]:
    """The work of a command in the library's JSON form."""
    mask = None if mark is None else _params.mask_of(mark, faces)
    params = _params.params(command, parameters)
    if command == "restore" and mask is None:
        raise EmptyMaskError("no region is marked")
    return {command: params if command in ("fill", "repair") else [mask, params]}


@contextlib.contextmanager
def _fill_params(options: Mapping[str, Any]) -> Iterator[str]:
    """The parameters of a fill as JSON."""
    _, parameters = _params.taken_apart(options)
    with in_files(None, parameters, model_from) as (_, chosen):
        yield _params.as_json(_params.params("fill", chosen))


def _mended(
    model: Model, core: CoreModel | Found, command: str, mark: Mask | None, options: Mapping[str, Any]
) -> Mended:
    """Runs a command on a mesh or on its inspection."""
    run, parameters = _params.taken_apart(options)
    with in_files(mark, parameters, model_from) as (mask, chosen), functions_named():
        work = _params.as_json(_work(command, mask, chosen, model._core.size()[1]))
        done = core.mend(work, _threads(run.get("threads")), run.get("progress"))
    return _judged(Mended._made_of(model, done), run)


def _threads(threads: int | None) -> int | None:
    """A validated number of threads; ``None`` for one per core."""
    return None if threads is None else _params.count("threads", threads)


def _judged(mended: Mended, run: Mapping[str, Any]) -> Mended:
    """The same result. Raises :class:`StrictError` if it is not flawless and ``strict`` is set; logs what needs attention."""
    messages = mended._core.messages()
    if run.get("strict") and not (mended.complete and mended.flawless):
        not_flawless = "some hole did not get a converged surface that intersects nothing"
        wrong = [] if mended.complete else [*(text for _, text in messages if " still open: " in text), *incomplete(mended)]
        raise StrictError(f"{'; '.join(wrong) or not_flawless}; the result is in `result`", mended)
    for is_warning, message in messages:
        LOG.log(logging.WARNING if is_warning else logging.INFO, "%s", message)
    for message in [*not_continued(mended, messages), *([] if mended.complete else incomplete(mended))]:
        LOG.warning("%s", message)
    return mended
