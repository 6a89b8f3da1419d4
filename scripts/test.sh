#!/usr/bin/env bash
# Runs all tests: of the library and the program, the commands in the documentation, the C interface, the Python package. It needs Rust
# and Python 3.11 or newer.
#
#   scripts/test.sh          the tests above; a quarter of an hour in a fresh clone
#   scripts/test.sh --all    also each feature of the library alone, the Python wheel with the packages that it supports, checks of written
#                            files by trimesh, MeshLab, libigl, VTK and the glTF validator, the pages in a headless Chromium, half a minute of
#                            fuzzing, and time and memory of fills against the last release, if there is one. A check that cannot run
#                            is left out, with a message; with CI=true this is a failure, except for the lints of the WebAssembly
#                            module: Rust's library for it cannot be fetched everywhere.
#   scripts/test.sh --apps   also tests with large downloads or builds: the Blender extension in Blender's Python module, the website by
#                            mdBook, the program as WebAssembly under Node.js and in Chromium
#
# Each stage prints its seconds; a table of them is printed at the end.
set -euo pipefail
cd "$(dirname "$0")/.."

all= apps=
case "${1:-}" in
    '') ;;
    --all) all=yes ;;
    --apps) all=yes apps=yes ;;
    *) echo "usage: scripts/test.sh [--all|--apps]" >&2; exit 2 ;;
esac

table=() failed=0 failures=$(mktemp)
# A stage that fails does not keep the later ones from running, but for the build.
stage() {
    local begin=$SECONDS code word=
    printf '\n== %s\n' "$1"
    set +e
    (set -e; "${@:2}")
    code=$?
    set -e
    [ "$code" = 0 ] || { failed=$((failed + 1)) word=', failed'; }
    table+=("$(printf '%6d s  %s' $((SECONDS - begin)) "$1$word")")
    echo "== $1: $((SECONDS - begin)) s$word"
}
# Runs stages, by a command, beside the following ones, until `join`, which shows their output.
beside() {
    logs=$(mktemp -d)
    (
        table=() failed=0
        "$@"
        printf '%s\n' "${table[@]}" > "$logs/table"
        echo "$failed" > "$logs/failed"
    ) > "$logs/output" 2>&1 &
    running=$!
}
join() {
    local line
    wait "$running" || true
    cat "$logs/output"
    while IFS= read -r line; do table+=("$line"); done < "$logs/table"
    failed=$((failed + $(cat "$logs/failed")))
    grep '^FAILED ' "$logs/output" >> "$failures" || true
    rm -r "$logs"
}
# The table of the stages and, since long logs are cut, the failed checks of stages that run beside others.
finish() {
    printf '\n'
    cat "$failures"
    rm "$failures"
    [ ${#table[@]} = 0 ] || printf '%s\n' "${table[@]}"
    printf '%6d s  in all\n' "$SECONDS"
    [ "$failed" = 0 ] || { echo "stages that failed: $failed"; exit 1; }
}
trap finish EXIT

# The Python module is not linked with Python: it finds Python's functions in the process that loads it.
export PYO3_BUILD_EXTENSION_MODULE=1
# The same packages and targets for building and testing; with others, the packages would be built again with other features of their
# dependencies.
selection=(--profile ci --workspace --exclude isomend-fuzz --exclude isomend-wasm)
targets=(--lib --bin isomend --tests)
export ISOMEND=$PWD/target/ci/isomend
python=.venv/bin/python

# The libraries, and all tests at once: while one package waits for another, the tests of a third are compiled.
build() {
    cargo build "${selection[@]}" "${targets[@]}"
}

rust_tests() {
    cargo test --quiet --no-fail-fast "${selection[@]}" "${targets[@]}"
}

documented_examples() {
    cargo test --quiet "${selection[@]}" --doc
}

# Makes a virtual environment with the packages of some lists, and installs them again if a list has changed.
environment() {
    local wanted
    wanted=$(cat "$@")
    if [ -x "$python" ] && [[ "$(cat .venv/installed 2> /dev/null)" == "$wanted"* ]]; then
        return
    fi
    [ -x "$python" ] || python3 -m venv .venv
    local list lists=()
    for list in "$@"; do lists+=(-r "$list"); done
    "$python" -m pip install --quiet --disable-pip-version-check --no-compile "${lists[@]}"
    echo "$wanted" > .venv/installed
}

# Tests the Python package with the module that was built above, without a wheel.
python_tests() {
    local site=target/ci/site library=target/ci/lib_isomend.so
    [ -e "$library" ] || library=target/ci/lib_isomend.dylib
    rm -rf "$site"
    mkdir -p "$site"
    cp -r python/isomend "$site/isomend"
    cp "$library" "$site/isomend/_isomend.abi3.so"
    # Modules that need packages that are not installed, such as pyvista, cannot be imported.
    PYTHONPATH=$PWD/$site "$python" -m pytest -q --doctest-modules --doctest-ignore-import-errors --pyargs isomend
    PYTHONPATH=$PWD/$site "$python" -m pytest -q python/tests
}

# Whether each compiles without warnings; clippy has seen the same code with all features.
parts_of_the_library() {
    local features said
    for features in '' io study view; do
        said=$(cargo check --quiet --color never --profile ci --lib --no-default-features --features "$features" 2>&1) || said+=$'\nit does not compile'
        [ -z "$said" ] || { printf "with the features '%s':\n%s\n" "$features" "$said"; return 1; }
    done
    # The part that is compiled for WebAssembly alone.
    if command -v rustup > /dev/null && rustup target add wasm32-wasip1 > /dev/null 2>&1; then
        cargo clippy --quiet --profile ci --package isomend-wasm --target wasm32-wasip1 -- -D warnings
    else
        echo "left out: the WebAssembly module, since Rust's library for it cannot be installed"
    fi
}

peers() {
    environment scripts/requirements.txt scripts/requirements-all.txt
    if ! "$python" -c 'import open3d' 2> /dev/null; then
        "$python" -m pip install --quiet --disable-pip-version-check --no-compile open3d==0.20.0 || echo "Open3D could not be installed"
    fi
    if command -v npm > /dev/null && [ ! -d .venv/node_modules/gltf-validator ]; then
        npm install --silent --no-save --prefix .venv gltf-validator@2.0.0-dev.3.10 ||
            echo "the glTF validator could not be installed"
    fi
}

wheel() {
    rm -rf .venv/wheels
    "$python" -m maturin build --quiet --profile ci --manifest-path python/Cargo.toml --out .venv/wheels
    "$python" -m pip install --quiet --disable-pip-version-check --force-reinstall --no-deps .venv/wheels/*.whl
    (cd python && ../"$python" -m mypy)
    "$python" -m pytest -q --doctest-modules --pyargs isomend
    "$python" -m pytest -q python/tests
}

written_files() {
    "$python" scripts/crosscheck.py --isomend "$ISOMEND"
    "$python" -W ignore scripts/crosscheck_attributes.py --isomend "$ISOMEND"
    "$python" -W ignore scripts/crosscheck_readers.py --isomend "$ISOMEND"
    "$python" scripts/crosscheck_volumes.py --isomend "$ISOMEND"
    "$python" scripts/crosscheck_check.py --isomend "$ISOMEND"
    "$python" scripts/crosscheck_libigl.py --isomend "$ISOMEND"
}

browser() {
    "$python" scripts/browser_test.py --isomend "$ISOMEND"
    "$python" scripts/view_test.py --isomend "$ISOMEND"
}

lane_of_browser() {
    stage 'written files, by other programs' written_files
    stage 'parts of the library by themselves' parts_of_the_library
    stage 'pages in a browser' browser
}

# CPU time and memory of fills against the last release.
speed() {
    local last
    last=$(git describe --tags --abbrev=0 --match 'v*' 2> /dev/null) || { echo "left out: there is no release to compare with"; return; }
    "$python" scripts/bench_guard.py "$last" --program "$ISOMEND" --rounds 3
}

blender() {
    "$python" scripts/blender_test.py --isomend "$ISOMEND" --wheel .venv/wheels/*.whl
    "$python" -W ignore scripts/crosscheck_readers.py --isomend "$ISOMEND" --blender
}

webassembly() {
    scripts/wasm.sh target/wasm ci
    node wasm/tests/run.mjs target/wasm/npm "$ISOMEND"
    "$python" scripts/wasm_test.py target/wasm/site --isomend "$ISOMEND"
}

site() {
    local program
    program=$(command -v mdbook || echo "$PWD/.venv/mdbook/bin/mdbook")
    [ -x "$program" ] || cargo install --quiet --locked --debug --no-default-features --features search --root .venv/mdbook \
        --version 0.5.4 mdbook || echo "mdbook could not be installed"
    "$python" scripts/site.py target/ci/book --mdbook "$program"
}

# Packages are fetched while the compiler works.
if [ -n "$all" ]; then
    beside stage 'environment of other programs' peers
else
    beside stage 'Python environment' environment scripts/requirements.txt
fi
stage 'build' build
not_built=$failed
join
[ "$not_built" = 0 ] || exit 1
stage 'tests of the library and the program' rust_tests
stage 'examples in the documentation' documented_examples
# The tests of the C interface and of the Python package work on one core for most of their time.
beside stage 'C interface' scripts/c_test.sh target/ci
stage 'commands of the pages' python3 scripts/check_docs.py --isomend "$ISOMEND"
[ -n "$all" ] || stage 'tests of the Python package' python_tests
join
if [ -n "$all" ]; then
    # Python's tests work on one core for most of their time. The browser keeps both busy, and its measurements of time come last, when the
    # others have ended.
    beside lane_of_browser
    stage 'Python wheel and its tests' wheel
    join
    beside stage 'instructions of fills, repairs and checks' "$python" scripts/instructions.py --isomend "$ISOMEND"
    stage 'fuzz targets on mutated seeds' scripts/fuzz.sh 30
    join
    stage 'speed against the last release' speed
fi
if [ -n "$apps" ]; then
    stage 'Blender extension' blender
    stage 'site of the pages' site
    stage 'WebAssembly' webassembly
fi
