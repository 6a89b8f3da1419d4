"""Blender extension of isomend: fills holes, restores and fairs selected faces, repairs and checks the active mesh.

docs/blender.md describes it. The extension contains the wheel of the Python package `isomend`, which does the work.
"""

from . import check, expected_error, holes, operators, panel, settings

MODULES = (settings, holes, operators, check, expected_error, panel)


def register():
    """Called by Blender when the extension is enabled."""
    for module in MODULES:
        module.register()


def unregister():
    """Called by Blender when the extension is disabled."""
    for module in reversed(MODULES):
        module.unregister()
