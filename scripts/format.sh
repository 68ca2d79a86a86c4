#!/usr/bin/env bash
# Formats the sources with clang-format: scripts/format.sh [--check]; --check only lists what would change.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v clang-format > /dev/null || { echo "(packMesh) (Error) clang-format is not installed" >&2; exit 1; }
mapfile -t sources < <(git ls-files '*.h' '*.cpp')
if [[ ${1:-} == --check ]]; then
  clang-format --dry-run --Werror "${sources[@]}"
else
  clang-format -i "${sources[@]}"
fi
