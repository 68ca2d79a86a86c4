#!/usr/bin/env bash
# Formats C++ with clang-format and Python with yapf: scripts/format.sh [--check] [c++|python]; --check only lists what would change.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
clang_options=(-i) yapf_options=(-i)
if [[ ${1:-} == --check ]]; then
  clang_options=(--dry-run --Werror) yapf_options=(--diff)
  shift
fi
need() { command -v "$1" > /dev/null || { echo "(packMesh) (Error) $1 is not installed" >&2; exit 1; }; }
if [[ ${1:-} != python ]]; then
  need clang-format
  git ls-files -z '*.h' '*.cpp' | xargs -0 clang-format "${clang_options[@]}"
fi
if [[ ${1:-} != c++ ]]; then
  yapf=$(command -v yapf3 || echo yapf)  # as Debian calls it
  need "$yapf"
  git ls-files -z '*.py' | xargs -0 "$yapf" --parallel "${yapf_options[@]}"
fi
