"""A virtual environment in `.venv` with Blender as a Python module (`bpy`), for scripts that use the extension. It is made on first use."""

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# For each version of Python the release of `bpy` that has wheels for it: the oldest that the extension supports, and the newest.
RELEASES = {"3.11": "4.2.0", "3.13": "5.2.3"}


def python_with_blender(*packages):
    """The path of a Python with `bpy` and these packages, or none and the reason why it cannot be installed."""
    reason = f"no Python {' or '.join(RELEASES)} was found, which the package bpy needs"
    own = f"{sys.version_info.major}.{sys.version_info.minor}"
    for version in sorted(RELEASES, key=lambda version: version != own):
        found = sys.executable if version == own else shutil.which(f"python{version}")
        # The command may exist and fail, like the shims of pyenv.
        if not found or subprocess.run([found, "-c", ""], capture_output=True).returncode != 0:
            continue
        folder = ROOT / f".venv/blender-{RELEASES[version]}"
        python, mark = folder / "bin/python", folder / "installed"
        wanted = [f"bpy=={RELEASES[version]}", *packages]
        if not mark.exists() or mark.read_text().split() != wanted:
            subprocess.run([found, "-m", "venv", "--clear", folder], check=True)
            command = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *wanted]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode != 0:
                reason = f"{wanted[0]} could not be installed: {done.stderr.strip().splitlines()[-1]}"
                continue
            mark.write_text("\n".join(wanted))
        if subprocess.run([python, "-c", "import bpy"], capture_output=True).returncode != 0:
            reason = f"{wanted[0]} cannot be imported, perhaps since libraries of the system are missing"
            continue
        return python, None
    return None, reason
