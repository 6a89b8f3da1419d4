"""The benchmark: it reproduces the README's figures, measures distances correctly, and handles programs and cases that fail."""

import json
import re
from types import SimpleNamespace

import numpy as np
import pytest
import shapes
from conftest import ROOT

import isomend
from isomend.bench import __main__ as bench
from isomend.bench import cases, score, surfaces


def of_the_readme():
    """isomend's distances in per mille from the README's table, by the names of the holes."""
    rows = re.findall(r"^\| ([^|]+) \| \**([0-9.]+) ‰\**, [^|]* \|", (ROOT / "README.md").read_text(), re.M)
    return {name: float(value) for name, value in rows}


def test_the_benchmark_reproduces_the_figures_of_the_readme(tmp_path, capsys):
    expected = of_the_readme()
    assert len(expected) == 6
    pattern = "^sphere 60°$|^sphere 60°, (noise 3 %|ragged)$|^torus, outer, fine$"
    assert bench.main(["--set", "exact", "--cases", pattern, "--alone", "--out", str(tmp_path)]) == 0
    rows = json.loads((tmp_path / "bench.json").read_text())["exact"]
    assert len(rows) == 4
    for row in rows:
        # Within 1 % or half a unit of the README's last digit.
        assert row["scores"]["isomend"]["rms"] == pytest.approx(expected[row["case"]], rel=0.01, abs=0.005)
        assert 0 < np.mean(row["below"][0]) <= np.mean(row["below"][1]) <= 1
    page = (tmp_path / "bench.md").read_text()
    assert "| sphere 60° | **0." in page and "nearer than 2 σ" in page and page in capsys.readouterr().out


def test_the_score_of_an_exact_patch_is_correct():
    case = next(cases.cases("^sphere 30°$", score.Reference))
    v, f, gone = case.whole
    own = score.score(case, v, f, gone)
    # Triangles of edge e are up to e²/6 below the unit sphere.
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


def test_a_program_that_fails_or_is_not_installed_gets_a_dash(monkeypatch, capsys):
    def fails(case, aim):
        raise RuntimeError("no")

    monkeypatch.setattr(bench, "TOOLS", {"other": ("Other", ("numpy",), fails), "none": ("None", ("nowhere_to_be_found",), fails)})
    assert bench.main(["--set", "exact", "--cases", "^sphere 30°$"]) == 0
    out = capsys.readouterr()
    assert "| hole | isomend | Other |" in out.out and "| – |" in out.out
    assert "Other failed: no" in out.err and "None is LEFT OUT" in out.err


@pytest.fixture
def sphere():
    return next(cases.cases("^sphere 30°$", score.Reference))


def test_a_case_on_which_isomend_fails_gets_a_dash_and_the_others_are_written(monkeypatch, tmp_path, capsys):
    filled, seen = bench.filled, []

    def fails_at_first(case):
        seen.append((tmp_path / "bench.json").exists())
        if len(seen) == 1:
            raise isomend.IsomendError("no")
        return filled(case)

    monkeypatch.setattr(bench, "filled", fails_at_first)
    words = ["--set", "exact", "--cases", "^sphere (30|60)°$", "--alone", "--out", str(tmp_path)]
    assert bench.main(words) == 0
    assert seen == [False, True], "bench.json is written after each case"
    rows = json.loads((tmp_path / "bench.json").read_text())["exact"]
    assert [list(row["scores"]) for row in rows] == [[], ["isomend"]] and rows[0]["below"] == [[], []]
    out = capsys.readouterr()
    assert "| sphere 30° | – |" in out.out and "isomend failed: no" in out.err and "sphere 30°: –" in out.err


def test_holes_left_open_get_no_score_for_isomend_and_others(monkeypatch, sphere):
    patch = np.zeros(len(sphere.f), bool)
    left = SimpleNamespace(vertices=sphere.v, faces=sphere.f, is_patch=patch, sigma=np.zeros(len(sphere.v)), report={"seconds": 0.0})
    monkeypatch.setattr(bench, "filled", lambda case: left)
    monkeypatch.setattr(bench, "TOOLS", {"other": ("Other", (), lambda case, aim: (case.v, case.f, np.ones(len(case.f), bool), 0.0))})
    assert bench.measured(sphere, ["other"])["scores"] == {}


def test_only_the_hole_that_was_cut_is_scored(sphere):
    v, f, gone = sphere.whole
    # Another hole far from the cut: one face is missing, also from the whole mesh.
    far = np.flatnonzero(~gone)[np.argmin(v[f[~gone]].mean(axis=1) @ v[f[gone]].reshape(-1, 3).mean(axis=0))]
    rest = np.arange(len(f)) != far
    sphere.whole = v, f[rest], gone[rest]
    sphere.v, sphere.f = surfaces.cut(v, f[rest], gone[rest])
    for faces in (f, f[rest]):
        patch, closed = score.marked_at_rim(sphere, v, faces)
        assert closed and patch.sum() == gone.sum(), "whether the other hole is closed makes no difference"
    one = np.flatnonzero(gone)[0]
    for faces in (np.delete(f, one, axis=0), np.vstack([f, f[one]]), f[~gone], f[rest & ~gone]):
        assert not score.marked_at_rim(sphere, v, faces)[1], "open, doubled, or not filled"


def test_without_pymeshlab_the_bunny_alone_is_left_out(monkeypatch, capsys):
    monkeypatch.setattr(bench, "installed", lambda packages: "pymeshlab" not in packages)
    names = [case.name for case in bench.cases_of("exact", "^bunny|^sphere 30°$")]
    assert names == ["sphere 30°"]
    assert bench.main(["--set", "exact", "--cases", "^bunny", "--alone"]) == 1
    assert "bunny: LEFT OUT" in capsys.readouterr().err
