#!/usr/bin/env bash
# Sets up, builds and runs the tests: scripts/test.sh [preset] [CMake options], arguments as in scripts/build.sh.
# scripts/test.sh all takes hours: the tests with the presets release, dev and asan, those of threads with tsan, then 300
# random problems.
# The last line is the summary of the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [[ ${1:-} == all ]]; then
  shift
  for preset in release dev asan tsan; do scripts/test.sh "$preset" "$@"; done
  exec scripts/soak.py --no-corpus --count 300
fi
preset=release
[[ $# -gt 0 && $1 != -* ]] && preset=$1
scripts/setup.sh
scripts/build.sh "$@" -DBUILD_TESTING=ON  # an example may have been built without

# Containers run tests as root, where mpirun refuses to start without these.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
ctest --preset "$preset" --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" | tee "$log" || status=$?
grep -E '^[0-9]+% tests passed' "$log" || echo "(packMesh) (Error) The tests did not run to completion."
exit "$status"
