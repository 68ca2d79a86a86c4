#!/usr/bin/env bash
# The Debian package: what it depends on, and that what it holds runs (scripts/packaging/test_deb.sh installs it on a bare system).
#   debian_package.sh <cpack> <build tree> <scratch folder>
set -euo pipefail
cpack=$1 build=$2 scratch=$3
rm -rf "$scratch"
mkdir -p "$scratch"
"$cpack" -G DEB --config "$build/CPackConfig.cmake" -B "$scratch" > "$scratch/cpack.log"
package=$(echo "$scratch"/packmesh_*.deb)
dpkg-deb --info "$package" | tee "$scratch/info.txt"
for library in libc6 libhdf5-openmpi libopenmpi libtinyxml2 libtet1.5 libfmt; do
  grep -q "^ Depends:.*$library" "$scratch/info.txt" || { echo "does not depend on $library"; exit 1; }
done
for library in fmt hdf5-openmpi openmesh openmpi tinyxml2; do
  grep -q "^ Suggests:.*lib$library-dev" "$scratch/info.txt" || { echo "does not suggest lib$library-dev"; exit 1; }
done
grep -q '^ Recommends:.*python3-numpy, python3-scipy, python3-h5py, python3-jinja2' "$scratch/info.txt" || { echo "does not recommend what packmesh needs"; exit 1; }
grep -q '^ Description: ' "$scratch/info.txt"
dpkg-deb --extract "$package" "$scratch/root"
cd "$scratch"
PATH="$scratch/root/usr/bin:$PATH" packCells 30 30 30 --hematocrit 0.3 > packed.txt
test "$(head -n 1 RBC.pos)" = 84
root/usr/bin/packMesh check --box 30 30 30 --ends periodic > /dev/null
test -x root/usr/libexec/packmesh/packmesh-tetgen
root/usr/bin/packMesh 10 10 10 --rbc 2 --method cat --builder cat-faces --output-dir faces > /dev/null
for file in bin/catCells bin/packmesh share/packMesh/RBC.xml share/packMesh/packing/keep.xml share/man/man1/packMesh.1.gz share/man/man1/catCells.1.gz share/doc/packmesh/changelog.gz \
  share/bash-completion/completions/packMesh share/doc/packmesh/copyright share/doc/packmesh/examples/pipe/config.xml \
  share/packMesh/scripts/make_tube.sh include/packMesh/packing/pack.h \
  lib/python3/dist-packages/packmesh/_packmesh.pyi lib/python3/dist-packages/packmesh/show/page/three.min.js; do
  test -s "root/usr/$file" || { echo "the package lacks $file"; exit 1; }
done
root/usr/bin/packMesh 20 20 20 --rbc 5 --export csv --report report.html > /dev/null
grep -q OrbitControls report.html && test -s cells.csv
PYTHONPATH=root/usr/lib/python3/dist-packages /usr/bin/python3 -c '
import packmesh
assert packmesh.__file__.startswith("'"$scratch"'")
assert packmesh.pack(box=(30, 30, 30), hematocrit=0.3).counts["RBC"] == 100
packmesh.pack(box=(10, 10, 10), species={"RBC": 2}, method="cat", builder="cat-faces")'
# Debian's own checks, where they are installed.
if command -v lintian > /dev/null; then
  lintian --allow-root --fail-on error,warning "$package"
fi
