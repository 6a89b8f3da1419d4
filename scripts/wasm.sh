#!/usr/bin/env bash
# Builds the program as WebAssembly, into DIR: scripts/wasm.sh DIR [PROFILE]
#
#   npm/    the npm package: the module, its functions in JavaScript, types
#   site/   the page of `isomend view` as a static site that needs no server program: put it on any web server
#
# It needs Rust with rustup, Node.js 20 or newer and npm. The profile is `wasm` by default; with `ci` the module is built faster, and is
# larger. `node wasm/tests/run.mjs DIR/npm PROGRAM` tests the package against the program of this system, and scripts/wasm_test.py the site.
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:?usage: scripts/wasm.sh DIR [PROFILE]}
profile=${2:-wasm}
mkdir -p "$out"
out=$(cd "$out" && pwd)
target=wasm32-wasip1

rustup target add $target
cargo build --quiet --locked --profile "$profile" --target $target --package isomend-wasm
module=${CARGO_TARGET_DIR:-target}/$target/$profile/isomend_wasm.wasm

# The functions of WASI in JavaScript, with files in memory.
tools=${CARGO_TARGET_DIR:-target}/$target/tools
mkdir -p "$tools"
npm install --silent --no-save --prefix "$tools" @bjorn3/browser_wasi_shim@0.4.2
shim=$(cd "$tools/node_modules/@bjorn3/browser_wasi_shim" && pwd)

rm -rf "$out/npm" "$out/site"
mkdir -p "$out/npm/wasi" "$out/site/wasi"
cp "$module" "$out/npm/isomend.wasm"
cp "$shim"/dist/*.js "$shim"/LICENSE-* "$out/npm/wasi/"
cp wasm/npm/* LICENSE-* "$out/npm/"
cp wasm/site/* data/scan.ply LICENSE-* "$out/site/"
cp "$out/npm/isomend.wasm" "$out/npm/program.js" "$out/site/"
cp "$out"/npm/wasi/* "$out/site/wasi/"
node wasm/assets.mjs "$out/site"
printf '%s: %d bytes, %d with gzip\n' "$out/npm/isomend.wasm" "$(wc -c < "$out/npm/isomend.wasm")" "$(gzip -9 -c "$out/npm/isomend.wasm" | wc -c)"
