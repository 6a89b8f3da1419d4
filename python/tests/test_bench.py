"""The benchmark: what it measures of isomend is what the README says, its own distances are right, solids have sharp edges."""

import json
import re

import numpy as np
import pytest
import shapes
from conftest import ROOT

import isomend
from isomend.bench import __main__ as bench
from isomend.bench import cases, score


def of_the_readme():
    """isomend's distances in the README's table, by the names of the holes."""
    rows = re.findall(r"^\| ([^|]+) \| \**([0-9.]+) ‰\**, [^|]* \|", (ROOT / "README.md").read_text(), re.M)
    return {name: float(value) for name, value in rows}


def test_it_reproduces_the_figures_of_the_readme(tmp_path, capsys):
    expected = of_the_readme()
    assert len(expected) == 6
    pattern = "^sphere 60°$|^sphere 60°, (noise 3 %|ragged)$|^torus, outer, fine$"
    assert bench.main(["--set", "exact", "--cases", pattern, "--alone", "--out", str(tmp_path)]) == 0
    rows = json.loads((tmp_path / "bench.json").read_text())["exact"]
    assert len(rows) == 4
    for row in rows:
        # Half of the last digit of the README, and 1 %.
        assert row["scores"]["isomend"]["rms"] == pytest.approx(expected[row["case"]], rel=0.01, abs=0.005)
        assert 0 < np.mean(row["below"][0]) <= np.mean(row["below"][1]) <= 1
    page = (tmp_path / "bench.md").read_text()
    assert "| sphere 60° | **0." in page and "nearer than 2 σ" in page and page in capsys.readouterr().out


def test_distances_and_marks_of_a_patch_that_is_known():
    case = next(cases.cases("^sphere 30°$", score.Reference))
    v, f, gone = case.whole
    own = score.score(case, v, f, gone)
    # Triangles of edge e lie up to e²/6 below the unit sphere.
    edge = np.linalg.norm(v[f[gone]] - v[np.roll(f[gone], 1, axis=1)], axis=2).max()
    assert 0 < own["rms"] < 1e3 * edge**2 / 6 / case.diameter and own["faces"] == gone.sum()
    patch, closed = score.marked(case, v, f)
    assert closed and np.array_equal(patch, gone)
    patch, closed = score.marked(case, case.v, case.f)
    assert not closed and not patch.any()


def test_solids_are_closed_and_their_holes_are_filled():
    made = list(cases.solid_cases(score.Reference))
    assert len(made) == 5
    for case in made:
        assert shapes.is_closed(case.whole[1]) and case.whole[2].sum() > 20
    edge = made[0]
    mended = isomend.fill(edge.v, edge.f)
    assert score.score(edge, mended.vertices, mended.faces, mended.is_patch)["rms"] < 1


def test_a_program_that_fails_or_is_not_there_leaves_a_dash(monkeypatch, capsys):
    def fails(case, aim):
        raise RuntimeError("no")

    monkeypatch.setattr(bench, "TOOLS", {"other": ("Other", ("numpy",), fails), "none": ("None", ("nowhere_to_be_found",), fails)})
    assert bench.main(["--set", "exact", "--cases", "^sphere 30°$"]) == 0
    out = capsys.readouterr()
    assert "| hole | isomend | Other |" in out.out and "| – |" in out.out
    assert "Other failed: no" in out.err and "None is LEFT OUT" in out.err
