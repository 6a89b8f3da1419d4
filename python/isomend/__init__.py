"""isomend fills holes in triangle meshes by 3D level-set Willmore flow, restores marked regions, and fairs surfaces.

The mesh's own vertices and faces stay as they are, bit for bit and in order; what is new comes after them.

>>> import isomend
>>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2]]
>>> filled = isomend.fill(vertices, faces, holes=[1])
>>> filled.vertices.shape, filled.faces.shape
((4, 3), (4, 3))
"""

from isomend._adapters import fill_mesh
from isomend._errors import (
    Cancelled,
    EmptyMaskError,
    FileError,
    HoleIdError,
    IsomendError,
    MeshError,
    ParameterError,
)
from isomend._functions import fair, fill, inspect, read, restore, signed_distance, solve_task
from isomend._isomend import __version__
from isomend._mesh import Hole, Inspection, Mended, Model, StrictError

__all__ = [
    "Cancelled",
    "EmptyMaskError",
    "FileError",
    "Hole",
    "HoleIdError",
    "Inspection",
    "IsomendError",
    "Mended",
    "MeshError",
    "Model",
    "ParameterError",
    "StrictError",
    "__version__",
    "fair",
    "fill",
    "fill_mesh",
    "inspect",
    "read",
    "restore",
    "signed_distance",
    "solve_task",
]
