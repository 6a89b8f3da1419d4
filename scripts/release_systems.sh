#!/usr/bin/env bash
# Builds the program for Windows and macOS on Linux, with zig as the linker, into DIR: scripts/release_systems.sh DIR [PROFILE]
#
#   isomend-windows-x64.exe                           tested by scripts/wine_test.sh
#   isomend-macos-arm64, isomend-macos-x64            built, but not run: Linux cannot run them
#   isomend-*-win_amd64.whl, isomend-*-macosx_*.whl   the Python package; built, its contents are listed, not imported
#
# All is built from the last commit, by default with the profile dist. It needs Rust with rustup, Python and its package index; for the
# test also wine (Debian: apt install wine64) and the program of this system, at the path ISOMEND (target/release/isomend by default).
# .github/workflows/systems.yml builds wheels on these systems and tests them.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?usage: scripts/release_systems.sh DIR [PROFILE]}
profile=${2:-dist}
mkdir -p "$out"
out=$(cd "$out" && pwd)
program=${ISOMEND:-$PWD/target/release/isomend}
clean=$(mktemp -d)
trap 'rm -rf "$clean"' EXIT
mkdir "$clean/source"
git archive HEAD | tar -x -C "$clean/source"
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$PWD/target}
say() { printf '\n== %s\n' "$*"; }

python3 -m venv "$clean/tools"
"$clean/tools/bin/pip" install --quiet --disable-pip-version-check ziglang==0.17.0 cargo-zigbuild maturin==1.12.6
PATH="$clean/tools/bin:$PATH"

# Builds the program for a target triple.
build() {
    rustup target add "$1"
    (cd "$clean/source" && cargo zigbuild --quiet --locked --profile "$profile" --target "$1" --package isomend --bin isomend)
}

# Builds the wheel for a target triple, and checks that it holds the compiled module and the package. maturin 1.16 does not link modules
# inside packages for Windows with zig: it exports `PyInit_isomend._isomend`.
wheel() {
    (cd "$clean/source/python" && PYO3_BUILD_EXTENSION_MODULE=1 maturin build --quiet --locked --profile "$profile" --zig \
        --target "$1" --interpreter python3.11 --out "$clean/wheels")
    python3 - "$clean/wheels" <<'PYTHON'
import sys, zipfile
from pathlib import Path

[wheel] = Path(sys.argv[1]).glob("*.whl")
names = zipfile.ZipFile(wheel).namelist()
for wanted in ("isomend/__init__.py", "isomend/_isomend"):
    assert any(name.startswith(wanted) for name in names), f"{wheel.name} lacks {wanted}"
print(f"{wheel.name}: {len(names)} files, {wheel.stat().st_size / 1e6:.1f} MB")
PYTHON
    mv "$clean"/wheels/*.whl "$out"
}

say "Windows"
build x86_64-pc-windows-gnu
cp "$CARGO_TARGET_DIR/x86_64-pc-windows-gnu/$profile/isomend.exe" "$out/isomend-windows-x64.exe"

say "Windows' program under wine"
PYTHON=$clean/tools/bin/python scripts/wine_test.sh "$out/isomend-windows-x64.exe" "$program"

wheel x86_64-pc-windows-gnu

say "macOS"
for system in aarch64:arm64 x86_64:x64; do
    build "${system%:*}-apple-darwin"
    wheel "${system%:*}-apple-darwin"
    cp "$CARGO_TARGET_DIR/${system%:*}-apple-darwin/$profile/isomend" "$out/isomend-macos-${system#*:}"
done

say "made"
(cd "$out" && sha256sum isomend-windows-x64.exe isomend-macos-* isomend-*.whl | tee SHA256SUMS-systems)
