"""Data delivered with a result: the missing piece, patches alone, marks, units, tolerances, hashes."""

import subprocess

import numpy as np
import pytest
from conftest import DATA

import isomend

RED = {"colours": [{"rgb": [1, 0, 0], "tolerance": 0.1}], "grow": 0.05}


def test_the_command_line_writes_the_same_piece_patches_and_report(tmp_path, program):
    words = ["--colour", "ff0000", "--grow", "0.05", "--mark", "hatch", "--unit", "mm", "--tolerance", "0.5"]
    files = ["-o", "whole.ply", "--piece", "piece.stl", "--patches", "added.ply"]
    subprocess.run([program, "restore", DATA / "painted.ply", *files, *words, "-q"], cwd=tmp_path, check=True)
    theirs = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    restored = isomend.read(DATA / "painted.ply").restore(RED)
    own = tmp_path / "own"
    own.mkdir()
    filed = restored.delivering(
        piece=own / "piece.stl", patches=own / "added.ply", mark="hatch", unit="mm", tolerance=0.5
    )
    filed.write(own / "whole.ply")
    assert {p.name: p.read_bytes() for p in own.iterdir()} == theirs
    report = filed.report
    assert report["unit"] == "mm" and "seconds" not in report
    assert len(report["input"]["sha256"]) == 64 if "sha256" in report["input"] else True
    assert report["invented"]["beyond_tolerance"] == []
    assert restored.piece().check()
    added = restored.patches()
    assert len(added.faces) == restored.is_patch.sum()
    assert set(added.cell_data["isomend_hole"]) == {1}
    assert np.nanmax(added.point_data["isomend_sigma"]) > 0


def test_invalid_options_are_refused():
    filled = isomend.read(DATA / "sphere.ply").fill()
    for wrong in ({"unit": "parsec"}, {"mark": "red"}, {"tolerance": -1.0}, {"piece": "piece.stl"}):
        with pytest.raises(isomend.ParameterError):
            filled.delivering(**wrong)
    with pytest.raises(isomend.ParameterError, match="cuts out"):
        filled.piece()
    with pytest.raises(isomend.ParameterError, match="colours"):
        filled.delivering(mark="hatch").to_bytes("stl")
