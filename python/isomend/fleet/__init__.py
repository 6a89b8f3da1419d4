"""Batch filling of many meshes, on many cores or machines, as the program `python -m isomend.fleet` and as functions. It needs Ray
(``pip install isomend[fleet]``), but for shards."""

from isomend.fleet._driver import State, run
from isomend.fleet._regions import fill_regions

__all__ = ["State", "fill_regions", "run"]
