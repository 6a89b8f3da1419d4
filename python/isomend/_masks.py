"""Masks with models in them: the library reads closed meshes from files."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from isomend._params import Mask


@contextlib.contextmanager
def in_files(mask: Mask | None, kind: type[Any]) -> Iterator[Mask | None]:
    """The mask with paths in place of the models, which are of this kind, under ``inside``. Their files exist until the end of the context."""
    import tempfile

    inside = mask.get("inside") if isinstance(mask, Mapping) else None
    given = list(inside) if isinstance(inside, (list, tuple)) else [inside]
    if mask is None or not isinstance(mask, Mapping) or not any(isinstance(item, kind) for item in given):
        yield mask
        return
    with tempfile.TemporaryDirectory() as folder:
        paths = []
        for number, item in enumerate(given):
            if isinstance(item, kind):
                path = Path(folder) / f"{number}.ply"
                item.write(path)
                item = path
            paths.append(item)
        yield {**mask, "inside": paths}
