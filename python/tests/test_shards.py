"""Shards of a fleet, without Ray: together they fill every mesh once, in any number of processes, and are resumed."""

import csv
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest
import shapes

import isomend
from isomend import fleet
from isomend.fleet._inputs import Shard, items
from isomend.fleet import _pools
from isomend.fleet._manifest import FOLDER, Manifest, manifests, rows
from isomend.fleet._summary import last_rows


@pytest.fixture
def scans(tmp_path):
    """A folder of nine meshes."""
    folder = tmp_path / "scans"
    folder.mkdir()
    for number in range(9):
        isomend.Model(*shapes.open_sphere(around=24 + 2 * number, latitudes=12, top=3)).write(folder / f"{number}.ply")
    return folder


def command(scans, output, *options):
    return [sys.executable, "-m", "isomend.fleet", str(scans), "-o", str(output), "-q", *options]


def summary(output):
    with open(output / "summary.csv", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_shards_share_the_meshes_whatever_the_order_of_the_inputs(scans, tmp_path):
    names = [str(path) for path in sorted(scans.iterdir())]
    parts = [[item.output for item in items(names, tmp_path / "out", None, Shard(number, 3))] for number in (1, 2, 3)]
    again = [[item.output for item in items(names[::-1], tmp_path / "out", None, Shard(number, 3))] for number in (1, 2, 3)]
    assert sorted(sum(parts, [])) == sorted(os.path.basename(name) for name in names)
    assert [sorted(part) for part in parts] == [sorted(part) for part in again]
    assert sum(map(bool, parts)) >= 2


def test_an_array_of_processes_fills_every_mesh_once(scans, tmp_path):
    output = tmp_path / "out"
    array = [subprocess.Popen(command(scans, output, "--shard", f"{number}/3"), stderr=subprocess.PIPE) for number in (1, 2, 3)]
    for job in array:
        _, said = job.communicate(timeout=120)
        assert job.returncode == 0, said
    assert sorted(row["output"] for row in summary(output)) == [f"{number}.ply" for number in range(9)]
    assert all(row["outcome"] == "done" for row in summary(output))
    assert sum(len(list(rows(path))) for path in manifests(output)) == 9
    alone = isomend.read(scans / "4.ply").fill()
    alone.write(tmp_path / "alone.ply")
    assert (output / "4.ply").read_bytes() == (tmp_path / "alone.ply").read_bytes()
    assert not [path for path in output.rglob("*") if path.name.endswith(".part") or "work" in path.name]
    # Another number of shards finds them done; a changed mesh is filled again, by its own shard.
    isomend.Model(*shapes.open_sphere(around=50, latitudes=12, top=3)).write(scans / "4.ply")
    states = [fleet.run([scans], output, shard=(number, 2), workers=1) for number in (1, 2)]
    assert sum(state.all for state in states) == 9
    assert sum(state.earlier for state in states) == 8
    assert sum(state.outcomes["done"] for state in states) == 1
    assert len(summary(output)) == 9


def test_a_faulty_mesh_and_wrong_options_are_reported(scans, tmp_path):
    (scans / "broken.ply").write_text("no mesh")
    state = fleet.run([scans], tmp_path / "out", shard=(1, 1), workers=2, threads=1)
    assert state.outcomes == {"done": 9, "failed": 1}
    for shard, part in (("0/3", "from 1"), ("4/3", "from 1"), ("3", "such as 3/16"), ("a/b", "such as 3/16")):
        done = subprocess.run(command(scans, tmp_path / "no", "--shard", shard), capture_output=True, text=True)
        assert done.returncode == 2 and part in done.stderr, done.stderr
    with pytest.raises(isomend.ParameterError, match="not both"):
        fleet.run([scans], tmp_path / "no", shard=(1, 2), address="ray://host:1")


def test_a_shard_that_runs_keeps_its_double_and_whole_fleets_out(scans, tmp_path):
    output = tmp_path / "out"
    tried = []

    def again(state):
        for shard in ((1, 1), (1, 2)):
            try:
                tried.append(fleet.run([scans], output, shard=shard, workers=1).all)
            except isomend.IsomendError as error:
                tried.append(str(error))

    fleet.run([scans], output, shard=(1, 1), workers=1, progress=lambda state: tried or again(state))
    assert "another fleet is writing" in tried[0] and isinstance(tried[1], int)


def test_a_stopped_shard_leaves_no_process_and_is_resumed(tmp_path):
    scans, output = tmp_path / "slow", tmp_path / "out"
    scans.mkdir()
    for number in range(3):
        isomend.Model(*shapes.open_sphere(around=240 + number, latitudes=120, top=48)).write(scans / f"{number}.ply")
    # Where the tests run in the background, their processes ignore the signal of Ctrl-C, and so would this one.
    heeds = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # noqa: E731
    job = subprocess.Popen(command(scans, output, "--shard", "1/1", "--workers", "1"), stderr=subprocess.PIPE, text=True, preexec_fn=heeds)
    end = time.monotonic() + 60
    while not list(output.glob(".fleet/work-1-of-1/*")):
        assert time.monotonic() < end and job.poll() is None
        time.sleep(0.02)
    job.send_signal(signal.SIGINT)
    _, said = job.communicate(timeout=20)
    assert job.returncode == 130 and "again to continue" in said
    words = [b"isomend.fleet._child", str(output).encode()]
    for process in os.listdir("/proc") if os.path.isdir("/proc") else []:
        try:
            with open(f"/proc/{process}/cmdline", "rb") as file:
                line = file.read()
        except OSError:
            continue
        assert not all(word in line for word in words), line
    assert fleet.run([scans], output, shard=(1, 1)).done == 3


def test_of_the_rows_of_several_manifests_the_last_one_counts(tmp_path):
    def row(outcome, digit):
        return {"input": "a.ply", "output": "a.ply", "state": [1, digit], "content": f"{digit}" * 32, "outcome": outcome}

    # The names of the manifests are in the order opposite to the times of their rows.
    written = [("-2-of-2", row("done", 1)), ("-1-of-2", row("failed", 2)), ("-1-of-1", row("same", 3))]
    for number, (suffix, added) in enumerate(written):
        manifest = Manifest(tmp_path, "settings", False, suffix)
        manifest.add(added)
        manifest.close()
        manifest = Manifest(tmp_path, "settings", False, "-1-of-9")
        assert [manifest.is_done("a.ply", (1, digit)) for digit in (1, 2, 3)] == [digit == number + 1 for digit in (1, 2, 3)]
        manifest.close()
        outcomes = [last["outcome"] for last in last_rows(tmp_path)]
        assert outcomes == ["done" if number == 0 else "failed"]
    # A retry leaves alone what is the same as before, and takes what failed.
    manifest = Manifest(tmp_path, "settings", True)
    assert manifest.is_done("a.ply", (1, 3))
    manifest.add(row("failed", 4))
    manifest.close()
    manifest = Manifest(tmp_path, "settings", True)
    assert not manifest.is_done("a.ply", (1, 4))
    manifest.close()


def test_the_folder_of_a_run_is_removed_while_its_lock_is_held(scans, tmp_path, monkeypatch):
    output, removed = tmp_path / "out", []
    remove = shutil.rmtree

    def watched(path, **options):
        if os.path.basename(path).startswith("work"):
            removed.append(path)
            with pytest.raises(isomend.IsomendError, match="another fleet"):
                Manifest(output, "settings", False, "-1-of-1")
        remove(path, **options)

    monkeypatch.setattr(shutil, "rmtree", watched)
    fleet.run([scans], output, shard=(1, 1), workers=1)
    assert len(removed) == 2 and not (output / FOLDER / "work-1-of-1").exists()


def test_a_folder_without_locks_is_named(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", refuse)
    with pytest.raises(isomend.IsomendError, match="cannot be locked .*No locks available"):
        Manifest(tmp_path, "settings", False)


def test_names_that_are_not_utf8_are_kept(scans, tmp_path):
    name = os.fsdecode(b"a\xff.ply")
    try:
        (scans / "4.ply").rename(scans / name)
    except OSError:
        pytest.skip("the file system has only names in UTF-8")
    for earlier in (0, 9):
        state = fleet.run([scans], tmp_path / "out", shard=(1, 1), workers=2)
        assert (state.earlier, state.outcomes["done"]) == (earlier, 9 - earlier)
    assert (tmp_path / "out" / name).exists()
    text = (tmp_path / "out/summary.csv").read_bytes()
    assert b"a\xff.ply,done" in text
    listed = tmp_path / "list.txt"
    listed.write_bytes(os.fsencode(scans / name))
    assert fleet.run([f"@{listed}"], tmp_path / "out", shard=(1, 1)).earlier == 1


def test_an_unexpected_fault_is_the_outcome_of_its_mesh(scans, tmp_path, monkeypatch):
    def faulty(path, *others):
        if path.endswith("4.ply"):
            raise ValueError("a fault")
        return mend(path, *others)

    mend = _pools.mend
    monkeypatch.setattr(_pools, "mend", faulty)
    state = fleet.run([scans], tmp_path / "out", shard=(1, 1), workers=2)
    assert state.outcomes == {"done": 8, "crashed": 1}
    (row,) = [row for row in summary(tmp_path / "out") if row["outcome"] == "crashed"]
    assert row["output"] == "4.ply" and row["error"] == "ValueError: a fault"
