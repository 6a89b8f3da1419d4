"""Blender extension of isomend: fills holes, restores and fairs selected faces, and repairs the active mesh.

docs/blender.md describes it. The numerics are those of the Python package `isomend`, whose wheel lies in the extension.
"""

from . import expected_error, holes, operators, panel, settings

MODULES = (settings, holes, operators, expected_error, panel)


def register():
    """Called by Blender when the extension is switched on."""
    for module in MODULES:
        module.register()


def unregister():
    """Called by Blender when the extension is switched off."""
    for module in reversed(MODULES):
        module.unregister()
