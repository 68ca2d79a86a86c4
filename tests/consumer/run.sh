#!/usr/bin/env bash
# Installs the build tree to a fresh prefix and builds, against nothing but that, the project of docs/howto/library.md, and all
# installed headers.
#   run.sh <cmake> <build tree> <scratch folder> <docs/howto/library.md>
set -euo pipefail
cmake=$1 build=$2 scratch=$3 document=$4
rm -rf "$scratch"
mkdir -p "$scratch"
"$cmake" --install "$build" --prefix "$scratch/prefix" > "$scratch/install.log"

# Moved after installation: nothing may remember where it was installed or built.
mv "$scratch/prefix" "$scratch/moved"
prefix=$scratch/moved
project=$scratch/project
mkdir "$project"
block() { sed -n "/^\`\`\`$1\$/,/^\`\`\`\$/p" "$document" | sed '1d;$d'; }
block cmake > "$project/CMakeLists.txt"
block cpp > "$project/capsule.cpp"
block text > "$scratch/expected.txt"
mkdir "$project/headers"
# Those that include headers of HemoCell or MPI need them.
(cd "$prefix/include" && grep -rL --include='*.h' '#include <\(hemocell\|mpi\).h>' packMesh) | while IFS= read -r header; do
  echo "#include \"$header\"" > "$project/headers/${header//\//_}.cpp"
done
cat >> "$project/CMakeLists.txt" << 'HEADERS'
file(GLOB headers headers/*.cpp)
add_library(headers OBJECT ${headers})
target_link_libraries(headers PRIVATE packMesh::packMesh)
set_target_properties(headers PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
target_compile_options(headers PRIVATE -O0)
HEADERS
"$cmake" -S "$project" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release
"$cmake" --build "$scratch/build"
"$scratch/build/capsule" | tee "$scratch/said.txt"
diff "$scratch/expected.txt" "$scratch/said.txt"

if grep -rlF -e "$build" "$prefix" --include='*.cmake' --include='*.h'; then
  echo "these installed files name the build tree"
  exit 1
fi
test -f "$prefix/include/packMesh/packing/pack.h"
test -f "$prefix/share/packMesh/RBC.xml"
test "$(readlink "$prefix/bin/packCells")" = packMesh
"$prefix/bin/packMesh" --version
"$prefix/bin/packCells" --version
