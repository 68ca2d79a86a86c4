#!/usr/bin/env bash
# Fails unless CTest knows every test of a Catch2 executable: a bracket in a test's name makes CMake take the
# whole list for one test that runs nothing.
# Usage: check_discovery.sh EXECUTABLE BUILD_FOLDER
set -euo pipefail
in_executable=$("$1" --list-test-names-only | grep -c . || true)
in_ctest=$(ctest --test-dir "$2" -N -L '^unit$' | sed -n 's/^Total Tests: //p')
echo "tests in the executable: $in_executable, known to CTest: $in_ctest"
[[ $in_executable -gt 0 && $in_executable -eq $in_ctest ]]
