#!/usr/bin/env bash
# Sets up, builds and runs all tests: scripts/test.sh [preset] [CMake options], arguments as in scripts/build.sh.
# The last line is the summary of the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
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
grep -E '^[0-9]+% tests passed' "$log" || echo "(packMesh) (Error) The tests did not run to their end."
exit "$status"
