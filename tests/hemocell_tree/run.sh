#!/usr/bin/env bash
# Places packMesh as tools/packMesh in a stand-in of HemoCell's tree, builds it in both ways HemoCell's tools are built, and
# runs the programs from where HemoCell's users call them. All objects but one are borrowed from the build that runs the tests;
# PACKMESH_COMPILE_ALL=1 borrows none.
#   run.sh <cmake> <source tree of packMesh> <build tree of packMesh> <scratch folder>
set -euo pipefail
cmake=$1 source=$2 built=$3 scratch=$4
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
cp -r "$here/stand_in" "$scratch/hemocell"
tree=$scratch/hemocell
mkdir "$tree/tools/packMesh"
for part in CMakeLists.txt packMesh hemocell_adapter python config packaging README.md CHANGELOG.md CITATION.cff LICENSE docs examples scripts; do ln -s "$source/$part" "$tree/tools/packMesh/$part"; done

# The compiler may be fast here, the programs need not.
options=(-DCMAKE_CXX_FLAGS_RELEASE=-O1 -G "Unix Makefiles")
command -v ccache > /dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}

# As one of HemoCell's subdirectories.
for _ in first again; do "$cmake" -S "$tree" -B "$tree/build" "${options[@]}"; done
if [[ ${PACKMESH_COMPILE_ALL:-0} != 1 ]]; then
  sleep 1  # later than the Makefiles, on any file system
  (cd "$built" && find packMesh/CMakeFiles hemocell_adapter/CMakeFiles -name '*.o') |
    grep -v '/version\.cpp\.o$' | while IFS= read -r object; do
      mkdir -p "$(dirname "$tree/build/tools/packMesh/$object")"
      cp "$built/$object" "$tree/build/tools/packMesh/$object"
    done
fi
"$cmake" --build "$tree/build" --parallel "$jobs" --target hemocell packMesh_executable | tee "$scratch/build.log"
grep -q 'Building CXX object tools/packMesh/.*/version\.cpp\.o' "$scratch/build.log"
test ! -e "$tree/build/tests" || { echo "packMesh's tests became HemoCell's"; exit 1; }
if grep -l -e '-march=native' "$tree"/build/tools/packMesh/*/CMakeFiles/*/flags.make; then
  echo "HemoCell's -march=native reached packMesh"
  exit 1
fi
for program in packMesh/bin/packMesh packMesh/bin/packCells packCells/packCells; do
  "$tree/tools/$program" --version
done
mkdir "$scratch/packcells"
# Under its old name it counts as packCells does: round(0.3 * 30^3 / 97) = 84 cells.
cd "$scratch/packcells" && "$tree/tools/packCells/packCells" 30 30 30 --hematocrit 0.3 > /dev/null
test "$(head -n 1 RBC.pos)" = 84

# By itself in its folder (mkdir build; cd build; cmake ..), and beside HemoCell's own packCells, which stays.
rm "$tree/tools/packCells/packCells"
echo "HemoCell's own" > "$tree/tools/packCells/packCells"
mkdir "$tree/tools/packMesh/build"
cd "$tree/tools/packMesh/build"
"$cmake" .. "${options[@]}" -DBUILD_TESTING=OFF > configure.log
grep -qF "packCells is HemoCell's own and stays" configure.log
grep -qx "HemoCell's own" "$tree/tools/packCells/packCells"
grep -qF "$tree/tools/packMesh/bin/packMesh" -r CMakeFiles hemocell_adapter/CMakeFiles/packMesh_executable.dir/build.make
