#!/usr/bin/env bash
# Runs all experiments of the paper; tables, reports, plots and fields go to a folder.
set -euo pipefail
folder=${1:?usage: scripts/study.sh DIR}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
cd "$(dirname "$0")/.."

cargo build --release
for name in cap table1 graph orthogonal merge patches circle; do
    series=(--series "$folder/$name")
    [ "$name" = patches ] && series=()
    # Exit code 3: something that was stated was not met; the report says what.
    target/release/isomend study "$name" --csv "$folder/$name.csv" --json "$folder/$name.json" \
        --plot "$folder/$name.svg" "${series[@]}" | tee "$folder/$name.txt" || [ $? -eq 3 ]
done
