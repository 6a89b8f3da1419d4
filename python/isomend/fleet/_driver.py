"""The driver of a fleet: hands meshes to workers and records the outcome of each in the manifest."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import isomend
from isomend._errors import ParameterError
from isomend.fleet import _summary
from isomend.fleet._inputs import Item, Shard, counted, items
from isomend.fleet._manifest import FOLDER, Manifest
from isomend.fleet._pools import Pool, local, remote
from isomend.fleet._task import Bounds

# Options of `isomend fill` that name a single file, or write no result.
SINGLE = ("--report", "--picture", "--json", "--dry-run", "-o", "--output")


@dataclass
class State:
    """Progress of a fleet.

    Attributes:
        all: Number of meshes.
        earlier: Number of meshes that an earlier run has done.
        outcomes: Number of meshes of this run for each outcome: ``done``, ``in_part``, ``failed``, ``timeout``, ``memory``, ``crashed``,
            ``same``.
        seconds: Seconds since the start of this run.
    """

    all: int
    earlier: int = 0
    outcomes: Counter[str] = field(default_factory=Counter)
    seconds: float = 0.0

    @property
    def done(self) -> int:
        """Number of meshes that need no more work."""
        return self.earlier + sum(self.outcomes.values())

    @property
    def seconds_left(self) -> float | None:
        """Expected seconds for the remaining meshes, at the mean rate of this run; None before its first mesh is done."""
        own = sum(self.outcomes.values())
        return self.seconds / own * (self.all - self.done) if own else None


def arguments_of(options: Mapping[str, Any]) -> list[str]:
    """Keywords of :func:`isomend.fill` as options of the command `isomend fill`."""

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
    """Raises a `ParameterError` for options that `isomend fill` does not have, or that are for a single mesh."""
    for option in arguments:
        if option.split("=")[0] in SINGLE:
            raise ParameterError(f"{option} is for one mesh and cannot be used for a fleet; summary.csv lists all meshes")
    with tempfile.TemporaryDirectory() as folder:
        nothing, output, report = (os.path.join(folder, name) for name in ("none.ply", "filled.ply", "report.json"))
        words = ["fill", nothing, "-o", output, "--json", report, "-q", "--threads", "1", *arguments]
        start = "from isomend.fleet._child import main; main()"
        command = [sys.executable, "-c", start, str(os.getpid()), "0", os.devnull, *words]
        done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
    if done.returncode == 2:
        raise ParameterError(done.stderr.strip().removeprefix("error: "))


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
    shard: tuple[int, int] | None = None,
    progress: Callable[[State], object] | None = None,
    arguments: Sequence[str] = (),
    **options: Any,
) -> State:
    """Fills the holes of many meshes, on many cores or machines. Meshes that are done with the same options are skipped.

    Args:
        inputs: Files, folders, patterns such as ``scans/**/*.ply``, and list files ``@FILE``.
        output: The folder of the results, which all machines must be able to access. Its `.fleet/manifest.jsonl` has a line for each mesh;
            `summary.csv` and `summary.parquet` are written at the end.
        workers: Number of meshes processed at a time; by default one for each core.
        address: A Ray cluster, such as ``ray://host:10001``; by default Ray is started on this machine.
        threads: Number of threads, and of cores reserved, for each mesh.
        timeout: Seconds after which the work on a mesh is stopped.
        memory: Memory in GB (2³⁰ bytes) above which the work on a mesh is stopped.
        to: Format of the results; by default the format of each input.
        retry: Process meshes again that failed, crashed, or exceeded the time or the memory.
        shard: A part of the meshes, as its number from 1 and the number of parts. They are processed by this process without Ray, beside
            other parts that other processes do, such as the jobs of an array of Slurm.
        progress: Called with a :class:`State` about once a second, and at the end.
        arguments: Options of `isomend fill` as on its command line.
        options: Options of `isomend fill` as keywords of :func:`isomend.fill`.

    Returns:
        The final :class:`State`.

    Raises:
        ParameterError: An option is not valid, there are no meshes, or two results would have the same name.
        IsomendError: Ray is not installed, or another fleet writes to the folder.
    """
    words = [*arguments_of(options), *(["--to", to] if to else []), *arguments]
    part = None if shard is None else Shard(*shard)
    if part and address:
        raise ParameterError("a shard is processed without Ray: give an address or a shard, not both")
    check(words)
    folder = Path(output).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    names = [os.fspath(name) for name in inputs]
    every, own = counted(names, folder, to, part)
    if not every:
        raise ParameterError(f"there are no meshes in {', '.join(names)}")
    state = State(own)
    settings = " ".join([isomend.__version__, *words])
    limit = None if memory is None else int(memory * 2**30)
    work = folder / FOLDER / ("work" + (part.suffix if part else ""))
    bounds = Bounds(str(folder), str(work), tuple(words), threads, timeout, limit)
    manifest = Manifest(folder, settings, retry, part.suffix if part else "")
    try:
        shutil.rmtree(work, ignore_errors=True)
        with local(bounds, workers) if part else remote(bounds, workers, address) as pool:
            _Run(pool, manifest, state, progress).all(items(names, folder, to, part))
        # While the lock is held: the next run uses the same folder.
        shutil.rmtree(work, ignore_errors=True)
    finally:
        manifest.close()
    _summary.write(folder)
    return state


class _Run:
    """One run of a fleet, with the meshes that are in work."""

    def __init__(self, pool: Pool, manifest: Manifest, state: State, progress: Callable[[State], object] | None) -> None:
        self._pool = pool
        self._manifest = manifest
        self._state = state
        self._progress = progress
        self._begun = time.monotonic()
        self._last_report = 0.0
        self._pending: dict[Any, Item] = {}

    def all(self, meshes: Iterator[Item]) -> None:
        """Processes all meshes."""
        for item in meshes:
            if self._manifest.is_done(item.output, _state_of(item.path)):
                self._state.earlier += 1
                self._report()
                continue
            while len(self._pending) >= self._pool.most:
                self._collect()
            known = self._manifest.content(item.output)
            path = os.path.abspath(item.path)
            self._pending[self._pool.submit(path, item.output, known)] = item
        while self._pending:
            self._collect()
        self._report(last=True)

    def _collect(self) -> None:
        """Waits up to a second for a mesh to end, and adds its row to the manifest."""
        for handle in self._pool.finished(self._pending):
            item = self._pending.pop(handle)
            row = self._pool.row(handle)
            if isinstance(row, str):
                row = {"output": item.output, "state": list(_state_of(item.path)), "content": "0" * 32, "outcome": "crashed", "error": row}
            self._manifest.add(row | {"input": item.path})
            self._state.outcomes[row["outcome"]] += 1
        self._report()

    def _report(self, last: bool = False) -> None:
        """Calls the progress function, at most once a second."""
        now = time.monotonic()
        if self._progress is not None and (last or now - self._last_report > 1.0):
            self._last_report = now
            self._state.seconds = now - self._begun
            self._progress(self._state)


def _state_of(path: str) -> tuple[int, int]:
    """Size in bytes and modification time in nanoseconds of a file; zeros if it cannot be read."""
    try:
        stat = os.stat(path)
    except OSError:
        return 0, 0
    return stat.st_size, stat.st_mtime_ns
