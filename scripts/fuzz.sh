#!/usr/bin/env bash
# Runs the fuzz targets on mutated seeds, with the stable toolchain: scripts/fuzz.sh [SECONDS] [SEED [TARGET...]].
# See docs/fuzzing.md.
set -euo pipefail
cd "$(dirname "$0")/.."

# With the Python module among the packages the library has the same features as for the wheel, so it is not built again.
cargo build --profile ci --package isomend --package isomend-python --package isomend-fuzz --bin isomend --bin mutate \
    --no-default-features --features isomend/default,isomend-fuzz/mutate
corpus=$(mktemp -d)
trap 'rm -rf "$corpus"' EXIT
python3 scripts/fuzz_seeds.py "$corpus" --isomend target/ci/isomend > /dev/null
target/ci/mutate --seconds "${1:-60}" --seed "${2:-1}" --corpus "$corpus" "${@:3}"
