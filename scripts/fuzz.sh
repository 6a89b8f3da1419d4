#!/usr/bin/env bash
# The functions of the fuzz targets on mutated seeds, with the stable toolchain: scripts/fuzz.sh [SECONDS] [SEED [TARGET...]].
# docs/fuzzing.md says more.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --release
cargo build --release -p isomend-fuzz --no-default-features --features mutate
corpus=$(mktemp -d)
trap 'rm -rf "$corpus"' EXIT
python3 scripts/fuzz_seeds.py "$corpus" > /dev/null
target/release/mutate --seconds "${1:-60}" --seed "${2:-1}" --corpus "$corpus" "${@:3}"
