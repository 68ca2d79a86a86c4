#!/usr/bin/env bash
# All tests with address and undefined-behaviour sanitizers, and which lines of the programs they never ran:
#   scripts/coverage.sh      writes build-asan/coverage.txt; takes an hour or two. Needs gcovr.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v gcovr > /dev/null || { echo "(packMesh) (Error) gcovr is not installed" >&2; exit 1; }
status=0
scripts/test.sh asan -DCMAKE_CXX_FLAGS=--coverage || status=$?
gcovr --root . --filter packMesh/ --filter hemocell_adapter/ --sort-uncovered --print-summary \
  --output build-asan/coverage.txt build-asan
exit "$status"
