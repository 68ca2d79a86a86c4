#!/usr/bin/env bash
# Installs a Debian package of packMesh on a bare Debian 12 and runs it there; needs root and debootstrap.
#   cpack -G DEB --config build/CPackConfig.cmake -B /tmp/deb
#   scripts/packaging/test_deb.sh /tmp/deb/packmesh_1.2.0_amd64.deb [folder of the system, made when absent]
set -euo pipefail
package=$(realpath "$1")
system=${2:-$(mktemp -d)/bookworm}
[[ -d $system/etc ]] || debootstrap --variant=minbase bookworm "$system" > /dev/null
inside() { chroot "$system" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root DEBIAN_FRONTEND=noninteractive "$@"; }
mountpoint -q "$system/proc" || { mount -t proc proc "$system/proc"; trap 'umount "$system/proc"' EXIT; }

cp "$package" "$system/root/packmesh.deb"
inside apt-get -qq update
inside apt-get -qq install -y --no-install-recommends /root/packmesh.deb > "$system/root/install.log" 2>&1
if inside sh -c 'command -v g++ cmake'; then echo "this system has build tools: nothing is shown by it"; exit 1; fi
inside dpkg --verify packmesh
inside sh -euc '
  packMesh --version
  rm -rf /root/pipe && cp -r /usr/share/doc/packmesh/examples/pipe /root/pipe && cd /root/pipe
  packMesh config.xml | tail -n 5
  packMesh check config.xml | tail -n 1
  packCells 30 30 30 --hematocrit 0.3 --quiet && head -n 1 RBC.pos
  packMesh 10 10 10 --rbc 2 --method cat --builder cat-faces --quiet  # by packmesh-tetgen
  test -s /usr/share/man/man1/packMesh.1*'
# With what the package recommends: on two ranks the same bytes, and pages.
mapfile -t recommended < <(inside dpkg-query -W -f '${Recommends}' packmesh | sed 's/, */\n/g')
inside apt-get -qq install -y --no-install-recommends "${recommended[@]}" > "$system/root/install.log" 2>&1
inside sh -euc '
  cd /root/pipe && mkdir -p ranks
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
  packMesh config.xml --quiet
  mpirun --oversubscribe -n 2 packMesh config.xml --output-dir ranks | head -n 1
  cmp RBC.pos ranks/RBC.pos
  packMesh 20 20 20 --rbc 5 --state cells.h5 --report report.html --quiet && grep -q OrbitControls report.html
  packmesh view cells.h5 --report report.json --page page.html && cmp report.html page.html'
inside apt-get -qq purge -y packmesh > /dev/null 2>&1
inside sh -c '! command -v packMesh'
echo "(packMesh) The package installs, runs and goes away on $(cat "$system/etc/debian_version")"
