#!/usr/bin/env bash
# Runs all experiments of the paper, writes tables, reports, plots and fields to a folder, and renews the tables in docs/experiments.md.
# It takes about half an hour on two cores.
set -euo pipefail
folder=${1:?usage: scripts/study.sh DIR [NAME...]}
shift
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
cd "$(dirname "$0")/.."

cargo build --release
[ $# -gt 0 ] || set -- cap table1 graph orthogonal merge surfaces patches patches-curvature-variation circle
for name in "$@"; do
    options=()
    case $name in
    patches) ;;
    patches-*) options=(--energy "${name#patches-}" --finest 64) ;;
    *) options=(--series "$folder/$name") ;;
    esac
    # Exit code 3: a claim was not confirmed; the report says which.
    target/release/isomend study "${name%%-*}" --csv "$folder/$name.csv" --json "$folder/$name.json" \
        --plot "$folder/$name.svg" "${options[@]}" | tee "$folder/$name.txt" || [ $? -eq 3 ]
done
python3 scripts/study_tables.py "$folder"
