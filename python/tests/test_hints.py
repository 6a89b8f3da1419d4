"""Type hints take what the functions take."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import isomend

CODE = """
import isomend
model = isomend.read("a.ply")
found = model.inspect()
first, second = found.crease_ends[:2]
found.fill(holes=found.holes, keep_open=[2, found.holes[0]], flat=found.holes[:1], bridge=[found.holes], crease=[(first, second)], like=model)
isomend.fill(model, holes=[hole for hole in found.holes if hole.width < 2], crease=[found.crease_ends])
isomend.repair(model, holes="all", drop=[2], like="mirror")
"""


def test_holes_crease_ends_and_meshes_are_accepted(tmp_path):
    pytest.importorskip("mypy")
    folder = Path(isomend.__file__).parents[1]
    # mypy finds installed packages by itself and refuses their folder as a path.
    environment = {**os.environ} if folder.name == "site-packages" else {**os.environ, "MYPYPATH": str(folder)}
    for code, refused in ((CODE, False), (CODE + "isomend.repair(model, drop=found.holes)", True)):
        done = subprocess.run(
            [sys.executable, "-m", "mypy", "--strict", "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True
        )
        assert (done.returncode != 0) == refused, done.stdout
