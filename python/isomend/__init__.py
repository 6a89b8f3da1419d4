"""isomend fills holes in triangle meshes by 3D level-set Willmore flow, restores marked regions, fairs
surfaces, repairs, checks and compares meshes.

The mesh's own vertices and faces stay bit for bit and in order; new vertices and faces come after them.

>>> import isomend
>>> vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
>>> faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2]]
>>> filled = isomend.fill(vertices, faces, holes=[1])
>>> filled.vertices.shape, filled.faces.shape
((4, 3), (4, 3))
"""

from isomend._adapters import as_model, fair_mesh, fill_mesh, repair_mesh, restore_mesh
from isomend._check import Defect, Verdict
from isomend._compare import Comparison
from isomend._distance import read_volume, sdf, signed_distance, surface
from isomend._errors import (
    Cancelled,
    EmptyMaskError,
    FileError,
    HoleIdError,
    IsomendError,
    MeshError,
    MeshTypeError,
    ParameterError,
)
from isomend._functions import (
    check,
    compare,
    convert,
    fair,
    fill,
    inspect,
    is_cramped,
    read,
    repair,
    restore,
    solve_task,
)
from isomend._holes import CreaseEnd, Hole
from isomend._isomend import __version__
from isomend._mesh import Inspection, Mended, Model, StrictError
from isomend._volume import Volume

__all__ = [
    "Cancelled",
    "Comparison",
    "CreaseEnd",
    "Defect",
    "EmptyMaskError",
    "FileError",
    "Hole",
    "HoleIdError",
    "Inspection",
    "IsomendError",
    "Mended",
    "MeshError",
    "MeshTypeError",
    "Model",
    "ParameterError",
    "StrictError",
    "Verdict",
    "Volume",
    "__version__",
    "as_model",
    "check",
    "compare",
    "convert",
    "fair",
    "fair_mesh",
    "fill",
    "fill_mesh",
    "inspect",
    "is_cramped",
    "read",
    "read_volume",
    "repair",
    "repair_mesh",
    "restore",
    "restore_mesh",
    "sdf",
    "signed_distance",
    "solve_task",
    "surface",
]
