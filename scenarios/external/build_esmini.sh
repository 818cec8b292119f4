#!/bin/sh
# Builds esmini's library from a checkout, without what it downloads and draws, for `python3 -m falsify_av.bridges esmini library=…`:
#
#     git clone --depth 1 --recurse-submodules https://github.com/esmini/esmini
#     scenarios/external/build_esmini.sh esmini
#
# It needs CMake and a C++ compiler, and prints the path of the library.
set -eu
checkout=${1:?a checkout of esmini}
build=$checkout/build-falsify
cmake -S "$checkout" -B "$build" -DCMAKE_BUILD_TYPE=Release -DDOWNLOAD_EXTERNALS=OFF -DUSE_OSG=OFF -DUSE_OSI=OFF -DUSE_SUMO=OFF \
    -DUSE_GTEST=OFF -DUSE_IMPLOT=OFF -DBUILD_EXAMPLES=OFF -DBUILD_REPLAYER=OFF -DBUILD_ODRPLOT=OFF >&2
cmake --build "$build" --target esminiLib --parallel "$(nproc)" >&2
find "$(cd "$build" && pwd)" -name 'libesminiLib.*' -type f | head -n 1
