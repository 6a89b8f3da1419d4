"""The work on one mesh, in a worker: a child process within bounds of time and memory, its result moved to its place when it is whole."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

from isomend.fleet._child import peak_of
from isomend.fleet._manifest import FOLDER

# Seconds between two looks at a child.
PAUSES = (0.002, 0.05)
# The address space that a child may have beside twice its memory: stacks and arenas of threads, which mostly are never used.
SPACE = 2 << 30
# The most of a message that is kept.
MESSAGE = 2000
COUNTS = ("filled", "faired", "triangulated", "left", "failed")


@dataclass(frozen=True)
class Bounds:
    """What all meshes share: the output folder, options of `isomend fill`, and bounds for each."""

    output: str
    arguments: tuple[str, ...]
    threads: int
    timeout: float | None
    memory: int | None


def content_of(path: str) -> str:
    """128 bits that stand for the content of a file."""
    digest = blake2b(digest_size=16)
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def mend(path: str, output: str, known: str | None, bounds: Bounds) -> dict[str, Any]:
    """Fills the holes of a file; what came of it. Where the result of the same content is there, nothing is done."""
    begun = time.time()
    row: dict[str, Any] = {"input": path, "output": output, "state": [0, 0], "content": "0" * 32}
    target = Path(bounds.output, output)
    try:
        stat = os.stat(path)
        row |= {"state": [stat.st_size, stat.st_mtime_ns], "content": content_of(path)}
        if known is not None and row["content"].startswith(known) and target.exists():
            return row | {"outcome": "same", "bytes": target.stat().st_size}
        work = Path(bounds.output, FOLDER, "work", f"{blake2b(output.encode(), digest_size=16).hexdigest()}-{os.getpid()}")
        work.mkdir(parents=True, exist_ok=True)
        try:
            row |= _in_child(path, work / target.name, bounds)
            if row["outcome"] in ("done", "in_part"):
                row["bytes"] = _moved(work, target)
        finally:
            shutil.rmtree(work, ignore_errors=True)
    except OSError as error:
        row |= {"outcome": "failed", "error": str(error)}
    return row | {"seconds": round(time.time() - begun, 4)}


def _in_child(path: str, output: Path, bounds: Bounds) -> dict[str, Any]:
    report, told, peak = (output.parent / name for name in (".report.json", ".told", ".peak"))
    most = 2 * bounds.memory + SPACE if bounds.memory else 0
    # `-m` would warn that the package has imported the module already.
    start = "from isomend.fleet._child import main; main()"
    command = [sys.executable, "-c", start, str(os.getpid()), str(most), str(peak)]
    command += ["fill", path, "-o", str(output), "--json", str(report), "-q", "--threads", str(bounds.threads), *bounds.arguments]
    with open(told, "wb") as errors:
        child = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=errors, stderr=errors, start_new_session=True)
        try:
            stopped, status, usage, most_used = _watched(child.pid, bounds)
        except BaseException:
            # Such as that the task is cancelled: the child is not left alone.
            _kill(child.pid)
            child.wait()
            raise
    child.returncode = os.waitstatus_to_exitcode(status)
    if peak.exists():
        most_used = int(peak.read_text() or 0)
        peak.unlink()
    row: dict[str, Any] = {"memory": most_used, "cpu": round(usage.ru_utime + usage.ru_stime, 4)}
    message = told.read_bytes()[-MESSAGE:].decode(errors="replace").strip().removeprefix("error: ")
    if stopped is None and child.returncode < 0 and "memory allocation of" in message:
        stopped = "memory"
    if stopped == "timeout":
        return row | {"outcome": stopped, "error": f"not done after {bounds.timeout:g} s"}
    if stopped == "memory":
        return row | {"outcome": stopped, "error": f"it needs more than {(bounds.memory or 0) / 2**30:g} GB"}
    if child.returncode in (0, 3):
        told_of = json.loads(report.read_text())
        counts = {name: told_of["outcomes"][name] for name in COUNTS}
        report.unlink()
        told.unlink()
        size = {"vertices": told_of["input"]["vertices"], "faces": told_of["input"]["faces"]}
        done = child.returncode == 0
        return row | size | counts | {"outcome": "done" if done else "in_part", "error": "" if done else message}
    if child.returncode < 0:
        name = signal.Signals(-child.returncode).name
        return row | {"outcome": "crashed", "error": f"ended by {name}: {message}".rstrip(": ")}
    return row | {"outcome": "failed", "error": message}


def _watched(pid: int, bounds: Bounds) -> tuple[str | None, int, Any, int]:
    """Waits for a child, and ends it if it goes beyond its bounds: why it was ended, its status and use of the machine, and the most
    memory that was seen."""
    begun, stopped, pause, most = time.monotonic(), None, PAUSES[0], 0
    while True:
        done, status, usage = os.wait4(pid, os.WNOHANG)
        if done:
            return stopped, status, usage, most
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
    """Moves what a child wrote to its place, the mesh itself last; its size."""
    target.parent.mkdir(parents=True, exist_ok=True)
    written = work / target.name
    for file in sorted(work.iterdir(), key=lambda file: file == written):
        with open(file, "rb") as bytes_of:
            os.fsync(bytes_of.fileno())
        os.replace(file, target.parent / file.name)
    return target.stat().st_size
