"""What meshes and results hand out: arrays and named values that are read-only, since a change of them would change no mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NoReturn

if TYPE_CHECKING:
    from numpy.typing import NDArray


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The same array, in which numpy allows no changes."""
    array.flags.writeable = False
    return array


class Values(dict[str, Any]):
    """Named values of a mesh: a dictionary of read-only arrays that refuses changes. Its copies, also by pickle, are plain dictionaries.

    >>> heat = Values({})
    >>> heat["heat"] = 1.0
    Traceback (most recent call last):
    ...
    TypeError: the named values of a mesh are read-only; give changed values to isomend.Model(vertices, faces, point_data={**mesh.point_data, ...})
    """

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError(
            "the named values of a mesh are read-only; give changed values to "
            "isomend.Model(vertices, faces, point_data={**mesh.point_data, ...})"
        )

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickles and copies the values as a plain dictionary."""
        return dict, (dict(self),)


def values_of(data: dict[str, NDArray[Any]]) -> Values:
    """The named values with read-only arrays."""
    return Values({name: read_only(array) for name, array in data.items()})
