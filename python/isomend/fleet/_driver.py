"""The driver: hands meshes to workers, so many at a time, and writes down what became of each."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import isomend
from isomend._errors import IsomendError, ParameterError
from isomend.fleet import _summary
from isomend.fleet._inputs import Item, counted, items
from isomend.fleet._manifest import FOLDER, Manifest
from isomend.fleet._task import Bounds, mend

# How often a mesh whose worker died is given to another.
RETRIES = 3
# Options of `isomend fill` that name one file, or make none.
SINGLE = ("--report", "--picture", "--json", "--dry-run", "-o", "--output")


@dataclass
class State:
    """How far a fleet is.

    Attributes:
        all: Number of meshes.
        earlier: Meshes that an earlier run was done with.
        outcomes: How many of this run ended in which way: ``done``, ``in_part``, ``failed``, ``timeout``, ``memory``, ``crashed``,
            ``same``.
        seconds: Seconds since the begin.
    """

    all: int
    earlier: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0

    @property
    def done(self) -> int:
        """Meshes that need no more work."""
        return self.earlier + sum(self.outcomes.values())

    @property
    def seconds_left(self) -> float | None:
        """Seconds that the rest will take if it goes on like this; none before the first mesh."""
        own = sum(self.outcomes.values())
        return self.seconds / own * (self.all - self.done) if own else None


def arguments_of(options: Mapping[str, Any]) -> list[str]:
    """Options of :func:`isomend.fill` as those of `isomend fill`."""

    def listed(ids: Iterable[int], by: str) -> str:
        return by.join(str(number) for number in ids)

    arguments: list[str] = []
    for name, value in options.items():
        flag = f"--{name.replace('_', '-')}"
        if value is None or value is False:
            continue
        if value is True:
            arguments.append(flag)
        elif name in ("bridge", "crease"):
            arguments += [word for group in value for word in (flag, listed(group, "+"))]
        elif isinstance(value, (list, tuple)):
            arguments += [flag, listed(value, ",")] if value else []
        else:
            arguments += [flag, str(value)]
    return arguments


def check(arguments: Sequence[str]) -> None:
    """Refuses options that `isomend fill` does not have, or that make sense for one mesh only."""
    for option in arguments:
        if option.split("=")[0] in SINGLE:
            raise ParameterError(f"{option} is for one mesh; the fleet's table tells of all")
    with tempfile.TemporaryDirectory() as folder:
        nothing = os.path.join(folder, "none.ply")
        words = ["fill", nothing, "-o", nothing, "--json", nothing, "-q", "--threads", "1", *arguments]
        command = [sys.executable, "-m", "isomend.fleet._child", str(os.getpid()), "0", os.devnull, *words]
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode == 2:
        raise ParameterError(done.stderr.strip().removeprefix("error: "))


@contextmanager
def cluster(workers: int | None, threads: int, address: str | None) -> Iterator[Any]:
    """Ray, started here where it does not run."""
    try:
        import ray
    except ImportError:
        raise IsomendError("a fleet needs Ray: pip install 'isomend[fleet]'") from None
    if ray.is_initialized():
        yield ray
        return
    # Neither figures of use sent away, nor a word on devices that no task asks for.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    own = {} if address else {"num_cpus": workers * threads if workers else None, "include_dashboard": False}
    ray.init(address=address, log_to_driver=False, logging_level="ERROR", **own)
    try:
        yield ray
    finally:
        ray.shutdown()


def run(
    inputs: Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    *,
    workers: int | None = None,
    address: str | None = None,
    threads: int = 1,
    timeout: float | None = None,
    memory: float | None = None,
    to: str | None = None,
    retry: bool = False,
    progress: Callable[[State], object] | None = None,
    arguments: Sequence[str] = (),
    **options: Any,
) -> State:
    """Fills the holes of many meshes, on many cores or machines. What was done before, with the same options, is not done again.

    Args:
        inputs: Files, folders, patterns such as ``scans/**/*.ply``, and list files ``@FILE``.
        output: The folder of the results, which all machines see. Its `.fleet/manifest.jsonl` has a line for each mesh;
            `summary.csv` and `summary.parquet` are written at the end.
        workers: Meshes that are worked on at a time; by default as many as there are cores.
        address: A Ray cluster, such as ``ray://host:10001``; by default Ray is started on this machine.
        threads: Threads, and cores, of each mesh.
        timeout: Seconds after which the work on a mesh is ended.
        memory: Memory in GB (2³⁰ bytes) beyond which it is ended.
        to: Format of the results; by default that of each input.
        retry: Work again on meshes that failed, crashed, or went beyond their bounds.
        progress: Called with a :class:`State` about once a second, and at the end.
        arguments: Options of `isomend fill` as on its command line.
        options: The same as keywords, as for :func:`isomend.fill`.

    Returns:
        How it ended.

    Raises:
        ParameterError: There is no such option, or two results would have one name.
        IsomendError: Ray is not installed, or another fleet writes to the folder.
    """
    words = [*arguments_of(options), *(["--to", to] if to else []), *arguments]
    check(words)
    folder = Path(output).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    names = [os.fspath(name) for name in inputs]
    state = State(counted(names, folder, to))
    if not state.all:
        raise ParameterError(f"there are no meshes in {', '.join(names)}")
    settings = " ".join([isomend.__version__, *words])
    limit = None if memory is None else int(memory * 2**30)
    bounds = Bounds(str(folder), tuple(words), threads, timeout, limit)
    manifest = Manifest(folder, settings, retry)
    try:
        shutil.rmtree(folder / FOLDER / "work", ignore_errors=True)
        with cluster(workers, threads, address) as ray:
            _Run(ray, manifest, bounds, state, workers, progress).all(items(names, folder, to))
    finally:
        manifest.close()
    _summary.write(folder)
    shutil.rmtree(folder / FOLDER / "work", ignore_errors=True)
    return state


class _Run:
    """A run, and what of it is in flight."""

    def __init__(
        self,
        ray: Any,
        manifest: Manifest,
        bounds: Bounds,
        state: State,
        workers: int | None,
        progress: Callable[[State], object] | None,
    ) -> None:
        self._ray = ray
        self._manifest = manifest
        self._state = state
        self._progress = progress
        self._begun = time.monotonic()
        self._told = 0.0
        self._task = ray.remote(mend).options(num_cpus=bounds.threads, max_retries=RETRIES)
        self._bounds = ray.put(bounds)
        cores = int(ray.cluster_resources().get("CPU", 1))
        # Some more than there are workers wait at them, so that none is idle while the driver writes.
        self._most = workers or 2 * max(1, cores // bounds.threads)
        self._pending: dict[Any, Item] = {}

    def all(self, meshes: Iterator[Item]) -> None:
        """Works on all meshes."""
        for item in meshes:
            if self._manifest.is_done(item.output, _state_of(item.path)):
                self._state.earlier += 1
                self._tell()
                continue
            while len(self._pending) >= self._most:
                self._collect()
            known = self._manifest.content(item.output)
            path = os.path.abspath(item.path)
            self._pending[self._task.remote(path, item.output, known, self._bounds)] = item
        while self._pending:
            self._collect()
        self._tell(last=True)

    def _collect(self) -> None:
        """Waits for the next mesh, and writes down what became of it."""
        ready, _ = self._ray.wait(list(self._pending), num_returns=1, timeout=1.0)
        for reference in ready:
            item = self._pending.pop(reference)
            try:
                row = self._ray.get(reference)
            except self._ray.exceptions.RayError as error:
                message = f"its worker died {RETRIES + 1} times: {str(error).strip().splitlines()[0]}"
                row = {"input": item.path, "output": item.output, "state": list(_state_of(item.path)), "content": "0" * 32}
                row |= {"outcome": "crashed", "error": message}
            self._manifest.add(row | {"input": item.path})
            self._state.outcomes[row["outcome"]] += 1
        self._tell()

    def _tell(self, last: bool = False) -> None:
        now = time.monotonic()
        if self._progress is not None and (last or now - self._told > 1.0):
            self._told = now
            self._state.seconds = now - self._begun
            self._progress(self._state)


def _state_of(path: str) -> tuple[int, int]:
    """Size and time of a file."""
    try:
        stat = os.stat(path)
    except OSError:
        return 0, 0
    return stat.st_size, stat.st_mtime_ns
