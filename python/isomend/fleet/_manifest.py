"""The manifest of a fleet: a line for each mesh that was worked on, only ever appended to.

A line counts if it ends and its checksum fits; what a dying machine left half written is passed over. A mesh is done if its last line
was made with the same options by the same version from a file of the same size and time, or else the same content, and its result is
there with the size that it had."""

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
# Seconds between two calls to have the file on the disk.
SYNC = 1.0
# Outcomes that come with a result.
MADE = ("done", "in_part")
MASK = 2**64 - 1


def short(*parts: object) -> int:
    """64 bits that stand for some values."""
    return int.from_bytes(blake2b("\0".join(map(str, parts)).encode(), digest_size=8).digest(), "big")


def line_of(row: dict[str, Any]) -> str:
    """A row as a line with a checksum."""
    text = json.dumps(row, separators=(",", ":"), ensure_ascii=True)
    return f'{text[:-1]},"crc":"{zlib.crc32(text.encode()):08x}"}}\n'


def row_of(line: bytes) -> dict[str, Any] | None:
    """The row of a line that is whole."""
    # `,"crc":"01234567"}` and the end of the line.
    head, tail = line[:-19], line[-19:]
    if not (tail.startswith(b',"crc":"') and tail.endswith(b'"}\n')):
        return None
    if f"{zlib.crc32(head + b'}'):08x}".encode() != tail[8:16]:
        return None
    row = json.loads(head + b"}")
    return row if isinstance(row, dict) else None


class Manifest:
    """The manifest of an output folder, which is this process's alone while it is open."""

    def __init__(self, output: Path, settings: str, retry: bool) -> None:
        self._settings = settings
        self._folder = output / FOLDER
        self._folder.mkdir(parents=True, exist_ok=True)
        self._lock = open(self._folder / "lock", "w")
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._lock.close()
            raise IsomendError(f"another fleet is writing to {output}; wait for it, or stop it") from None
        self.path = self._folder / NAME
        self._output = output
        # For each result, by 64 bits of its name: 64 bits each of its input's state, its input's content, and its size.
        self._known: dict[int, int] = {}
        for row in rows(self.path):
            if row["settings"] != settings or (retry and row["outcome"] not in MADE):
                self._known.pop(short(row["output"]), None)
            else:
                self._remember(row)
        self._file: IO[bytes] = open(self.path, "ab")
        self._synced = time.monotonic()
        with open(self.path, "rb") as read:
            end = read.seek(0, os.SEEK_END)
            read.seek(max(0, end - 1))
            if end and read.read(1) != b"\n":
                # The line that was torn stays alone.
                self._file.write(b"\n")
                self._file.flush()

    def _remember(self, row: dict[str, Any]) -> None:
        content, size = int(row["content"][:16], 16), row.get("bytes", 0)
        self._known[short(row["output"])] = short(*row["state"]) << 128 | content << 64 | size

    def content(self, output: str) -> str | None:
        """The first 64 bits of the content from which a result was made that is there."""
        known = self._known.get(short(output))
        if known is None or not self._is_there(output, known):
            return None
        return f"{known >> 64 & MASK:016x}"

    def is_done(self, output: str, state: tuple[int, int]) -> bool:
        """Whether a file in this state was worked on, and its result, if it had one, is there."""
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
        row = row | {"settings": self._settings}
        self._file.write(line_of(row).encode())
        self._file.flush()
        if time.monotonic() - self._synced > SYNC:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()
        self._remember(row)

    def close(self) -> None:
        """Ends the writing."""
        os.fsync(self._file.fileno())
        self._file.close()
        self._lock.close()


def rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows of all lines that are whole."""
    if not path.exists():
        return
    with open(path, "rb") as lines:
        for line in lines:
            row = row_of(line)
            if row is not None:
                yield row
