"""The work on one mesh, in a worker: runs a child process with limits of time and memory, and moves its complete result into place."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

from isomend.fleet._child import peak_of

# Seconds between two looks at a child: the first, from which pauses grow by half each time, and the longest.
PAUSES = (0.002, 0.05)
# Bytes of address space that a child may have beyond twice its memory limit: stacks and arenas of threads, which are mostly unused.
SPACE = 2 << 30
# Bytes of a child's messages that are kept, at the end.
MESSAGE = 2000
# Outcomes of holes whose numbers are recorded.
COUNTS = ("closed", "faired", "rim_triangles", "left", "open")


@dataclass(frozen=True)
class Bounds:
    """What all meshes of a fleet share.

    Attributes:
        output: The output folder.
        work: The folder of results that are not complete.
        arguments: Options of `isomend fill`.
        threads: Threads of each mesh.
        timeout: Limit of the time for a mesh, in seconds.
        memory: Limit of the memory for a mesh, in bytes.
    """

    output: str
    work: str
    arguments: tuple[str, ...]
    threads: int
    timeout: float | None
    memory: int | None


def content_of(path: str) -> str:
    """A 128-bit hash of the content of a file, hexadecimal."""
    digest = blake2b(digest_size=16)
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def mend(
    path: str, output: str, known: str | None, bounds: Bounds, is_stopped: Callable[[], bool] | None = None
) -> dict[str, Any]:
    """Fills the holes of a mesh file; returns its row for the manifest. The work ends with an `InterruptedError` once `is_stopped` says so.

    `known` is the beginning of the content hash of the input from which the existing result was made. If the file still has this content,
    nothing is done, and the outcome is `same`."""
    begun = time.time()
    row: dict[str, Any] = {"input": path, "output": output, "state": [0, 0], "content": "0" * 32}
    target = Path(bounds.output, output)
    try:
        stat = os.stat(path)
        row |= {"state": [stat.st_size, stat.st_mtime_ns], "content": content_of(path)}
        if known is not None and row["content"].startswith(known) and target.exists():
            return row | {"outcome": "same", "bytes": target.stat().st_size}
        name = blake2b(os.fsencode(output), digest_size=16).hexdigest()
        work = Path(bounds.work, f"{name}-{os.getpid()}")
        work.mkdir(parents=True, exist_ok=True)
        try:
            row |= _in_child(path, work / target.name, bounds, is_stopped)
            if row["outcome"] in ("done", "in_part"):
                row["bytes"] = _moved(work, target)
        finally:
            shutil.rmtree(work, ignore_errors=True)
    except InterruptedError:
        raise
    except OSError as error:
        row |= {"outcome": "failed", "error": str(error)}
    return row | {"seconds": round(time.time() - begun, 4)}


def _in_child(path: str, output: Path, bounds: Bounds, is_stopped: Callable[[], bool] | None) -> dict[str, Any]:
    """Fills the holes of a file in a child process; returns the outcome, its message, counts, memory and processor time."""
    report, messages, peak = (output.parent / name for name in (".report.json", ".messages", ".peak"))
    space = 2 * bounds.memory + SPACE if bounds.memory else 0
    # Not with `-m`: Python would warn that the package has already imported the module.
    start = "from isomend.fleet._child import main; main()"
    command = [sys.executable, "-c", start, str(os.getpid()), str(space), str(peak)]
    command += ["fill", path, "-o", str(output), "--json", str(report), "-q", "--threads", str(bounds.threads), *bounds.arguments]
    with open(messages, "wb") as errors:
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=errors, stderr=errors, start_new_session=True)
        try:
            stopped, status, usage, most_used = _watched(child.pid, bounds, is_stopped)
        except BaseException:
            # For example the task was cancelled: the child must not run on.
            _kill(child.pid)
            child.wait()
            raise
    child.returncode = os.waitstatus_to_exitcode(status)
    if peak.exists():
        most_used = int(peak.read_text() or 0)
        peak.unlink()
    row: dict[str, Any] = {"memory": most_used, "cpu": round(usage.ru_utime + usage.ru_stime, 4)}
    message = messages.read_bytes()[-MESSAGE:].decode(errors="replace").strip().removeprefix("error: ")
    if stopped is None and child.returncode < 0 and "memory allocation of" in message:
        stopped = "memory"
    if stopped == "timeout":
        return row | {"outcome": stopped, "error": f"stopped after {bounds.timeout:g} s, the limit of the time"}
    if stopped == "memory":
        return row | {"outcome": stopped, "error": f"stopped above {(bounds.memory or 0) / 2**30:g} GB, the limit of the memory"}
    if child.returncode in (0, 3):
        document = json.loads(report.read_text(encoding="utf-8"))
        counts = {name: document["outcomes"][name] for name in COUNTS}
        report.unlink()
        messages.unlink()
        size = {"vertices": document["input"]["vertices"], "faces": document["input"]["faces"]}
        done = child.returncode == 0
        return row | size | counts | {"outcome": "done" if done else "in_part", "error": "" if done else message}
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        return row | {"outcome": "crashed", "error": f"ended by {name}: {message}".rstrip(": ")}
    return row | {"outcome": "failed", "error": message}


def _watched(pid: int, bounds: Bounds, is_stopped: Callable[[], bool] | None) -> tuple[str | None, int, Any, int]:
    """Waits for a child, and kills it if it exceeds its time or memory. Returns why it was killed (`timeout`, `memory` or none), its exit
    status, its resource usage, and the peak memory seen, in bytes."""
    begun, stopped, pause, most = time.monotonic(), None, PAUSES[0], 0
    while True:
        done, status, usage = os.wait4(pid, os.WNOHANG)
        if done:
            return stopped, status, usage, most
        if is_stopped is not None and is_stopped():
            raise InterruptedError("the run was stopped")
        most = max(most, peak_of(str(pid)))
        if stopped is None:
            if bounds.timeout is not None and time.monotonic() - begun > bounds.timeout:
                stopped = "timeout"
            elif bounds.memory is not None and most > bounds.memory:
                stopped = "memory"
            if stopped:
                _kill(pid)
        time.sleep(pause)
        pause = min(1.5 * pause, PAUSES[1])


def _kill(pid: int) -> None:
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def _moved(work: Path, target: Path) -> int:
    """Moves the files that a child wrote into place, the mesh last; returns the size of the mesh file in bytes."""
    target.parent.mkdir(parents=True, exist_ok=True)
    written = work / target.name
    for file in sorted(work.iterdir(), key=lambda file: file == written):
        with open(file, "rb") as bytes_of:
            os.fsync(bytes_of.fileno())
        os.replace(file, target.parent / file.name)
    return target.stat().st_size
