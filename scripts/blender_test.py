"""Tests the Blender extension without a window: packs it with a wheel, and runs blender/tests in Blender's Python module `bpy`.

    cargo build --release && python3 scripts/blender_test.py --wheel WHEEL [--isomend PROGRAM]

The extension is installed from its zip by Blender's own installer. Positions are compared with the program's output. If `bpy` cannot be
installed, the tests are left out, with a message."""

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from blender_environment import ROOT, python_with_blender
from left_out import left_out

# Runs the validation of extensions that is part of Blender.
VALIDATE = """
import bpy, pathlib, runpy, sys
tool = pathlib.Path(bpy.utils.system_resource("SCRIPTS")) / "addons_core/bl_pkg/cli/blender_ext.py"
sys.argv = [str(tool), "validate", sys.argv[1]]
runpy.run_path(str(tool), run_name="__main__")
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend", help="the program")
    parser.add_argument("--wheel", type=Path, required=True, help="a wheel of isomend for this system")
    arguments = parser.parse_args()
    python, why = python_with_blender("pytest==9.2.0")
    if python is None:
        left_out("The tests of the Blender extension", why)
        return
    with tempfile.TemporaryDirectory() as folder:
        pack = [sys.executable, ROOT / "scripts/blender_extension.py", "--out", folder, arguments.wheel.resolve()]
        packed = subprocess.run(pack, check=True, capture_output=True, text=True).stdout.strip()
        subprocess.run([python, "-c", VALIDATE, packed], check=True)
        environment = os.environ | {"ISOMEND": str(arguments.isomend.resolve()), "ISOMEND_EXTENSION": packed}
        # Run in the folder of the tests: from above, pytest would import `blender` as a package, and Blender would not find the extension.
        tests = [python, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
        sys.exit(subprocess.run(tests, env=environment, cwd=ROOT / "blender/tests").returncode)


if __name__ == "__main__":
    main()
