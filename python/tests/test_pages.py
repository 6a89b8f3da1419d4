"""The code and commands in the documentation pages run."""

import re
import shlex
import subprocess
import sys

import pytest
from conftest import DATA, ROOT


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", (ROOT / "docs" / page).read_text(), re.M | re.S)


def desk(tmp_path):
    (tmp_path / "data").symlink_to(DATA)
    return tmp_path


def test_the_code_of_the_python_page_runs(tmp_path, monkeypatch):
    pytest.importorskip("meshio")
    monkeypatch.chdir(desk(tmp_path))
    recipes, names = blocks("python.md", "python"), {}
    assert len(recipes) == 9
    for number, recipe in enumerate(recipes):
        exec(compile(recipe, f"recipe {number + 1}", "exec"), names)
    files = ("restored.glb", "smooth.ply", "repaired.ply", "repaired.html", "repaired.png", "distance.vti", "repaired.stl")
    assert all((tmp_path / name).exists() for name in files)


def test_the_commands_of_the_fleets_page_run(tmp_path):
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'isomend[fleet]'")
    lines = [line.split("  #")[0].strip() for block in blocks("fleets.md", "sh") for line in block.splitlines()]
    commands = [shlex.split(line) for line in lines if line.startswith("python -m isomend.fleet") and "ray://" not in line]
    assert len(commands) >= 2
    for words in commands:
        done = subprocess.run([sys.executable, *words[1:]], cwd=desk(tmp_path) if not (tmp_path / "data").exists() else tmp_path,
                              capture_output=True, text=True)  # fmt: skip
        assert done.returncode in (0, 3), done.stderr
    assert (tmp_path / "mended" / "summary.csv").exists()


def test_the_code_of_the_fleets_page_runs(tmp_path, monkeypatch):
    pytest.importorskip("ray", reason="Ray is not installed: pip install 'isomend[fleet]'")
    monkeypatch.chdir(desk(tmp_path))
    for recipe in blocks("fleets.md", "python"):
        done = subprocess.run([sys.executable, "-c", recipe], cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
