#!/usr/bin/env bash
# Runs all tests with address and undefined-behaviour sanitizers, and lists the lines that no test runs:
#   scripts/coverage.sh      writes build-asan/coverage.txt; takes one to two hours. Needs gcovr.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v gcovr > /dev/null || { echo "(packMesh) (Error) gcovr is not installed" >&2; exit 1; }
status=0
scripts/test.sh asan -DCMAKE_CXX_FLAGS=--coverage || status=$?
gcovr --root . --filter packMesh/ --filter hemocell_adapter/ --sort-uncovered --print-summary \
  --output build-asan/coverage.txt build-asan
exit "$status"
