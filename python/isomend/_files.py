"""Meshes in place of files: the library reads the closed meshes of masks (``inside``) and counterparts (``like``) from files."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from isomend._errors import FileError, IsomendError, ParameterError
from isomend._foreign import is_pair, is_single

if TYPE_CHECKING:
    from isomend._params import Mask

LIKE = "like must be 'mirror', 'mirror:x,y,z,nx,ny,nz', the path of a mesh, or a mesh"
INSIDE = "inside of the mask must be closed meshes, or their paths"


@contextlib.contextmanager
def in_files(
    mask: Mask | None, parameters: Mapping[str, Any], model_of: Callable[[Any], Any]
) -> Iterator[tuple[Mask | None, Mapping[str, Any]]]:
    """The mask and the parameters with paths in place of meshes under ``inside`` and ``like``. The files exist until the end of the context.
    ``model_of`` makes a model of a mesh."""
    import tempfile

    inside = mask.get("inside") if isinstance(mask, Mapping) else None
    meshes = [] if inside is None else _meshes(inside)
    like = parameters.get("like")
    if meshes and isinstance(mask, Mapping):
        # An iterator yields its meshes once.
        mask = {**mask, "inside": meshes}
    given = [mesh for mesh in (*meshes, like) if mesh is not None and not _is_path(mesh)]
    if not given:
        yield mask, parameters
        return
    with tempfile.TemporaryDirectory() as folder:
        names: dict[str, str] = {}

        def path_of(mesh: Any, must: str, name: str) -> Any:
            if mesh is None or _is_path(mesh):
                return mesh
            try:
                model = model_of(mesh)
            except IsomendError as error:
                raise ParameterError(f"{must}, but {error}") from None
            path = Path(folder) / f"{len(names)}.ply"
            model.write(path)
            names[str(path)] = name
            return path

        if meshes and isinstance(mask, Mapping):
            mask = {**mask, "inside": [path_of(mesh, INSIDE, f"mesh {i} of inside") for i, mesh in enumerate(meshes, 1)]}
        if like is not None:
            parameters = {**parameters, "like": path_of(like, LIKE, "the mesh of like")}
        try:
            yield mask, parameters
        except IsomendError as error:
            # The caller does not know the files.
            for path, name in names.items():
                error.args = tuple(part.replace(path, name) if isinstance(part, str) else part for part in error.args)
                if isinstance(error, FileError) and error.filename == path:
                    error.filename = None
            raise


def _is_path(mesh: Any) -> bool:
    return isinstance(mesh, (str, os.PathLike))


def _meshes(inside: Any) -> list[Any]:
    """The meshes under ``inside``: one mesh, or several. A pair of arrays is one mesh, a pair of meshes is two."""
    if getattr(getattr(inside, "dtype", None), "kind", "") in ("O", "U"):
        inside = inside.tolist()
    if isinstance(inside, (str, bytes, os.PathLike, Mapping)) or is_pair(inside) or is_single(inside) or not isinstance(inside, Iterable):
        return [inside]
    return list(inside)
