"""The inputs of a fleet: iterates over the meshes of files, folders, patterns and list files, without holding them all in memory."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from isomend._errors import ParameterError
from isomend.fleet._manifest import short

EXTENSIONS = (".obj", ".ply", ".stl", ".gltf", ".glb", ".vtk", ".vtp")


@dataclass(frozen=True)
class Item:
    """A mesh file, and the name of its result relative to the output folder, with `/` between folders."""

    path: str
    output: str


@dataclass(frozen=True)
class Shard:
    """A part of the meshes of a fleet. A mesh belongs to the part that the hash of its result's name gives, whatever the order of the
    inputs.

    Attributes:
        number: Its number, from 1.
        parts: The number of all parts.
    """

    number: int
    parts: int

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.parts:
            raise ParameterError(f"a shard is a number from 1 to the number of shards, such as 3/16, but is {self.number}/{self.parts}")

    @property
    def suffix(self) -> str:
        """The end of the names of its files."""
        return f"-{self.number}-of-{self.parts}"

    def has(self, item: Item) -> bool:
        """Whether a mesh belongs to it."""
        return short(item.output) % self.parts == self.number - 1


def items(inputs: Sequence[str], output: Path, to: str | None, shard: Shard | None = None) -> Iterator[Item]:
    """Iterates over the meshes of a shard, or over all: see :func:`every`."""
    return (item for item in every(inputs, output, to) if shard is None or shard.has(item))


def every(inputs: Sequence[str], output: Path, to: str | None) -> Iterator[Item]:
    """Iterates over all meshes: files, meshes in folders (the results keep the folders), matches of patterns such as ``scans/*.ply``, and
    paths in list files (``@FILE``, one path a line). Files in the output folder are skipped."""
    inside = output.resolve()
    for name in inputs:
        for path, relative in _paths(name):
            if inside in Path(path).resolve().parents and Path(name).resolve() != inside:
                continue
            yield Item(path, _renamed(relative, to))


def _paths(name: str) -> Iterator[tuple[str, str]]:
    """The paths that an input stands for, each with the name of its result: relative to a folder, else the file's name."""
    if name.startswith("@"):
        with open(name[1:], encoding="utf-8", errors="surrogateescape") as lines:
            for line in lines:
                path = line.rstrip("\n")
                if path:
                    yield path, os.path.basename(path)
    elif os.path.isdir(name):
        for folder, folders, files in os.walk(name):
            # Sorted, so that every run has the same order; hidden files and folders are skipped.
            folders[:] = sorted(f for f in folders if not f.startswith("."))
            for file in sorted(files):
                if file.lower().endswith(EXTENSIONS) and not file.startswith("."):
                    path = os.path.join(folder, file)
                    yield path, os.path.relpath(path, name)
    elif glob.has_magic(name) and not os.path.exists(name):
        for path in glob.iglob(name, recursive=True):
            if path.lower().endswith(EXTENSIONS):
                yield path, os.path.basename(path)
    elif os.path.exists(name):
        yield name, os.path.basename(name)
    else:
        raise ParameterError(f"there is no file or folder {name}; options of `isomend fill` must come after all inputs")


def _renamed(relative: str, to: str | None) -> str:
    stem, extension = os.path.splitext(relative.replace(os.sep, "/"))
    return f"{stem}.{to}" if to else stem + extension


def counted(inputs: Sequence[str], output: Path, to: str | None, shard: Shard | None = None) -> tuple[int, int]:
    """The number of meshes, of all and of a shard. A `ParameterError` if two results would have the same name."""
    seen: set[int] = set()
    count = own = 0
    for item in every(inputs, output, to):
        count += 1
        own += shard is None or shard.has(item)
        name = hash(item.output)
        if name in seen:
            raise ParameterError(
                f"the results of two meshes would go to {item.output}, the second from {item.path}; give their common folder "
                "instead, so that results keep their folders, or use a run and an output folder for each"
            )
        seen.add(name)
    return count, own
