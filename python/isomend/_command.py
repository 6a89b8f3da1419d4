"""The console script `isomend`: the command line program."""

from __future__ import annotations

import sys

from isomend import _isomend


def main() -> int:
    """Runs the command line with the arguments of this process; returns its exit code."""
    return _isomend.main(sys.argv)
