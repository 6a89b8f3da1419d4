"""What the tests share."""

import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import shapes

import isomend

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "data"


@pytest.fixture(scope="session")
def sphere():
    """Vertices and faces of a ball with a hole."""
    return shapes.open_sphere()


@pytest.fixture(scope="session")
def filled(sphere):
    """The same, filled."""
    return isomend.fill(*sphere)


@pytest.fixture(scope="session")
def program():
    """The program of the command line: the one of the build, else that of the package."""
    named = os.environ.get("ISOMEND")
    found = named or shutil.which("isomend", path=str(Path(sys.executable).parent))
    assert found, "there is no program isomend: install the package, or set ISOMEND"
    return found


@pytest.fixture(autouse=True)
def in_doctests(doctest_namespace):
    """Names in the examples of docstrings."""
    doctest_namespace["np"] = np
