#!/usr/bin/env bash
# The corpus and its mutations once more, by programs built with address and undefined-behaviour sanitizers.
#   sanitized.sh <cmake> <source tree> <scratch folder>
set -euo pipefail
cmake=$1 source=$2 scratch=$3
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
options=()
command -v ccache > /dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
cd "$source"  # presets are found from here
"$cmake" --preset asan -B "$scratch" -DPACKMESH_WARNINGS_AS_ERRORS=OFF "${options[@]}"
"$cmake" --build "$scratch" --parallel "$jobs" --target fuzz_replay
cd "$scratch"
for entry in "$source"/tests/corpus/*/; do
  entry=$(basename "$entry")
  [[ $entry == soak ]] && continue  # problems for scripts/soak.py
  LSAN_OPTIONS="suppressions=$source/tests/lsan_suppressions.txt:print_suppressions=0" \
    bin/fuzz_replay "$entry" "$source/tests/corpus/$entry" 500
done
