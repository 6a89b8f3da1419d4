"""Where the meshes of a fleet are worked on: workers of Ray, or threads of this process, each with a child process for its mesh."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable, Iterator
from concurrent import futures
from contextlib import contextmanager
from typing import Any, Protocol

from isomend._errors import IsomendError
from isomend.fleet._task import Bounds, mend

# How often a mesh is given to another worker after its worker died.
RETRIES = 3
# Longest time that a look for finished meshes takes, in seconds.
PAUSE = 1.0


class Pool(Protocol):
    """Workers for meshes.

    Attributes:
        most: Number of meshes to hand out before results are collected.
    """

    most: int

    def submit(self, path: str, output: str, known: str | None) -> Any:
        """Hands out a mesh, with the arguments of :func:`isomend.fleet._task.mend`; returns a handle."""

    def finished(self, handles: Iterable[Any]) -> list[Any]:
        """Handles of meshes that are done, after at most a second."""

    def row(self, handle: Any) -> dict[str, Any] | str:
        """The row of a mesh that is done, or why its worker died."""


class RayPool:
    """Workers of Ray, here or on a cluster."""

    def __init__(self, ray: Any, bounds: Bounds, workers: int | None) -> None:
        self._ray = ray
        self._task = ray.remote(mend).options(num_cpus=bounds.threads, max_retries=RETRIES)
        self._bounds = ray.put(bounds)
        cores = int(ray.cluster_resources().get("CPU", 1))
        # Twice as many tasks as can run, so that no worker is idle while the driver writes.
        self.most = workers or 2 * max(1, cores // bounds.threads)

    def submit(self, path: str, output: str, known: str | None) -> Any:
        return self._task.remote(path, output, known, self._bounds)

    def finished(self, handles: Iterable[Any]) -> list[Any]:
        ready, _ = self._ray.wait(list(handles), num_returns=1, timeout=PAUSE)
        return list(ready)

    def row(self, handle: Any) -> dict[str, Any] | str:
        try:
            row: dict[str, Any] = self._ray.get(handle)
            return row
        except self._ray.exceptions.RayError as error:
            return f"its worker died {RETRIES + 1} times: {str(error).strip().splitlines()[0]}"


class LocalPool:
    """Threads of this process, without Ray. A thread only waits for the child process that works on its mesh."""

    def __init__(self, bounds: Bounds, workers: int | None) -> None:
        self._bounds = bounds
        self.most = workers or max(1, cores() // bounds.threads)
        self._stop = threading.Event()
        self._threads = futures.ThreadPoolExecutor(self.most)

    def submit(self, path: str, output: str, known: str | None) -> futures.Future[dict[str, Any]]:
        return self._threads.submit(mend, path, output, known, self._bounds, self._stop.is_set)

    def finished(self, handles: Iterable[Any]) -> list[Any]:
        done, _ = futures.wait(handles, timeout=PAUSE, return_when=futures.FIRST_COMPLETED)
        return list(done)

    def row(self, handle: Any) -> dict[str, Any] | str:
        try:
            row: dict[str, Any] = handle.result()
            return row
        except InterruptedError:
            raise
        except Exception as error:
            # A fault of the work on one mesh does not end the run.
            return f"{type(error).__name__}: {error}"

    def close(self) -> None:
        """Ends the child processes that still run."""
        self._stop.set()
        self._threads.shutdown(cancel_futures=True)


def cores() -> int:
    """The cores that this process may use, such as the share of a batch system."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def local(bounds: Bounds, workers: int | None) -> Iterator[LocalPool]:
    """Workers of this process, as a context."""
    pool = LocalPool(bounds, workers)
    try:
        yield pool
    finally:
        pool.close()


@contextmanager
def remote(bounds: Bounds, workers: int | None, address: str | None) -> Iterator[RayPool]:
    """Workers of Ray, as a context."""
    with cluster(workers, bounds.threads, address) as ray:
        yield RayPool(ray, bounds, workers)


@contextmanager
def cluster(workers: int | None, threads: int, address: str | None) -> Iterator[Any]:
    """Ray, as a context: started here and shut down at the end, unless it runs already."""
    try:
        import ray
    except ImportError:
        raise IsomendError("a fleet needs Ray: pip install 'isomend[fleet]'; its program works without if it has --shard 1/1") from None
    if ray.is_initialized():
        yield ray
        return
    # No usage statistics, and no warnings about accelerators, which no task uses.
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    os.environ.setdefault("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
    own = {} if address else {"num_cpus": workers * threads if workers else None, "include_dashboard": False}
    ray.init(address=address, log_to_driver=False, logging_level="ERROR", **own)
    try:
        yield ray
    finally:
        ray.shutdown()
