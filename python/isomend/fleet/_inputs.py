"""Which meshes there are, and where their results go: one after the other, never as one list."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from isomend._errors import ParameterError

EXTENSIONS = (".obj", ".ply", ".stl", ".gltf", ".glb", ".vtk", ".vtp")


@dataclass(frozen=True)
class Item:
    """A mesh to read, and the name of its result in the output folder, with `/` between folders."""

    path: str
    output: str


def items(inputs: Sequence[str], output: Path, to: str | None) -> Iterator[Item]:
    """All meshes: those of folders, with their folders kept, of patterns such as ``scans/*.ply``, and of list files (``@FILE``, a
    path a line). What lies in the output folder is none."""
    inside = output.resolve()
    for name in inputs:
        for path, relative in _paths(name):
            if inside in Path(path).resolve().parents and Path(name).resolve() != inside:
                continue
            yield Item(path, _renamed(relative, to))


def _paths(name: str) -> Iterator[tuple[str, str]]:
    """Paths, and their names relative to what names them."""
    if name.startswith("@"):
        with open(name[1:], encoding="utf-8") as lines:
            for line in lines:
                path = line.rstrip("\n")
                if path:
                    yield path, os.path.basename(path)
    elif os.path.isdir(name):
        for folder, folders, files in os.walk(name):
            # Sorted, so that runs go the same way; names that begin with a dot are not meant.
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
        raise ParameterError(f"there is no file or folder {name}; options of `isomend fill` stand behind all inputs")


def _renamed(relative: str, to: str | None) -> str:
    stem, extension = os.path.splitext(relative.replace(os.sep, "/"))
    return f"{stem}.{to}" if to else stem + extension


def counted(inputs: Sequence[str], output: Path, to: str | None) -> int:
    """How many there are; an error if two results would have one name."""
    seen: set[int] = set()
    count = 0
    for item in items(inputs, output, to):
        count += 1
        name = hash(item.output)
        if name in seen:
            raise ParameterError(
                f"two meshes would go to {item.output}, the second from {item.path}; give their common folder instead, whose "
                "folders are kept, or several runs"
            )
        seen.add(name)
    return count
