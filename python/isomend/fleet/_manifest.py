"""The manifest of a fleet: an append-only file with a line of JSON for each mesh that was processed.

A line is valid if it is complete and its checksum matches; lines that a crash left incomplete are skipped. A mesh is done if its last line
has the same options and version, the input file has the same size and time or else the same content, and the result still exists with the
recorded size. Each shard of a fleet has a manifest of its own and reads all of them, so that meshes stay done if the number of shards changes.
Of the lines of several manifests for one mesh, the one that was written last counts: each has its time."""

from __future__ import annotations

import fcntl
import json
import os
import time
import zlib
from collections.abc import Iterator
from hashlib import blake2b
from pathlib import Path
from typing import IO, Any

from isomend._errors import IsomendError

FOLDER = ".fleet"
NAME = "manifest.jsonl"
# Seconds between two calls of fsync, at least: a crash of the machine loses the lines since the last one.
SYNC = 1.0
# Outcomes with a result file.
MADE = ("done", "in_part")
# The outcome of a mesh whose file has changed, but not its content: the earlier result is still correct.
SAME = "same"
# Lowest 64 bits of the packed entries of `Manifest._known`.
MASK = 2**64 - 1


def short(*parts: object) -> int:
    """A 64-bit hash of some values. Names of files need not be UTF-8."""
    text = "\0".join(map(str, parts)).encode(errors="surrogateescape")
    return int.from_bytes(blake2b(text, digest_size=8).digest(), "big")


def line_of(row: dict[str, Any]) -> str:
    """A row as a line with a checksum."""
    text = json.dumps(row, separators=(",", ":"), ensure_ascii=True)
    return f'{text[:-1]},"crc":"{zlib.crc32(text.encode()):08x}"}}\n'


def row_of(line: bytes) -> dict[str, Any] | None:
    """The row of a line; none if the line is incomplete or its checksum does not match."""
    # The last 19 bytes are `,"crc":"01234567"}` and the line end.
    head, tail = line[:-19], line[-19:]
    if not (tail.startswith(b',"crc":"') and tail.endswith(b'"}\n')):
        return None
    if f"{zlib.crc32(head + b'}'):08x}".encode() != tail[8:16]:
        return None
    row = json.loads(head + b"}")
    return row if isinstance(row, dict) else None


def manifests(output: Path) -> list[Path]:
    """The manifests of an output folder: the fleet's own, and its shards'."""
    return sorted((output / FOLDER).glob("manifest*.jsonl"))


class Manifest:
    """The manifest of an output folder, or of a shard with this suffix. While it is open, locks keep out: any other fleet, if it is of the
    whole folder; the same shard and fleets of the whole folder, if it is of a shard. Shards of different divisions, such as 1/2 and 1/3, may
    run at once: a mesh of both is filled by both, and its result is written twice."""

    def __init__(self, output: Path, settings: str, retry: bool, suffix: str = "") -> None:
        self._settings = settings
        self._folder = output / FOLDER
        self._folder.mkdir(parents=True, exist_ok=True)
        # Shards share the folder's lock, and each has its own.
        # For reading and writing, as NFS demands the one for shared locks and the other for exclusive ones.
        self._locks = [open(self._folder / "lock", "a+")]
        if suffix:
            self._locks.append(open(self._folder / f"lock{suffix}", "a+"))
        try:
            fcntl.flock(self._locks[0], (fcntl.LOCK_SH if suffix else fcntl.LOCK_EX) | fcntl.LOCK_NB)
            fcntl.flock(self._locks[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            self._unlock()
            raise IsomendError(f"another fleet is writing to {output}; wait for it, or stop it") from None
        except OSError as error:
            self._unlock()
            raise IsomendError(f"{output} cannot be locked ({error}); use an output folder on a file system with locks") from None
        stem, extension = os.path.splitext(NAME)
        self.path = self._folder / f"{stem}{suffix}{extension}"
        self._output = output
        # For each result, by the hash of its name: hash of the input file's size and time, first 64 bits of the input's content hash,
        # size of the result in bytes, 64 bits each. Packed in one integer, as a fleet may have millions of meshes.
        self._known: dict[int, int] = {}
        # For each result, by the hash of its name, the time of its last row so far.
        last: dict[int, float] = {}
        for path in manifests(output):
            for row in rows(path):
                name = short(row["output"])
                if time_of(row) < last.get(name, 0.0):
                    continue
                last[name] = time_of(row)
                if row["settings"] != settings or (retry and row["outcome"] not in (*MADE, SAME)):
                    self._known.pop(name, None)
                else:
                    self._remember(row)
        self._file: IO[bytes] = open(self.path, "ab")
        self._synced = time.monotonic()
        with open(self.path, "rb") as read:
            end = read.seek(0, os.SEEK_END)
            read.seek(max(0, end - 1))
            if end and read.read(1) != b"\n":
                # Ends the incomplete last line, so that it does not spoil the next one.
                self._file.write(b"\n")
                self._file.flush()

    def _remember(self, row: dict[str, Any]) -> None:
        content, size = int(row["content"][:16], 16), row.get("bytes", 0)
        self._known[short(row["output"])] = short(*row["state"]) << 128 | content << 64 | size

    def content(self, output: str) -> str | None:
        """First 64 bits (hexadecimal) of the content hash of the input of a result; none if the result does not exist any more."""
        known = self._known.get(short(output))
        if known is None or not self._is_there(output, known):
            return None
        return f"{known >> 64 & MASK:016x}"

    def is_done(self, output: str, state: tuple[int, int]) -> bool:
        """Whether an input with this size and time was processed, and its result, if there was one, still exists."""
        known = self._known.get(short(output))
        return known is not None and known >> 128 == short(*state) and self._is_there(output, known)

    def _is_there(self, output: str, known: int) -> bool:
        size = known & MASK
        try:
            return size == 0 or os.path.getsize(self._output / output) == size
        except OSError:
            return False

    def add(self, row: dict[str, Any]) -> None:
        """Appends a row."""
        row = row | {"settings": self._settings, "at": time.time()}
        self._file.write(line_of(row).encode())
        self._file.flush()
        if time.monotonic() - self._synced > SYNC:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()
        self._remember(row)

    def close(self) -> None:
        """Flushes the file to the disk, closes it, and releases the lock."""
        os.fsync(self._file.fileno())
        self._file.close()
        self._unlock()

    def _unlock(self) -> None:
        for lock in self._locks:
            lock.close()


def time_of(row: dict[str, Any]) -> float:
    """The time at which a row was written, in seconds; 0 for rows of older versions, which have none."""
    return float(row.get("at", 0.0))


def rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows of all valid lines."""
    if not path.exists():
        return
    with open(path, "rb") as lines:
        for line in lines:
            row = row_of(line)
            if row is not None:
                yield row
