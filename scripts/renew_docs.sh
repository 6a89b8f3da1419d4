#!/usr/bin/env bash
# Renews all tables and pictures of the README and of docs: scripts/renew_docs.sh DIR
#
# DIR gets a Python environment with the packages that the scripts list in their first lines, and the reports, plots and fields of
# the experiments. It takes one to two hours on two cores; the machine must be idle, since many figures are times. The comparison with
# CGAL needs its headers (Debian: libcgal-dev libeigen3-dev), shapes with edges need the libraries of gmsh (libglu1-mesa libxcursor1
# libxft2 libxinerama1), the pictures of reports and of the page need Chromium, and the site rustup and npm.
set -euo pipefail
folder=${1:?usage: scripts/renew_docs.sh DIR}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
cd "$(dirname "$0")/.."

scripts=(accuracy real_meshes compare_libigl shapes_with_edges bench_peers scaling edges_picture readme_picture report_picture
    restoration_pictures generated_picture view_picture wasm_test)
python=$folder/venv/bin/python
[ -x "$python" ] || python3 -m venv "$folder/venv"
needed() {
    python3 - "$@" << 'EOF'
import re, sys, tomllib
needed = set()
for name in sys.argv[1:]:
    head = re.search(r"^# /// script\n(.*?)^# ///$", open(f"scripts/{name}.py").read(), re.M | re.S)
    needed.update(tomllib.loads(re.sub("^# ?", "", head[1], flags=re.M))["dependencies"])
print("\n".join(sorted(needed)))
EOF
}
needed "${scripts[@]}" > "$folder/requirements.txt"
"$python" -m pip install --quiet --disable-pip-version-check -r "$folder/requirements.txt"

cargo build --release
scripts/study.sh "$folder"
for name in accuracy real_meshes compare_libigl shapes_with_edges bench_peers scaling; do
    "$python" "scripts/$name.py" --docs
done
"$python" scripts/edges_picture.py
if [ -f "${DINOSAUR:-}" ]; then
    "$python" scripts/readme_picture.py "$DINOSAUR"
else
    echo "data/mended.png stays: DINOSAUR names no scan (see scripts/readme_picture.py)" >&2
fi
"$python" scripts/report_picture.py
"$python" scripts/restoration_pictures.py
"$python" scripts/generated_picture.py
"$python" scripts/view_picture.py
scripts/wasm.sh "$folder/wasm"
"$python" scripts/wasm_test.py "$folder/wasm/site" --picture data/browser.png
if [ -f "${WHEEL:-}" ]; then
    "$python" scripts/blender_picture.py --wheel "$WHEEL"
else
    echo "data/blender.png stays: WHEEL names no wheel of isomend" >&2
fi
