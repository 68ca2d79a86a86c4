#!/usr/bin/env bash
# Places packMesh as tools/packMesh in a stand-in of HemoCell's tree, builds it in both ways HemoCell's tools are built, and the
# plug-in alone. All objects but one are borrowed from the build that runs the tests; PACKMESH_COMPILE_ALL=1 borrows none.
#   run.sh <cmake> <source tree of packMesh> <build tree of packMesh> <scratch folder>
set -euo pipefail
cmake=$1 source=$2 built=$3 scratch=$4
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
cp -r "$here/stand_in" "$scratch/hemocell"
tree=$scratch/hemocell
mkdir "$tree/tools/packMesh"
for part in CMakeLists.txt packMesh hemocell_adapter python config README.md CHANGELOG.md CITATION.cff LICENSE docs examples scripts; do ln -s "$source/$part" "$tree/tools/packMesh/$part"; done
fail() {
  echo "$*"
  exit 1
}
files() { (cd "$tree" && find . -path './build*' -prune -o -print | sort); }
files > "$scratch/before.txt"

# The compiler may be fast here, the programs need not.
options=(-DCMAKE_CXX_FLAGS_RELEASE=-O1 -G "Unix Makefiles")
command -v ccache > /dev/null && options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
jobs=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
borrow() { # build folder
  if [[ ${PACKMESH_COMPILE_ALL:-0} == 1 ]]; then return; fi
  sleep 1  # later than the Makefiles, on any file system
  (cd "$built" && find packMesh/CMakeFiles hemocell_adapter/CMakeFiles -name '*.o') |
    grep -v '/version\.cpp\.o$' | while IFS= read -r object; do
      mkdir -p "$(dirname "$1/tools/packMesh/$object")"
      cp "$built/$object" "$1/tools/packMesh/$object"
    done
}

# As one of HemoCell's subdirectories.
for _ in first again; do "$cmake" -S "$tree" -B "$tree/build" "${options[@]}"; done
borrow "$tree/build"
"$cmake" --build "$tree/build" --parallel "$jobs" --target hemocell packMesh_executable | tee "$scratch/build.log"
grep -q 'Building CXX object tools/packMesh/.*/version\.cpp\.o' "$scratch/build.log"
test ! -e "$tree/build/tests" || fail "packMesh's tests became HemoCell's"
if grep -l -e '-march=native' -e '-ggdb' -e ' -std=c++11' "$tree"/build/tools/packMesh/*/CMakeFiles/*/flags.make; then
  fail "HemoCell's flags reached packMesh"
fi
for program in packMesh packCells; do "$tree/build/tools/packMesh/bin/$program" --version; done
mkdir "$scratch/packcells"
# Under its old name it counts as packCells does: round(0.3 * 30^3 / 97) = 84 cells.
cd "$scratch/packcells" && "$tree/build/tools/packMesh/bin/packCells" 30 30 30 --hematocrit 0.3 > /dev/null
test "$(head -n 1 RBC.pos)" = 84
"$tree/build/tools/packMesh/bin/packMesh" 10 10 10 --rbc 2 --method cat --builder cat-faces > /dev/null

# Only the plug-in: nothing that it does not need is built or required.
"$cmake" -S "$tree" -B "$tree/build_plugin" "${options[@]}" -DPACKMESH_PLUGIN_ONLY=ON
if grep -E 'THREE_JS|pybind11|PACKMESH_PYTHON:' "$tree/build_plugin/CMakeCache.txt"; then fail "the plug-in needs no JavaScript and no Python"; fi
"$cmake" --build "$tree/build_plugin" --target help > "$scratch/targets.txt"
if grep -E 'packMesh_executable|catCells|packMesh_manual|packmesh_python' "$scratch/targets.txt"; then fail "programs in a build of the plug-in"; fi
borrow "$tree/build_plugin"
"$cmake" --build "$tree/build_plugin" --parallel "$jobs" --target packMesh_hemocell > "$scratch/build_plugin.log"
library=$(find "$tree/build_plugin/tools/packMesh" -name 'libpackMesh_hemocell.so')
nm -DC "$library" | grep ' T packmesh::plugin::fill(' > /dev/null
test -x "$tree/build_plugin/tools/packMesh/libexec/packmesh/packmesh-tetgen"
if readelf -S "$library" | grep '\.debug_info'; then fail "debug information"; fi

# Neither wrote into HemoCell's folders.
files | diff "$scratch/before.txt" -

# By itself in its folder: mkdir build; cd build; cmake ..
mkdir "$tree/tools/packMesh/build"
cd "$tree/tools/packMesh/build"
"$cmake" .. "${options[@]}" -DBUILD_TESTING=OFF > configure.log
grep -q "^bin/packMesh:" hemocell_adapter/CMakeFiles/packMesh_executable.dir/build.make  # in build/bin
