#!/usr/bin/env bash
# Tests the C interface with the libraries of a build: scripts/c_test.sh BUILD [cc]
#
# Installs them into a temporary folder, builds the example and the tests of c/ with the shared and with the static library, runs them, and
# runs the tests under valgrind. The C# example is run by .NET, or else by Mono. With CI=true a C compiler, pkg-config, CMake, valgrind
# and one of these must be there.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/c_test.sh BUILD [cc]}
cc=${2:-cc}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Whether a program is there; if not, the check is left out, or fails with CI=true.
has() {
    command -v "$1" > /dev/null && return
    (cd scripts && python3 -c 'import sys; from left_out import left_out; left_out(*sys.argv[1:])' "$2" "$1 is not installed") || exit 1
    return 1
}
has "$cc" 'tests of the C interface' || exit 0
has pkg-config 'tests of the C interface' || exit 0

# As a package is made: installed into another folder, whose name has characters that sed and the shell take for their own, and moved.
c/install.sh "$work/staged & a|b" "$build"
mv "$work/staged & a|b" "$work/prefix"
export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig LD_LIBRARY_PATH=$work/prefix/lib DYLD_LIBRARY_PATH=$work/prefix/lib
read -ra flags <<< "$(pkg-config --cflags isomend) -std=c11 -D_POSIX_C_SOURCE=200809L -Wall -Wextra -Wconversion -Werror -O1 -g"
read -ra shared <<< "$(pkg-config --libs isomend)"
read -ra system <<< "$(pkg-config --static --libs-only-l isomend | sed 's/-lisomend//')"
static=("$work/prefix/lib/libisomend.a" "${system[@]}")
for source in c/examples/fill.c c/tests/interface.c; do
    name=$(basename "$source" .c)
    "$cc" "${flags[@]}" "$source" "${shared[@]}" -lm -lpthread -o "$work/$name-shared"
    "$cc" "${flags[@]}" "$source" "${static[@]}" -lm -lpthread -o "$work/$name-static"
    for kind in shared static; do
        echo "-- $name, $kind"
        "$work/$name-$kind"
    done
done
# The header is C++ too.
if command -v c++ > /dev/null; then
    echo '#include "isomend.h"' | c++ $(pkg-config --cflags isomend) -x c++ -Wall -Wextra -Werror -fsyntax-only -
fi
if has valgrind 'the C interface under valgrind'; then
    valgrind --quiet --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite --show-leak-kinds=definite \
        "$work/interface-shared" unmeasured
    echo "-- nothing found by valgrind"
fi
if has cmake 'the C example by CMake'; then
    cmake -S c -B "$work/cmake" -DCMAKE_PREFIX_PATH="$work/prefix" > "$work/log" || { cat "$work/log"; exit 1; }
    cmake --build "$work/cmake" > "$work/log" || { cat "$work/log"; exit 1; }
    "$work/cmake/fill_isomend" > /dev/null 2>&1 && "$work/cmake/fill_static" > /dev/null 2>&1
    echo "-- built by CMake"
fi
# Mono has the compiler and the runtime in packages of Debian, .NET has not.
if command -v dotnet > /dev/null; then
    dotnet run --project c/examples/csharp
elif has mcs 'the C# example'; then
    mcs -warnaserror -out:"$work/fill.exe" c/examples/csharp/Program.cs
    mono "$work/fill.exe"
    echo "-- C# by Mono"
fi
