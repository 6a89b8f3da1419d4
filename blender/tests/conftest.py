"""Blender as a Python module, with the extension installed from its zip as Blender does it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def bpy(tmp_path_factory):
    """Blender with the extension of the zip `ISOMEND_EXTENSION` installed and switched on, in a user folder of its own."""
    os.environ["BLENDER_USER_RESOURCES"] = str(tmp_path_factory.mktemp("user"))
    import bpy

    bpy.ops.preferences.addon_enable(module="bl_pkg")
    done = bpy.ops.extensions.package_install_files(
        filepath=os.environ["ISOMEND_EXTENSION"], repo="user_default", enable_on_install=True
    )
    assert done == {"FINISHED"}
    import isomend

    assert isomend.__file__.startswith(os.environ["BLENDER_USER_RESOURCES"]), "isomend was not imported from the extension's wheel"
    return bpy


@pytest.fixture
def extension(bpy):
    """The modules of the extension."""
    name = next(name for name in sys.modules if name.endswith(".user_default.isomend"))
    return sys.modules[name]


@pytest.fixture
def scene(bpy):
    """An empty scene."""
    for item in list(bpy.data.objects):
        bpy.data.objects.remove(item)
    for mesh in list(bpy.data.meshes):
        bpy.data.meshes.remove(mesh)
    bpy.context.view_layer.material_override = None
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = "METRIC", 1.0
    return bpy.context.scene


@pytest.fixture(scope="session")
def program():
    """The command line, on a PLY file."""
    found = os.environ.get("ISOMEND") or shutil.which("isomend")
    assert found, "there is no program isomend: set ISOMEND"

    def run(*words):
        done = subprocess.run([found, *map(str, words)], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr

    return run
