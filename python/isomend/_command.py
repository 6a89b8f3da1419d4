"""The command `isomend`."""

from __future__ import annotations

import sys

from isomend import _isomend


def main() -> int:
    """Runs the command line; its exit code."""
    return _isomend.main(sys.argv)
