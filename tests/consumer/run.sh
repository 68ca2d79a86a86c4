#!/usr/bin/env bash
# Installs the build tree to a fresh prefix and builds, against nothing but that, the project in this folder.
#   run.sh <cmake> <build tree> <scratch folder>
set -euo pipefail
cmake=$1 build=$2 scratch=$3
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$scratch"
mkdir -p "$scratch"
"$cmake" --install "$build" --prefix "$scratch/prefix" > "$scratch/install.log"

# Moved after installation: nothing may remember where it was installed or built.
mv "$scratch/prefix" "$scratch/moved"
prefix=$scratch/moved
"$cmake" -S "$here" -B "$scratch/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_BUILD_TYPE=Release
"$cmake" --build "$scratch/build"
"$scratch/build/consumer"

if grep -rlF -e "$build" "$prefix" --include='*.cmake' --include='*.h'; then
  echo "these installed files name the build tree"
  exit 1
fi
test -f "$prefix/include/packMesh/packing/pack.h"
test -f "$prefix/share/packMesh/RBC.xml"
test "$(readlink "$prefix/bin/packCells")" = packMesh
"$prefix/bin/packMesh" --version
"$prefix/bin/packCells" --version
