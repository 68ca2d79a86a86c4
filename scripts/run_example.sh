#!/usr/bin/env bash
# Sets up, builds and packs the pipe example. The result is in build/examples/pipe.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/setup.sh --without-tests
cmake --preset release -DBUILD_TESTING=OFF
cmake --build --preset release --parallel "${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}" --target packMesh_executable

case_folder=build/examples/pipe
mkdir -p "$case_folder"
cp examples/pipe/*.xml examples/pipe/*.stl "$case_folder/"
cd "$case_folder"
../../bin/packMesh config.xml --vtp
PYTHONPATH=../../../python python3 -m packmesh render
cat << MESSAGE

The packed case is in $PWD
  RBC.pos, PLT.pos   the cells, ready for HemoCell
  cells.png          a picture of them
MESSAGE
