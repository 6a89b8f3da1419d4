"""The keywords of functions, written from the library's tables of parameters: see docs/ARCHITECTURE.md."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal

from isomend._holes import CreaseEnd, Hole
from isomend._params import RunOptions, Voxel


class SolveOptions(RunOptions, total=False):
    """The parameters of all works that fill holes."""

    voxel: Voxel
    energy: Literal["willmore", "curvature-variation"]
    finish: Literal["auto", "willmore", "none"]
    sharp: Literal["auto", "off"]
    like: Any
    grain: bool
    apart: bool
    edge_ratio: float | None


class FillOptions(SolveOptions, total=False):
    """The keywords of :func:`isomend.fill`."""

    holes: Iterable[int | Hole] | Literal['all'] | None
    max_diameter: float | None
    keep_open: Iterable[int | Hole]
    bridge: Iterable[Iterable[int | Hole]]
    flat: Iterable[int | Hole]
    crease: Iterable[Iterable[int | CreaseEnd]]
    flat_base: bool
    base_offset: float | None


class RepairOptions(SolveOptions, total=False):
    """The keywords of :func:`isomend.repair`."""

    weld: float | None
    drop: Iterable[int]
    debris: float | None
    flat_base: bool
    base_offset: float | None
    drop_inside: bool
    solid: bool
    skip: Iterable[Literal["duplicates", "orientation", "non-manifold", "intersections", "holes"]]
    drop_unused: bool
    close_borders: bool
    wall: float | None
    min_wall: float | None
    holes: Iterable[int | Hole] | Literal['all'] | None
    max_diameter: float | None
    keep_open: Iterable[int | Hole]
    bridge: Iterable[Iterable[int | Hole]]
    flat: Iterable[int | Hole]
    crease: Iterable[Iterable[int | CreaseEnd]]


class RestoreOptions(SolveOptions, total=False):
    """The keywords of :func:`isomend.restore`."""

    keep_shape: float
    keep_vertices: bool


class FairOptions(RunOptions, total=False):
    """The keywords of :func:`isomend.fair`."""

    strength: float | None
    time: float | None
    voxel: Voxel
    edge_ratio: float
    keep_vertices: bool
