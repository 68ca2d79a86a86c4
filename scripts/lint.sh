#!/usr/bin/env bash
# Static analysis: cppcheck, and with --tidy clang-tidy, which takes an hour.
# Needs cppcheck, and clang-tidy and a configured build; reviewed false positives are in .cppcheck-suppressions and .clang-tidy.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v cppcheck > /dev/null || { echo "(packMesh) (Error) cppcheck is not installed" >&2; exit 1; }
cppcheck --enable=warning,performance,portability --std=c++17 --inline-suppr --quiet --error-exitcode=1 -I . \
  --suppressions-list=.cppcheck-suppressions -j "$(nproc)" packMesh hemocell_adapter
[[ ${1:-} == --tidy ]] || exit 0
cmake --preset dev > /dev/null  # files compiled one by one
git ls-files 'packMesh/*.cpp' 'hemocell_adapter/*.cpp' | xargs -P "$(nproc)" -n 1 clang-tidy -p build-dev --quiet --warnings-as-errors='*'
