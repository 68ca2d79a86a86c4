#!/usr/bin/env bash
# SPDX-License-Identifier: AGPL-3.0-or-later
# Builds the Python package as a wheel in build/wheel and uses it in a fresh virtual environment: scripts/wheel.sh
# The wheel is for the Python it was built with (PYTHON: another one than Debian's) and needs the libraries of
# scripts/setup.sh --without-tests where it is installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/setup.sh --without-tests
python=${PYTHON:-/usr/bin/python3}
wheels=$PWD/build/wheel
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
rm -rf "$wheels"

# Both environments have the packages of the system: scikit-build for the one, NumPy, SciPy, h5py and Jinja2 for the other. (pip does not see
# Debian's h5py.)
"$python" -m venv --system-site-packages "$scratch/builder"
"$scratch/builder/bin/pip" wheel --quiet --disable-pip-version-check --no-build-isolation --no-deps --wheel-dir "$wheels" .
"$python" -m venv --system-site-packages "$scratch/user"
"$scratch/user/bin/pip" install --quiet --disable-pip-version-check --no-index --no-deps "$wheels"/packmesh-*.whl
mkdir "$scratch/folder"
tests/python/use.sh "$scratch/user/bin/python" "$(echo "$scratch"/user/lib/python3.*/site-packages)" "$scratch/folder"
# The programs, as commands of the environment.
cd "$scratch/folder"
PATH="$scratch/user/bin:$PATH"
packMesh 20 20 20 --hematocrit 0.3 --report report.html --method cat --builder cat-faces > /dev/null
test -s RBC.pos && test -s report.html
packCells 30 30 30 --hematocrit 0.3 > /dev/null && test "$(head -n 1 RBC.pos)" = 84
packmesh --help | grep -q make-vessel
cd - > /dev/null
echo "(packMesh) Wrote $(echo "$wheels"/*.whl)"
