"""Fixtures of the tests."""

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
    """The result of a fill of the ball."""
    return isomend.fill(*sphere)


@pytest.fixture(scope="session")
def program():
    """The path of the command-line program: from the variable ISOMEND, else from the installed package."""
    named = os.environ.get("ISOMEND")
    found = named or shutil.which("isomend", path=str(Path(sys.executable).parent))
    assert found, "there is no program isomend: install the package, or set ISOMEND"
    return found


@pytest.fixture(autouse=True)
def in_doctests(doctest_namespace):
    """Makes numpy available as np in the examples of docstrings."""
    doctest_namespace["np"] = np
