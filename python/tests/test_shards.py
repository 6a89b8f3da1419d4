"""Shards of a fleet, without Ray: together they fill every mesh once, in any number of processes, and are resumed."""

import csv
import os
import signal
import subprocess
import sys
import time

import pytest
import shapes

import isomend
from isomend import fleet
from isomend.fleet._inputs import Shard, items
from isomend.fleet._manifest import manifests, rows


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
    job = subprocess.Popen(command(scans, output, "--shard", "1/1", "--workers", "1"), stderr=subprocess.PIPE, text=True)
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
