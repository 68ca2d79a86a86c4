#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# Installs the Python package to a fresh prefix, moves that, and uses the package from there.
#   install.sh <cmake> <build tree> <python> <scratch folder>
set -euo pipefail
cmake=$1 build=$2 python=$3 scratch=$4
use=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/use.sh
rm -rf "$scratch"
mkdir -p "$scratch"
"$cmake" --install "$build" --prefix "$scratch/prefix" --component python > "$scratch/install.log"
mv "$scratch/prefix" "$scratch/moved"
packages=$(echo "$scratch"/moved/lib/python3.*/site-packages)
PYTHONPATH=$packages "$use" "$python" "$packages" "$scratch"
