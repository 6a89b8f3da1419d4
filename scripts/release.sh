#!/usr/bin/env bash
# Builds all files of a release into DIR, and tests each in an empty environment: scripts/release.sh DIR
#
#   isomend                   the program, static and stripped
#   isomend-*.whl             the Python package for Linux (manylinux), for Python 3.10 and later
#   isomend-*.tar.gz          the source of the Python package
#   isomend-*.crate           the Rust package
#   isomend-blender-*.zip     the Blender extension for Linux, with the wheel inside
#   isomend.cdx.json, isomend-python.cdx.json    bills of materials (CycloneDX) of the program and of the wheel
#   SHA256SUMS                hashes of all of these
#
# The program is built twice, in two folders, and both builds must have the same bytes. scripts/release.sh DIR --once builds it only once.
#
# All files are built from the last commit, in a temporary folder. It needs Rust, a C compiler, Python 3.10 or newer and, for maturin and
# zig, the Python package index. Nothing is published.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?usage: scripts/release.sh DIR [--once]}
once=${2:-}
mkdir -p "$out"
out=$(cd "$out" && pwd)
clean=$(mktemp -d)
trap 'rm -rf "$clean"' EXIT
mkdir "$clean/source" "$clean/root"
git archive HEAD | tar -x -C "$clean/source"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
target=$(rustc -vV | sed -n 's/^host: //p')
say() { printf '\n== %s\n' "$*"; }

# Builds the program from a folder of sources into a folder of builds. The paths of these folders and of Cargo's folder are kept out of it.
program() {
    (cd "$1" && CARGO_TARGET_DIR=$2 RUSTFLAGS="-C target-feature=+crt-static --remap-path-prefix=$1=/isomend \
        --remap-path-prefix=$2=/target --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo" \
        cargo build --quiet --locked --profile dist --target "$target" --package isomend)
}

say "the program"
program "$clean/source" "$CARGO_TARGET_DIR"
cp "$CARGO_TARGET_DIR/$target/dist/isomend" "$out/"

if [ "$once" != --once ]; then
    say "the program once more, in other folders: the same bytes"
    mkdir "$clean/again"
    git archive HEAD | tar -x -C "$clean/again"
    program "$clean/again" "$clean/target-again"
    cmp "$out/isomend" "$clean/target-again/$target/dist/isomend"
    rm -rf "$clean/target-again"
fi

say "the Python package and its source"
python3 -m venv "$clean/tools"
"$clean/tools/bin/pip" install --quiet --disable-pip-version-check maturin==1.16.0 ziglang==0.17.1
PATH="$clean/tools/bin:$PATH"
rm -f "$out"/isomend-*.whl "$out"/isomend-*.tar.gz "$out"/isomend-*.crate "$out"/isomend-blender-*.zip
# zig links against an old C library, so that the wheel runs on systems with this or a later version.
(cd "$clean/source/python" &&
    maturin build --quiet --locked --profile dist --zig --compatibility manylinux2014 --target "$target" --out "$out" &&
    maturin sdist --out "$out")

say "the Blender extension"
(cd "$clean/source" && python3 scripts/blender_extension.py --out "$out" "$out"/isomend-*.whl)

say "the bills of materials"
(cd "$clean/source" &&
    python3 scripts/sbom.py --target "$target" "$out/isomend.cdx.json" &&
    python3 scripts/sbom.py --target "$target" --package isomend-python "$out/isomend-python.cdx.json")

say "the Rust packages"
# Each is built from what is packed, with the others as they are packed.
(cd "$clean/source" && cargo package --quiet --locked --package isomend --package isomend-core --package isomend-files \
    --package isomend-study --package isomend-view)
cp "$CARGO_TARGET_DIR"/package/isomend-*.crate "$out/"

# Runs the first command of the README with the given program; prints the hash of the result.
mends() {
    (cd "$clean/root" && rm -f mended.glb && "$@" fill scan.ply -o mended.glb -q && [ -s mended.glb ] && sha256sum < mended.glb)
}
cp data/scan.ply "$clean/root/"

say "the program, without libraries and without environment variables"
cp "$out/isomend" "$clean/root/"
mends env -i ./isomend > "$clean/program"
if unshare --user --map-root-user true 2> /dev/null; then
    mends unshare --user --map-root-user chroot "$clean/root" /isomend > "$clean/rooted"
    cmp "$clean/program" "$clean/rooted"
fi

for made in "$out"/isomend-*.whl "$out"/isomend-*.tar.gz; do
    say "$(basename "$made"), in a new environment"
    python3 -m venv --clear "$clean/venv"
    env -u CARGO_TARGET_DIR "$clean/venv/bin/pip" install --quiet --disable-pip-version-check "$made"
    mends "$clean/venv/bin/isomend" > "$clean/wheel"
    cmp "$clean/program" "$clean/wheel"
    (cd "$clean/root" && "$clean/venv/bin/python" -c \
        'import isomend; isomend.read("scan.ply").fill().write("mended.glb")' && sha256sum < mended.glb | cmp - "$clean/program")
done

say "the Rust package, installed"
cargo install --quiet --locked --path "$clean/source" --root "$clean/installed"
mends "$clean/installed/bin/isomend" | cmp - "$clean/program"

say "hashes"
(cd "$out" && rm -f SHA256SUMS && sha256sum -- * > "$clean/sums" && mv "$clean/sums" SHA256SUMS && sha256sum --check --quiet SHA256SUMS)

say "made, all with the same result"
ls -l "$out"
