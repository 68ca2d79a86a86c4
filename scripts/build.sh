#!/usr/bin/env bash
# Configures and builds: scripts/build.sh [preset] [CMake options], preset release (default), dev or asan.
# CMAKE_BUILD_PARALLEL_LEVEL limits the parallel jobs.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=release
if [[ $# -gt 0 && $1 != -* ]]; then
  preset=$1
  shift
fi
cmake --preset "$preset" "$@"
cmake --build --preset "$preset" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}"
