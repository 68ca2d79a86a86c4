#!/usr/bin/env bash
# Builds and runs the benchmark of whole packings, and prints its table as Markdown:
# scripts/benchmark.sh [pattern ...] [--list] [--seeds n] [--max-seconds s] [--json file]; without a pattern, the quick cases.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
{
  cmake --preset release
  cmake --build --preset release --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" --target packing_benchmark
} >&2
build/bin/packing_benchmark "$@"
