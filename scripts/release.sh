#!/usr/bin/env bash
# Builds what a release hands out, into DIR, and tries each where nothing else is: scripts/release.sh DIR
#
#   isomend                   the program, static and stripped
#   isomend-*.whl             the Python package for Linux (manylinux), for Python 3.10 and later
#   isomend-*.tar.gz          its source
#   isomend-*.crate           the Rust package
#
# All is built from what is committed, in a folder of its own. It needs Rust, a C compiler, Python 3.10 or newer and, for maturin and
# zig, the Python package index. Nothing is published.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?usage: scripts/release.sh DIR}
mkdir -p "$out"
out=$(cd "$out" && pwd)
clean=$(mktemp -d)
trap 'rm -rf "$clean"' EXIT
mkdir "$clean/source" "$clean/root"
git archive HEAD | tar -x -C "$clean/source"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
target=$(rustc -vV | sed -n 's/^host: //p')
say() { printf '\n== %s\n' "$*"; }

say "the program"
(cd "$clean/source" &&
    RUSTFLAGS="-C target-feature=+crt-static" cargo build --quiet --locked --profile dist --target "$target" --package isomend)
cp "$CARGO_TARGET_DIR/$target/dist/isomend" "$out/"

say "the Python package and its source"
python3 -m venv "$clean/tools"
"$clean/tools/bin/pip" install --quiet --disable-pip-version-check maturin==1.16.0 ziglang==0.17.1
PATH="$clean/tools/bin:$PATH"
rm -f "$out"/isomend-*
# zig links against an old C library, so that the wheel runs wherever that is or a later one.
(cd "$clean/source/python" &&
    maturin build --quiet --locked --profile dist --zig --compatibility manylinux2014 --target "$target" --out "$out" &&
    maturin sdist --out "$out")

say "the Rust package"
# It is built when it is installed below.
(cd "$clean/source" && cargo package --quiet --locked --no-verify --package isomend)
cp "$CARGO_TARGET_DIR"/package/isomend-*.crate "$out/"

# The first command of the README, by a program.
mends() {
    (cd "$clean/root" && rm -f mended.glb && "$@" fill scan.ply -o mended.glb -q && [ -s mended.glb ] && sha256sum < mended.glb)
}
cp data/scan.ply "$clean/root/"

say "the program, without a library beside it and without an environment"
cp "$out/isomend" "$clean/root/"
mends env -i ./isomend > "$clean/program"
if unshare --user --map-root-user true 2> /dev/null; then
    mends unshare --user --map-root-user chroot "$clean/root" /isomend > "$clean/rooted"
    cmp "$clean/program" "$clean/rooted"
fi

for made in "$out"/isomend-*.whl "$out"/isomend-*.tar.gz; do
    say "$(basename "$made"), in an environment of its own"
    python3 -m venv --clear "$clean/venv"
    env -u CARGO_TARGET_DIR "$clean/venv/bin/pip" install --quiet --disable-pip-version-check "$made"
    mends "$clean/venv/bin/isomend" > "$clean/wheel"
    cmp "$clean/program" "$clean/wheel"
    (cd "$clean/root" && "$clean/venv/bin/python" -c \
        'import isomend; isomend.read("scan.ply").fill().write("mended.glb")' && sha256sum < mended.glb | cmp - "$clean/program")
done

say "the Rust package, installed"
mkdir "$clean/crate"
tar -x -C "$clean/crate" --strip-components 1 -f "$(ls "$out"/isomend-*.crate)"
cargo install --quiet --locked --path "$clean/crate" --root "$clean/installed"
mends "$clean/installed/bin/isomend" | cmp - "$clean/program"

say "made, all with the same result"
ls -l "$out"
