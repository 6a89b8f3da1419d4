"""Imports the benchmark of the Python package (python/isomend/bench) for scripts, without the package's compiled module."""

import importlib
import importlib.util
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent.parent / "python/isomend/bench"
NAME = "isomend_bench"

spec = importlib.util.spec_from_file_location(NAME, FOLDER / "__init__.py", submodule_search_locations=[str(FOLDER)])
sys.modules[NAME] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules[NAME])
surfaces = importlib.import_module(f"{NAME}.surfaces")
cases = importlib.import_module(f"{NAME}.cases")
peers = importlib.import_module(f"{NAME}.peers")
