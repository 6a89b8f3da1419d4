#!/usr/bin/env bash
# All tests: those of cargo, the commands of the pages, then in a venv made here those of the Python package, the cross-check of
# written files by trimesh and MeshLab, and the report and the page of `isomend view` in a headless Chromium
# where there is one. With CI=true a check that cannot run is a failure; else it is left out, which is said.
# Needs Rust, a C compiler and Python 3.11 or newer.
set -euo pipefail
cd "$(dirname "$0")/.."

# The Python module finds Python's functions in the process that loads it.
export PYO3_BUILD_EXTENSION_MODULE=1
cargo test --release
# Together, so that the library is built once for both.
cargo build --release --package isomend --package isomend-python
python3 scripts/check_docs.py

python=.venv/bin/python
wanted=$(cat scripts/requirements.txt)
if [ ! -x "$python" ] || [ "$(cat .venv/installed 2>/dev/null)" != "$wanted" ]; then
    python3 -m venv --clear .venv
    "$python" -m pip install --quiet --disable-pip-version-check -r scripts/requirements.txt
    "$python" -m pip install --quiet --disable-pip-version-check open3d==0.20.0 || echo "Open3D could not be installed"
    echo "$wanted" > .venv/installed
fi
if command -v npm > /dev/null && [ ! -d .venv/node_modules/gltf-validator ]; then
    npm install --silent --no-save --prefix .venv gltf-validator@2.0.0-dev.3.10 ||
        echo "the glTF validator could not be installed"
fi

rm -rf .venv/wheels
"$python" -m maturin build --quiet --release --manifest-path python/Cargo.toml --out .venv/wheels
"$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps .venv/wheels/*.whl
(cd python && ../"$python" -m mypy)
"$python" -m pytest -q --doctest-modules --pyargs isomend
ISOMEND=$PWD/target/release/isomend "$python" -m pytest -q python/tests

"$python" scripts/crosscheck.py
"$python" -W ignore scripts/crosscheck_attributes.py
"$python" scripts/crosscheck_volumes.py
"$python" scripts/crosscheck_check.py
"$python" scripts/browser_test.py
"$python" scripts/view_test.py
"$python" scripts/crosscheck_libigl.py
