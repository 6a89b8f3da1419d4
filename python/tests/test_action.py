"""The script of the GitHub action: the table of a repository's meshes, and its exit codes."""

import os
import subprocess
import sys

import pytest
import shapes
from conftest import ROOT

import isomend


@pytest.fixture
def repository(tmp_path):
    """Two sound meshes, an open one, a damaged one, and a program that is the Python package's."""
    for folder in ("parts", "drafts"):
        (tmp_path / folder).mkdir()
    isomend.Model(*shapes.open_sphere(around=24, latitudes=12, top=3)).write(tmp_path / "parts/open.ply")
    isomend.Model(*shapes.open_sphere(around=24, latitudes=12, top=3)).fill().write(tmp_path / "parts/a|b.stl")
    isomend.Model(*shapes.open_sphere(around=24, latitudes=12, top=3)).fill().write(tmp_path / "parts/--json.ply")
    (tmp_path / "drafts/broken.ply").write_text("ply\nno mesh\n")
    program = tmp_path / "program"
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m isomend "$@"\n')
    program.chmod(0o755)
    return tmp_path


def run(repository, **variables):
    files = {name: str(repository / f"{name}.txt") for name in ("GITHUB_STEP_SUMMARY", "GITHUB_OUTPUT")}
    for path in files.values():
        open(path, "w").close()
    command = [sys.executable, str(ROOT / "scripts/action/check.py"), "--isomend", str(repository / "program")]
    done = subprocess.run(command, cwd=repository, env=os.environ | files | variables, capture_output=True, text=True)
    return done, *((repository / f"{name}.txt").read_text() for name in files)


def test_a_table_of_all_meshes_is_written_and_unsound_ones_fail(repository):
    done, table, output = run(repository, FILES="**/*.ply\n**/*.stl\n\nparts/*")
    assert done.returncode == 1, done.stderr
    lines = table.splitlines()
    assert lines[0] == "### 2 of 4 meshes are not sound"
    assert {line.split("|")[1].strip() for line in lines[4:6]} == {"`parts/open.ply`", "`drafts/broken.ply`"}
    assert "1 hole is open" in table and "`parts/a\\|b.stl`" in table
    assert output == "unsound=2\n"
    assert done.stdout.count("::error file=") == 2


def test_sound_meshes_pass_and_exclusions_and_options_are_kept(repository):
    done, table, output = run(repository, FILES="**/*.ply\n**/*.stl", EXCLUDE="drafts/**\n**/open.ply")
    assert done.returncode == 0 and table.startswith("### All 2 meshes are sound"), done.stderr
    assert output == "unsound=0\n"
    done, table, _ = run(repository, FILES="parts/*.stl", OPTIONS="--min-wall 1e6")
    assert done.returncode == 1 and "1 of 1" in table
    done, table, _ = run(repository, FILES="drafts/*.ply")
    assert done.returncode == 1 and "1 of 1" in table
    assert run(repository, FILES="parts/*.stl", OPTIONS="--nothing")[0].returncode == 2
    assert run(repository, FILES="none/*.ply")[0].returncode == 2


def test_names_of_files_are_escaped_in_workflow_commands(repository):
    name = "parts/50%,a:b::error file=x::y\nz.ply"
    (repository / "parts/open.ply").rename(repository / name)
    done, table, _ = run(repository, FILES="parts/50*.ply")
    assert done.returncode == 1, done.stderr
    errors = [line for line in done.stdout.splitlines() if line.startswith("::")]
    assert len(errors) == 1 and len(done.stdout.splitlines()) == 1, done.stdout
    assert errors[0].startswith("::error file=parts/50%25%2Ca%3Ab%3A%3Aerror file=x%3A%3Ay%0Az.ply::"), errors
    assert len(table.splitlines()) == 5
