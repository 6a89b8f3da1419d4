#!/usr/bin/env bash
# Tests the program for Windows under wine: scripts/wine_test.sh EXE PROGRAM
#
# It writes the files of scripts/hashes.py with the bytes of PROGRAM, the program of this system, and serves its page to requests with the
# secret only. It needs wine (Debian: apt install wine64; without it nothing is tested), curl, and a Python with the package ziglang,
# whose path is PYTHON.
set -euo pipefail
cd "$(dirname "$0")/.."
exe=$(realpath "${1:?usage: scripts/wine_test.sh EXE PROGRAM}")
program=${2:?usage: scripts/wine_test.sh EXE PROGRAM}
# Debian keeps wine64 out of PATH.
PATH=$PATH:/usr/lib/wine
wine=$(command -v wine || command -v wine64) || {
    echo "not tested: wine is not installed"
    exit 0
}
server=$(command -v wineserver || command -v wineserver64)
clean=$(mktemp -d)
export WINEPREFIX=$clean/wine WINEDEBUG=-all
trap '"$server" -k || true; rm -rf "$clean"' EXIT
cp "$exe" "$clean/isomend.exe"
"$wine" "$clean/isomend.exe" --version > /dev/null 2>&1 || {
    # Wine 8 lacks the library from which Rust takes random numbers: put a library with only this function beside the program.
    cat > "$clean/random.c" << 'C'
#include <stddef.h>
__declspec(dllimport) unsigned char __stdcall SystemFunction036(void *, unsigned long);
__declspec(dllexport) int __stdcall ProcessPrng(unsigned char *data, size_t length) {
    return SystemFunction036(data, (unsigned long)length);
}
C
    "${PYTHON:-python3}" -m ziglang cc -target x86_64-windows-gnu -shared -O1 "$clean/random.c" -o "$clean/bcryptprimitives.dll" -ladvapi32
}
"$wine" "$clean/isomend.exe" --version
# The page must answer requests with the secret, and refuse others.
timeout 120 "$wine" "$clean/isomend.exe" view data/sphere.ply --no-browser > "$clean/view" 2>&1 &
for _ in $(seq 50); do grep -q http "$clean/view" 2> /dev/null && break; sleep 1; done
address=$(grep -o 'http://[^[:space:]]*' "$clean/view" | head -n 1)
curl --silent --fail --location --cookie-jar "$clean/cookies" "$address" | grep -q '<title>isomend view'
[ "$(curl --silent --output /dev/null --write-out '%{http_code}' "${address%/*/}/")" = 403 ]
echo "the page is served"
python3 scripts/hashes.py --isomend "$program" --out "$clean/here.json" > /dev/null
python3 scripts/hashes.py --isomend "$clean/isomend.exe" --runner "$wine" --against "$clean/here.json"
