"""Many meshes, on many cores or machines: `python -m isomend.fleet`, and the same as a function. It needs Ray:
``pip install isomend[fleet]``."""

from isomend.fleet._driver import State, run
from isomend.fleet._regions import fill_regions

__all__ = ["State", "fill_regions", "run"]
