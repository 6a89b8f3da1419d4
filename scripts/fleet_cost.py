"""Measure the overhead of a fleet: its time and memory in addition to the fills themselves.

    .venv/bin/python scripts/fleet_cost.py [--docs]

It needs the Python package with Ray, as installed in `.venv` by scripts/test.sh --all, and an idle machine. The inputs are several copies
of each mesh in `data`. CPU time is the time of the child processes. The driver's rates are the meshes per second that it records, and that
it recognises as done."""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from isomend import fleet
from isomend.fleet._manifest import Manifest, rows
from scaling import made, write_ply
from tables import renew

ROOT = Path(__file__).resolve().parent.parent
COPIES = 4
KNOWN = 200_000
# The mesh that is filled by regions: triangles, holes, edges across a hole.
GIANT, HOLES, ACROSS = 1_100_000, 50, 40
# Fills this mesh in a separate process, with threads or workers; prints the CPU seconds of reading and filling it, with all child
# processes, and a checksum of the result.
FILL_GIANT = """
import hashlib, json, os, pathlib, sys
def below():
    known, more, rows = {os.getpid()}, True, {}
    for path in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            rows[int(path.parent.name)] = path.read_text().rsplit(")", 1)[1].split()
        except OSError:
            pass
    while more:
        more = {pid for pid, row in rows.items() if int(row[1]) in known} - known
        known |= more
    return sum(int(rows[pid][k]) for pid in known if pid in rows for k in range(11, 15)) / os.sysconf("SC_CLK_TCK")
import isomend
how, path = sys.argv[1:]
if how == "workers":
    import ray
    from isomend import fleet
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
begun = below()
model = isomend.read(path)
mended = model.fill(threads=2) if how == "threads" else fleet.fill_regions(model, workers=2)
print(json.dumps([below() - begun, hashlib.sha256(mended.to_bytes("ply")).hexdigest()]))
"""
# A large fleet for which the cost is computed: number of scans, cores, price of a core-hour in dollars.
SCANS, CORES, PRICE = 1_000_000, 1000, 0.04


def copied(folder):
    """Writes several copies of each mesh of `data` to the folder."""
    folder.mkdir()
    for mesh in sorted((ROOT / "data").glob("*.ply")):
        for copy in range(COPIES):
            (folder / f"{mesh.stem}-{copy}.ply").write_bytes(mesh.read_bytes())
    return folder


def one_run(inputs, output, workers):
    """Runs a fleet; returns its seconds, and the rows of its summary."""
    marks = []
    fleet.run([inputs], output, workers=workers, progress=lambda state: marks.append((state.seconds, state.done)))
    with open(output / "summary.csv", newline="") as file:
        return marks[-1][0], list(csv.DictReader(file))


def driver(folder):
    """Measures the manifest: meshes recorded a second, meshes read again a second, bytes of memory and bytes of the file for each mesh."""
    row = {"input": "/data/scans/0001/scan-000001.ply", "output": "0001/scan-000001.ply", "state": [1, 1], "content": "0" * 32}
    row |= {"outcome": "done", "seconds": 1.0, "cpu": 1.0, "memory": 1, "bytes": 0, "vertices": 1, "faces": 1, "error": ""}
    row |= dict.fromkeys(("closed", "faired", "rim_triangles", "left", "open"), 0)
    manifest, begun = Manifest(folder, "settings", retry=False), time.perf_counter()
    for number in range(KNOWN):
        manifest.add(row | {"output": f"{number // 1000:04}/scan-{number:06}.ply"})
    written = KNOWN / (time.perf_counter() - begun)
    manifest.close()
    del manifest
    size = (folder / ".fleet" / "manifest.jsonl").stat().st_size / KNOWN
    begun = time.perf_counter()
    known = Manifest(folder, "settings", retry=False)
    read = KNOWN / (time.perf_counter() - begun)
    known.close()
    assert sum(1 for _ in rows(known.path)) == KNOWN
    return written, read, (sys.getsizeof(known._known) + sum(map(sum_of, known._known.items()))) / KNOWN, size


def sum_of(item):
    return sum(map(sys.getsizeof, item))


def one_mesh(folder):
    """CPU seconds of filling the large mesh with two threads and with two workers: medians of three."""
    path = folder / "giant.ply"
    write_ply(path, *made(GIANT, HOLES, ACROSS))
    seconds, results = {"threads": [], "workers": []}, set()
    for how in 3 * ["threads", "workers"]:
        command = [sys.executable, "-c", FILL_GIANT, how, str(path)]
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        cpu, result = json.loads(done.stdout.splitlines()[-1])
        seconds[how].append(cpu)
        results.add(result)
    assert len(results) == 1
    return {how: sorted(runs)[1] for how, runs in seconds.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--docs", action="store_true", help="write the table into docs/fleets.md")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        inputs = copied(folder / "in")
        seconds = {}
        for workers in (1, 2):
            seconds[workers], table = one_run(inputs, folder / f"out-{workers}", workers)
            if workers == 1:
                alone = table
        giant = one_mesh(folder)
        (folder / "driver").mkdir()
        written, read, kept, size = driver(folder / "driver")
    count = len(alone)
    cpu = sum(float(row["cpu"]) for row in alone) / count
    wall = sum(float(row["seconds"]) for row in alone) / count
    memory = sorted(int(row["memory"]) for row in alone)
    faces = sum(int(row["faces"]) for row in alone) / count
    moved = sum(int(row["bytes"]) for row in alone) / count
    figures = [
        ("meshes; mean triangles; mean bytes written", f"{count}; {faces:,.0f}; {moved:,.0f}"),
        ("CPU seconds a mesh, its process and all", f"{cpu:.2f}"),
        ("seconds a mesh in its worker, one thread", f"{wall:.2f}"),
        ("seconds a mesh of the whole run, one worker", f"{seconds[1] / count:.2f}"),
        ("two workers, against one", f"{seconds[1] / seconds[2]:.2f} times as fast"),
        ("memory of a mesh's process: median, largest", f"{memory[count // 2] / 2**20:.0f} MB, {memory[-1] / 2**20:.0f} MB"),
        ("manifest: bytes a mesh; lines written, read a second", f"{size:.0f}; {written:,.0f}, {read:,.0f}"),
        ("memory of the driver a mesh", f"{kept:.0f} bytes"),
        (
            f"one mesh of {GIANT:,} triangles with {HOLES} holes: CPU seconds by two threads; by two workers",
            f"{giant['threads']:.1f}; {giant['workers']:.1f}",
        ),
    ]
    rate = CORES / cpu
    paper = [
        ("core hours; hours", f"{SCANS * cpu / 3600:,.0f}; {SCANS * cpu / CORES / 3600:.2f}"),
        (f"cost at {PRICE} $ a core hour", f"{SCANS * cpu / 3600 * PRICE:.0f} $"),
        ("results a second, which the driver must write down", f"{rate:,.0f}"),
        ("bytes written a second, by all", f"{rate * moved / 1e6:,.0f} MB"),
        ("memory of all processes at a time", f"{CORES * memory[count // 2] / 2**30:.0f} GB"),
        ("manifest; memory of the driver", f"{SCANS * size / 1e6:.0f} MB; {SCANS * kept / 1e6:.0f} MB"),
        ("to take it up again: reading the manifest", f"{SCANS / read:.0f} s"),
    ]
    text = table_of(("what was measured", "figure"), figures)
    text += "\n\n" + table_of((f"{SCANS:,} such scans on {CORES} such cores, on paper", "figure"), paper)
    print(text)
    if arguments.docs:
        renew("fleet", "fleet_cost.py", text)


def table_of(heading, rows):
    lines = [heading, ("---", "---"), *rows]
    return "\n".join(f"| {what} | {figure} |" for what, figure in lines)


if __name__ == "__main__":
    main()
