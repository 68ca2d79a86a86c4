#!/usr/bin/env bash
# Sets up, builds and runs tests.
#   scripts/test.sh [preset] [CMake options]        the core: every concept, in minutes
#   scripts/test.sh full [preset] [CMake options]   all tests: with browsers, other programs, other processors, long cases
#   scripts/test.sh rest [preset] [CMake options]   those of `full` that are not in the core
#   scripts/test.sh clang-mpich                     builds the programs with clang and MPICH, and compares their bytes with those of the preset
#                                                   release, which must be built
#   scripts/test.sh clang-mpich compile             only compiles a part of it without optimisation, in a minute or two
#   scripts/test.sh all                             hours: full with the presets release, dev and asan, those of threads with tsan, clang-mpich,
#                                                   the jobs of examples/cluster by Slurm itself, then 300 random problems
# Preset and options are those of scripts/build.sh. The last line is the summary of the tests.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [[ ${1:-} == all ]]; then
  shift
  export PACKMESH_ALL_CASES=1
  for preset in release dev asan tsan; do scripts/test.sh full "$preset" "$@"; done
  scripts/test.sh clang-mpich
  scripts/setup.sh --slurm
  tests/cluster/check_slurm.sh build/bin build/slurm build-clang-mpich/bin
  exec scripts/soak.py --no-corpus --count 300
fi
if [[ ${1:-} == clang-mpich ]]; then
  [[ ${2:-} == compile ]] && tests=--without-tests
  scripts/setup.sh ${tests:-}
  scripts/setup.sh --clang-mpich
  jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
  if [[ ${2:-} == compile ]]; then
    # Vector types, MPI and HDF5 are where compilers and libraries differ.
    cmake --preset clang-mpich -B build-clang-compile -DCMAKE_BUILD_TYPE=Debug -DBUILD_TESTING=OFF -DPACKMESH_UNITY=ON
    mapfile -t objects < <(ninja -C build-clang-compile -t targets all |
      sed -nE 's/^((packMesh|hemocell_adapter)\/CMakeFiles\/[a-zA-Z0-9_]+\.dir\/(Unity\/unity_.*_(mesh|parallel|io|packing|certificate|base|output)_.*|.*_kernel\.cpp)\.o):.*/\1/p')
    [[ ${#objects[@]} -ge 30 ]] || { echo "(packMesh) (Error) only ${#objects[@]} objects to compile"; exit 1; }
    exec ninja -C build-clang-compile -j "$jobs" "${objects[@]}"
  fi
  scripts/build.sh clang-mpich
  ctest --test-dir build-clang-mpich -R '^mpi\.' --output-on-failure
  exec tests/compilers/smoke.sh build-clang-mpich mpiexec.mpich build build-clang-mpich/smoke
fi
setup=() which=(-L core)
case ${1:-} in
  full) setup=(--full) which=() && shift ;;
  rest) setup=(--full) which=(-LE core) && shift ;;
esac
preset=release
[[ $# -gt 0 && $1 != -* ]] && preset=$1
scripts/setup.sh "${setup[@]}"
scripts/build.sh "$@" -DBUILD_TESTING=ON  # an example may have been built without

# Containers run tests as root, where mpirun refuses to start without these.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
log=$(mktemp)
trap 'rm -f "$log"' EXIT
status=0
# One more than there are cores, as some tests wait for ranks to end.
ctest --preset "$preset" "${which[@]}" --parallel "$((${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)} + 1))" | tee "$log" || status=$?
grep -E '^[0-9]+% tests passed' "$log" || echo "(packMesh) (Error) The tests did not run to completion."
exit "$status"
