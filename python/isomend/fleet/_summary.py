"""The summary of a fleet: a table (CSV, Parquet) with the outcome of each mesh."""

from __future__ import annotations

import csv
import fcntl
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from isomend.fleet._manifest import FOLDER, SAME, manifests, rows, short, time_of

TEXT = ("input", "output", "outcome", "error", "content")
NUMBERS = ("seconds", "cpu")
WHOLE = ("memory", "bytes", "vertices", "faces", "closed", "faired", "rim_triangles", "left", "open")
COLUMNS = ("input", "output", "outcome", *NUMBERS, *WHOLE, "error", "content")
# Rows of the Parquet file that are held in memory at a time.
BATCH = 10_000


def last_rows(output: Path) -> Iterator[dict[str, Any]]:
    """The last row of each result, in the order of the manifests. Rows that other shards append meanwhile are left out."""
    paths = manifests(output)

    def every() -> Iterator[tuple[tuple[int, int], dict[str, Any]]]:
        for file, path in enumerate(paths):
            for number, row in enumerate(rows(path)):
                yield (file, number), row

    last: dict[int, tuple[float, tuple[int, int]]] = {}
    for place, row in every():
        name = short(row["output"])
        if row["outcome"] != SAME and (name not in last or time_of(row) >= last[name][0]):
            last[name] = time_of(row), place
    for place, row in every():
        known = last.get(short(row["output"]))
        if known is not None and known[1] == place:
            yield {name: row.get(name) for name in COLUMNS}


def write(output: Path) -> list[Path]:
    """Writes `summary.csv` and, if pyarrow is installed, `summary.parquet`; returns their paths. Names that are not UTF-8 keep their bytes in
    the first, and have replacement characters in the second."""
    # Shards that end at the same time write one after another: the last one reads the rows of all.
    with open(output / FOLDER / "lock-summary", "a+") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        return _written(output)


def _written(output: Path) -> list[Path]:
    made = [output / "summary.csv"]
    # A file of its own, on any machine, also where a process was stopped while it wrote.
    own = f".{socket.gethostname()}-{os.getpid()}.part"
    beside = made[0].with_suffix(f".csv{own}")
    with open(beside, "w", newline="", encoding="utf-8", errors="surrogateescape") as file:
        table = csv.DictWriter(file, COLUMNS)
        table.writeheader()
        table.writerows(last_rows(output))
    os.replace(beside, made[0])
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError:
        return made
    types = {name: pyarrow.string() for name in TEXT} | {name: pyarrow.float64() for name in NUMBERS}
    types |= {name: pyarrow.int64() for name in WHOLE}
    schema = pyarrow.schema([(name, types[name]) for name in COLUMNS])
    made.append(output / "summary.parquet")
    beside = made[1].with_suffix(f".parquet{own}")
    with parquet.ParquetWriter(beside, schema) as writer:
        batch: list[dict[str, Any]] = []
        for row in last_rows(output):
            batch.append(row | {name: _utf8(row[name]) for name in TEXT})
            if len(batch) == BATCH:
                writer.write_table(pyarrow.Table.from_pylist(batch, schema))
                batch.clear()
        writer.write_table(pyarrow.Table.from_pylist(batch, schema))
    os.replace(beside, made[1])
    return made


def _utf8(text: str | None) -> str | None:
    """A text whose bytes that are not UTF-8 are replaced."""
    return None if text is None else text.encode(errors="surrogateescape").decode(errors="replace")
