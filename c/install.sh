#!/usr/bin/env bash
# Copies the header, the libraries and the files for pkg-config and CMake to a folder: c/install.sh PREFIX [BUILD]
#
# BUILD is the folder with the libraries, target/release unless given: cargo build --release --package isomend-c
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
prefix=${1:?usage: c/install.sh PREFIX [BUILD]}
build=${2:-$here/../target/release}
mkdir -p "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/isomend"
prefix=$(cd "$prefix" && pwd)
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' "$here/../Cargo.toml")

copied=
for file in libisomend.a libisomend.so libisomend.dylib isomend.lib isomend.dll.lib; do
    [ ! -e "$build/$file" ] || { cp "$build/$file" "$prefix/lib/" && copied+=" $file"; }
done
if [ -e "$build/isomend.dll" ]; then
    mkdir -p "$prefix/bin"
    cp "$build/isomend.dll" "$prefix/bin/"
    copied+=" isomend.dll"
fi
[ -n "$copied" ] || { echo "there are no libraries in $build: cargo build --release --package isomend-c" >&2; exit 1; }
cp "$here/include/isomend.h" "$prefix/include/"
cp "$here/cmake/isomendConfig.cmake" "$prefix/lib/cmake/isomend/"
# No file names the prefix, so that the folder may be moved after a staged installation.
sed "s|@version@|$version|" "$here/isomend.pc.in" > "$prefix/lib/pkgconfig/isomend.pc"
sed "s|@version@|$version|" "$here/cmake/isomendConfigVersion.cmake.in" > "$prefix/lib/cmake/isomend/isomendConfigVersion.cmake"
echo "installed into $prefix:$copied"
