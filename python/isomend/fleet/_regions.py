"""Filling one mesh on many workers: each region of holes is a Ray task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import isomend
from isomend.fleet._pools import RETRIES, cluster

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from isomend._mesh import Mended, Model
    from isomend._options import FillOptions


def fill_regions(
    model: Model, *, workers: int | None = None, address: str | None = None, **options: Unpack[FillOptions]
) -> Mended:
    """Fills the holes of one mesh on many cores or machines, with the same bytes as the result of :meth:`isomend.Model.fill`.

    It pays if a mesh has many holes that take long, since each region is sent with the part of the mesh that it needs.

    Args:
        model: The mesh.
        workers: Number of regions sent to workers at a time; by default two for each core.
        address: A Ray cluster; by default Ray is started on this machine.
        options: As for :func:`isomend.fill`; ``threads`` is the number of threads of each region, by default 1.

    Returns:
        The filled mesh, with a report.

    Raises:
        IsomendError: Ray is not installed.
        MeshError, HoleIdError, ParameterError: As for :func:`isomend.fill`.
    """
    threads = options.pop("threads", None) or 1
    found = model.inspect()
    patches: dict[int, bytes] = {}
    wider: list[int] = []
    with cluster(workers, threads, address) as ray:
        solve = ray.remote(isomend.solve_task).options(num_cpus=threads, max_retries=RETRIES)
        most = workers or 2 * max(1, int(ray.cluster_resources().get("CPU", 1)) // threads)
        pending: dict[Any, int] = {}

        def collect() -> None:
            ready, _ = ray.wait(list(pending), num_returns=1)
            for reference in ready:
                number, patch = pending.pop(reference), ray.get(reference)
                if isomend.is_cramped(patch):
                    wider.append(number)
                patches[number] = patch

        def send(task: bytes, number: int | None = None) -> None:
            while len(pending) >= most:
                collect()
            pending[solve.remote(task, threads=threads)] = len(patches) + len(pending) if number is None else number

        found.each_task(send, **options)
        while pending or wider:
            if wider:
                number = wider.pop()
                send(found.wide_task(number, **options), number)
            else:
                collect()
    return found.assemble([patches[number] for number in sorted(patches)], **options)
