#!/usr/bin/env bash
# All tests: those of cargo, the commands of the pages, then in a venv made here the cross-check of written files by trimesh and
# MeshLab, and the report in a headless Chromium where there is one. With CI=true a check that cannot run is a failure; else it
# is left out, which is said.
# Needs Rust, a C compiler and Python 3.11 or newer.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo test --release
cargo build --release
python3 scripts/check_docs.py

python=.venv/bin/python
wanted=$(cat scripts/requirements.txt)
if [ ! -x "$python" ] || [ "$(cat .venv/installed 2>/dev/null)" != "$wanted" ]; then
    python3 -m venv --clear .venv
    "$python" -m pip install --quiet --disable-pip-version-check -r scripts/requirements.txt
    echo "$wanted" > .venv/installed
fi
if command -v npm > /dev/null && [ ! -d .venv/node_modules/gltf-validator ]; then
    npm install --silent --no-save --prefix .venv gltf-validator@2.0.0-dev.3.10 ||
        echo "the glTF validator could not be installed"
fi
"$python" scripts/crosscheck.py
"$python" -W ignore scripts/crosscheck_attributes.py
"$python" scripts/crosscheck_volumes.py
"$python" scripts/crosscheck_check.py
"$python" scripts/browser_test.py
"$python" scripts/crosscheck_libigl.py
