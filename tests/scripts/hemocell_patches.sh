#!/usr/bin/env bash
# The series of patches for HemoCell applies to a tree with the lines that it changes, and a tree without one of them is refused.
#   hemocell_patches.sh <source tree> <scratch folder>
set -euo pipefail
source=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch/hemocell"
cd "$scratch/hemocell"
export GIT_CONFIG_GLOBAL=/dev/null GIT_AUTHOR_NAME=Test GIT_AUTHOR_EMAIL=test@invalid GIT_COMMITTER_NAME=Test GIT_COMMITTER_EMAIL=test@invalid
mkdir -p examples/pipeflow doc/user_guide
printf 'project(hemocell)\n# Include CMake functions, mostly related to linking\nadd_subdirectory(examples)\n' > CMakeLists.txt
printf 'add_subdirectory("pipeflow")\n' > examples/CMakeLists.txt
# shellcheck disable=SC2016
printf 'target_link_libraries(${EXEC_NAME} ${PROJECT_NAME})\n' > examples/pipeflow/CMakeLists.txt
printf '#include <hemocell.h>\n    hemocell.loadParticles();\n    hemocell.loadCheckPoint();\n' > examples/pipeflow/pipeflow.cpp
printf '<hemocell>\n\n</hemocell>\n' > examples/pipeflow/config.xml
printf '1\n0 0 0 0 0 0\n' > examples/pipeflow/RBC.pos
printf '   QuickStart\n   Case\n' > doc/user_guide/index.rst
printf 'The resulting ``*.pos`` files can be copied to the case where you want to use\nthem.\n' > doc/user_guide/QuickStart.rst
printf 'HemoCell Changelog\n\n2.6 (July 15 2022)\n----\n' > CHANGELOG.md
git init --quiet
git add --all
git commit --quiet --message "A tree with what the patches change"
git clone --quiet . ../applied

make_patches() { "$source/scripts/packaging/hemocell/make_patches.py" "$scratch/hemocell" "$1"; }
make_patches "$scratch/patches"
test -z "$(git status --porcelain)"  # the clone is not changed
grep -q '^Subject: \[PATCH 0/4\]' ../patches/cover-letter.txt
cd ../applied
git am --quiet ../patches/*.patch 2> /dev/null
test "$(git log --oneline | wc -l)" -eq 5
grep -q 'packmesh::loadParticles(hemocell);' examples/pipeflow_packed/pipeflow_packed.cpp
grep -q 'target_link_libraries(${EXEC_NAME} packMesh::hemocell)' examples/pipeflow_packed/CMakeLists.txt
grep -q '<hematocrit> 0.40 </hematocrit>' examples/pipeflow_packed/config.xml
test ! -e examples/pipeflow_packed/RBC.pos
# BUILD_PACKMESH builds the plug-in alone, before packMesh's own option would say otherwise.
grep -A2 '^if(BUILD_PACKMESH)' CMakeLists.txt | tr '\n' ' ' | grep -q 'set(PACKMESH_PLUGIN_ONLY ON CACHE .* add_subdirectory(tools/packMesh)'
git diff --quiet HEAD~4 -- examples/pipeflow
cmp "$source/packMesh/packing/pack.cpp" tools/packMesh/packMesh/packing/pack.cpp
test -x tools/packMesh/scripts/build.sh

# Its version of a file may have another text: then nothing is made.
cd ../hemocell
sed -i 's/loadCheckPoint/loadCheckpoint/' examples/pipeflow/pipeflow.cpp
git commit --quiet --all --message "Renamed"
if make_patches "$scratch/none" > none.log 2>&1; then echo "a tree without a line to change passes"; exit 1; fi
grep -q 'pipeflow_packed.cpp of HemoCell has 0 times' none.log
