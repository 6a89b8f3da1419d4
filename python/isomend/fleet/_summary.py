"""The summary of a fleet: a table (CSV, Parquet) with the outcome of each mesh."""

from __future__ import annotations

import csv
import itertools
import os
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from isomend.fleet._manifest import manifests, rows, short

TEXT = ("input", "output", "outcome", "error", "content")
NUMBERS = ("seconds", "cpu")
WHOLE = ("memory", "bytes", "vertices", "faces", "closed", "faired", "rim_triangles", "left", "open")
COLUMNS = ("input", "output", "outcome", *NUMBERS, *WHOLE, "error", "content")
# The outcome of a mesh whose file has changed, but not its content: the earlier row is still correct.
SAME = "same"
# Rows of the Parquet file that are held in memory at a time.
BATCH = 10_000


def last_rows(output: Path) -> Iterator[dict[str, Any]]:
    """The last row of each result, in the order of the manifests."""

    def every() -> Iterator[tuple[int, dict[str, Any]]]:
        return enumerate(itertools.chain.from_iterable(map(rows, manifests(output))))

    last = {short(row["output"]): number for number, row in every() if row["outcome"] != SAME}
    for number, row in every():
        if last.get(short(row["output"])) == number:
            yield {name: row.get(name) for name in COLUMNS}


def write(output: Path) -> list[Path]:
    """Writes `summary.csv` and, if pyarrow is installed, `summary.parquet`; returns their paths."""
    made = [output / "summary.csv"]
    # Shards that end at the same time write files of their own, on any machine.
    own = f".{socket.gethostname()}-{os.getpid()}.part"
    beside = made[0].with_suffix(f".csv{own}")
    with open(beside, "w", newline="", encoding="utf-8") as file:
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
            batch.append(row)
            if len(batch) == BATCH:
                writer.write_table(pyarrow.Table.from_pylist(batch, schema))
                batch.clear()
        writer.write_table(pyarrow.Table.from_pylist(batch, schema))
    os.replace(beside, made[1])
    return made
