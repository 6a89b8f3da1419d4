#!/usr/bin/env bash
# The functions of the fuzz targets on mutated seeds, with the stable toolchain: scripts/fuzz.sh [SECONDS] [SEED [TARGET...]].
# docs/fuzzing.md says more.
set -euo pipefail
cd "$(dirname "$0")/.."

# With the Python module among the packages the library is the one that its wheel is made of, and is not built again.
cargo build --profile ci --package isomend --package isomend-python --package isomend-fuzz --bin isomend --bin mutate \
    --no-default-features --features isomend/default,isomend-fuzz/mutate
corpus=$(mktemp -d)
trap 'rm -rf "$corpus"' EXIT
python3 scripts/fuzz_seeds.py "$corpus" --isomend target/ci/isomend > /dev/null
target/ci/mutate --seconds "${1:-60}" --seed "${2:-1}" --corpus "$corpus" "${@:3}"
