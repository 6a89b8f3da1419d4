"""Fleets on a local Ray: a failure, a hang or too much memory affects one mesh only, and no mesh is lost or done twice."""

import csv
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import shapes

import isomend

ray = pytest.importorskip("ray", reason="Ray is not installed: pip install 'isomend[fleet]'")

from isomend import fleet  # noqa: E402
from isomend.fleet._manifest import line_of, row_of, rows  # noqa: E402


@pytest.fixture(scope="module")
def local():
    """A local Ray with two workers, shared by all tests."""
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False, logging_level="ERROR")
    yield
    ray.shutdown()


@pytest.fixture
def scans(tmp_path):
    """A folder of eight meshes, two of them in a subfolder."""
    folder = tmp_path / "scans"
    (folder / "deep").mkdir(parents=True)
    for number in range(8):
        vertices, faces = shapes.open_sphere(around=24 + 2 * number, latitudes=12, top=3)
        place = folder / "deep" if number < 2 else folder
        isomend.Model(vertices, faces).write(place / f"{number}.ply")
    return folder


def slow(folder, count):
    """Meshes that take at least two seconds each, so that a check once a second sees them in work."""
    folder.mkdir()
    for number in range(count):
        isomend.Model(*shapes.open_sphere(around=240 + number, latitudes=120, top=48)).write(folder / f"{number:02}.ply")
    return folder


def manifest(output):
    return list(rows(output / ".fleet" / "manifest.jsonl"))


def children(output, mesh=""):
    """Processes that work on the meshes of an output folder, or on one mesh: process number to its parent's number."""
    found = {}
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().decode().split("\0")
            if any("isomend.fleet._child" in word for word in words) and any(str(output) in word and mesh in word for word in words):
                found[int(process.name)] = int((process / "stat").read_text().rsplit(")")[1].split()[1])
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


def wait_until(holds, seconds=60):
    end = time.monotonic() + seconds
    while not (value := holds()):
        assert time.monotonic() < end, f"the condition did not hold within {seconds} s"
        time.sleep(0.02)
    return value


def check_whole(inputs, output, program, tmp_path):
    """Asserts that every result exists, that the first two equal the command line's, and that no temporary file is left."""
    results = sorted(p.relative_to(output) for p in output.rglob("*.ply"))
    assert results == sorted(p.relative_to(inputs) for p in inputs.rglob("*.ply"))
    for name in results[:2]:
        subprocess.run([program, "fill", inputs / name, "-o", tmp_path / "one.ply", "-q"], check=True)
        assert (output / name).read_bytes() == (tmp_path / "one.ply").read_bytes()
    assert sorted(p.name for p in (output / ".fleet").iterdir()) == ["lock", "lock-summary", "manifest.jsonl"]


def test_incomplete_and_changed_manifest_lines_are_ignored():
    line = line_of({"input": "ä \"1\".ply", "size": 3}).encode()
    assert row_of(line) == {"input": "ä \"1\".ply", "size": 3}
    for length in range(len(line)):
        assert row_of(line[:length]) is None
    assert row_of(line.replace(b"3", b"4")) is None


def test_each_mesh_of_a_fleet_is_done_once(local, scans, tmp_path, program):
    output, counts = tmp_path / "out", []
    state = fleet.run([scans], output, progress=lambda state: counts.append(state.done), max_diameter=5)
    assert state.outcomes == {"done": 8} and counts[-1] == 8
    check_whole(scans, output, program, tmp_path)
    before = {path: path.stat().st_mtime_ns for path in output.rglob("*.ply")}
    # The last line of the manifest is cut off, as if the machine had died while it was written.
    path = output / ".fleet" / "manifest.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    torn = json.loads(lines[-1])["output"]
    path.write_bytes(b"".join(lines[:-1]) + lines[-1][:40])
    # One input has a new time and the same content, one result is missing, and one mesh is new.
    names = [json.loads(line)["output"] for line in lines[:-1]]
    os.utime(scans / names[0])
    (output / names[1]).unlink()
    isomend.Model(*shapes.open_sphere(around=20, latitudes=10, top=2)).write(scans / "new.ply")
    state = fleet.run([str(scans)], output, max_diameter=5)
    assert (state.earlier, state.outcomes) == (5, Counter(done=3, same=1))
    again = {str(p.relative_to(output)) for p in output.rglob("*.ply") if before.get(p) != p.stat().st_mtime_ns}
    assert again == {torn, names[1], "new.ply"}
    assert fleet.run([scans], output, max_diameter=5).earlier == 9
    with open(output / "summary.csv", newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 9 and {row["outcome"] for row in table} == {"done"}
    assert all(float(row["seconds"]) > 0 and 5e6 < int(row["memory"]) < 1e9 for row in table)
    parquet = pytest.importorskip("pyarrow.parquet").read_table(output / "summary.parquet")
    assert parquet.num_rows == 9 and parquet["closed"].to_pylist() == [1] * 9
    # Other options give other results, so that all meshes are done again.
    assert fleet.run([scans], output, max_diameter=0.001).outcomes == {"done": 9}


def test_a_bad_mesh_does_not_affect_others(local, scans, tmp_path):
    (scans / "bad.ply").write_text("ply\nnonsense")
    isomend.Model(*shapes.open_sphere(around=160, latitudes=80, top=32)).write(scans / "hangs.ply")
    vertices, faces = shapes.open_sphere(around=16, latitudes=8, top=1)
    many = [vertices + (3.0 * number, 0, 0) for number in range(9000)]
    large = np.vstack([faces + len(vertices) * number for number in range(9000)])
    isomend.Model(np.vstack(many), large).write(scans / "large.ply")
    output, done = tmp_path / "out", threading.Event()

    def stop():
        """Stops the process of one mesh, so that it hangs."""
        while not done.is_set():
            for child in children(output, "hangs.ply"):
                os.kill(child, signal.SIGSTOP)
            time.sleep(0.01)

    stopper = threading.Thread(target=stop)
    stopper.start()
    state = fleet.run([scans], output, timeout=15, memory=0.1)
    done.set()
    stopper.join()
    outcomes = {row["output"]: row["outcome"] for row in manifest(output)}
    assert outcomes["bad.ply"] == "failed" and outcomes["hangs.ply"] == "timeout" and outcomes["large.ply"] == "memory", outcomes
    others = [outcome for name, outcome in outcomes.items() if name not in ("bad.ply", "hangs.ply", "large.ply")]
    assert len(others) == 8 and not {"failed", "crashed"} & set(others)
    assert not (output / "bad.ply").exists() and not (output / "hangs.ply").exists() and not children(output)
    errors = {row["output"]: row["error"] for row in manifest(output)}
    assert "bad.ply" in errors["bad.ply"] and "after 15 s" in errors["hangs.ply"] and "0.1 GB" in errors["large.ply"]
    done = [row for row in manifest(output) if row["outcome"] == "done"]
    assert done and not any(row["error"] for row in done)
    assert state.done == 11
    assert fleet.run([scans], output, timeout=15, memory=0.1).earlier == 11
    (scans / "large.ply").unlink()
    again = fleet.run([scans], output, timeout=60, retry=True)
    # On a slow machine others may have timed out too.
    assert again.earlier == len(done) and again.outcomes == {"failed": 1, "done": 9 - len(done)}


def test_no_mesh_is_lost_if_a_worker_is_killed(local, tmp_path, program):
    inputs, output = slow(tmp_path / "slow", 5), tmp_path / "out"
    killed = []

    def kill(state):
        if len(killed) < 2 and (found := children(output)):
            child, worker = found.popitem()
            os.kill(worker, signal.SIGKILL)
            killed.append(worker)
            wait_until(lambda: child not in children(output), 5)

    state = fleet.run([inputs], output, progress=kill)
    assert killed and state.outcomes == {"done": 5}
    assert Counter(row["output"] for row in manifest(output)) == {path.name: 1 for path in inputs.iterdir()}
    check_whole(inputs, output, program, tmp_path)


def test_no_mesh_is_lost_if_the_driver_is_killed(local, tmp_path, program):
    inputs, output = slow(tmp_path / "slow", 6), tmp_path / "out"
    words = [sys.executable, "-m", "isomend.fleet", str(inputs), "-o", str(output), "--workers", "2"]
    driver = subprocess.Popen(words, stderr=subprocess.PIPE, start_new_session=True)
    wait_until(lambda: len(manifest(output)) >= 2 and len(children(output)) == 2)
    with pytest.raises(isomend.IsomendError, match="another fleet"):
        fleet.run([inputs], output)
    driver.kill()
    driver.wait()
    wait_until(lambda: not children(output), 30)
    before = {row["output"] for row in manifest(output)}
    times = {name: (output / name).stat().st_mtime_ns for name in before}
    state = fleet.run([inputs], output)
    assert state.earlier == len(before) >= 2 and state.outcomes["done"] == 6 - len(before)
    assert times == {name: (output / name).stat().st_mtime_ns for name in before}
    assert Counter(row["output"] for row in manifest(output)) == {path.name: 1 for path in inputs.iterdir()}
    check_whole(inputs, output, program, tmp_path)


def test_the_regions_of_one_mesh_are_filled_by_many_workers(local):
    model = isomend.Model(*shapes.open_ends())
    alone = model.fill(voxel=0.07)
    shared = fleet.fill_regions(model, voxel=0.07)
    assert shared.to_bytes("ply") == alone.to_bytes("ply")


def test_invalid_options_and_inputs_are_refused(local, scans, tmp_path):
    for options, what in (
        ({"arguments": ["--voxe", "1"]}, "--voxe"),
        ({"edge_ratio": 100}, "edge-ratio"),
        ({"arguments": ["--report", "a.html"]}, "one mesh"),
        ({"to": "xyz"}, "xyz"),
    ):
        with pytest.raises(isomend.ParameterError, match=what):
            fleet.run([scans], tmp_path / "out", **options)
    with pytest.raises(isomend.ParameterError, match="would go to 0.ply"):
        fleet.run([scans / "deep", scans / "deep" / "0.ply"], tmp_path / "out")
    with pytest.raises(isomend.ParameterError, match="there is no file or folder"):
        fleet.run([tmp_path / "none"], tmp_path / "out")
    with pytest.raises(isomend.ParameterError, match="there are no meshes"):
        fleet.run([str(tmp_path / "*.obj")], tmp_path / "out")
    listed = tmp_path / "list.txt"
    listed.write_text(f"{scans / '4.ply'}\n\n{scans / 'deep' / '0.ply'}\n")
    state = fleet.run([f"@{listed}"], tmp_path / "out", to="obj", holes=[1], bridge=())
    assert state.outcomes == {"done": 2} and (tmp_path / "out" / "0.obj").exists()
