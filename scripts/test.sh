#!/usr/bin/env bash
# All tests: those of cargo, then the cross-check of written files by trimesh and MeshLab in a venv made here.
# Needs Rust, a C compiler and Python 3.11 or newer.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo test --release
cargo build --release

python=.venv/bin/python
wanted=$(cat scripts/requirements.txt)
if [ ! -x "$python" ] || [ "$(cat .venv/installed 2>/dev/null)" != "$wanted" ]; then
    python3 -m venv --clear .venv
    "$python" -m pip install --quiet --disable-pip-version-check -r scripts/requirements.txt
    echo "$wanted" > .venv/installed
fi
"$python" scripts/crosscheck.py
