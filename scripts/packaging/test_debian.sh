#!/usr/bin/env bash
# Runs the two commands of README.md on a bare Debian in a folder: scripts/packaging/test_debian.sh RELEASE FOLDER [COMMAND ...]
#   scripts/packaging/test_debian.sh 13 /tmp/debian13                        both commands, and how long they took
#   scripts/packaging/test_debian.sh 13 /tmp/debian13 scripts/test.sh full   another command, in the system that is there
# Needs root and debootstrap. The system is made where FOLDER does not exist, from the mirror of this machine (or $MIRROR); the source is what git
# has of the working tree, laid anew into FOLDER/packMesh, whose build folders stay.
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
case ${1:-} in
  12) name=bookworm ;;
  13) name=trixie ;;
  *) sed -n '2,6s/^# //p' "${BASH_SOURCE[0]}" >&2; exit 1 ;;
esac
folder=${2:?the folder of the system}
shift 2
mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 2> /dev/null | grep -m 1 'debian/*$' || echo http://deb.debian.org/debian)}
if [[ ! -e $folder/packMesh ]]; then
  [[ ! -e $folder ]] || { echo "(packMesh) (Error) $folder is there, but no system that this script has made; remove it" >&2; exit 1; }
  debootstrap --variant=minbase "$name" "$folder" "$mirror"
  mkdir "$folder/packMesh"
fi
grep -q "VERSION_CODENAME=$name" "$folder/etc/os-release" || { echo "(packMesh) (Error) the system in $folder is not $name" >&2; exit 1; }
cp /etc/resolv.conf /etc/hosts "$folder/etc/"
cp -n /etc/apt/apt.conf.d/* "$folder/etc/apt/apt.conf.d/"
trap 'for place in dev/pts dev sys proc; do ! mountpoint -q "$folder/$place" || umount -l "$folder/$place"; done' EXIT
for place in proc sys dev dev/pts; do
  mountpoint -q "$folder/$place" || mount --bind "/$place" "$folder/$place"
done
find "$folder/packMesh" -mindepth 1 -maxdepth 1 ! -name 'build*' -exec rm -rf {} +
(cd "$source" && git ls-files -z --cached --others --exclude-standard | tar c --null -T - --ignore-failed-read) | tar x -C "$folder/packMesh"

# @param what runs in the system
inside() {
  local begin=$SECONDS
  chroot "$folder" /usr/bin/env -i HOME=/root PATH=/usr/sbin:/usr/bin:/sbin:/bin LANG=C.UTF-8 CI="${CI:-}" bash -c 'cd /packMesh && "$@"' bash "$@"
  echo "(packMesh) Debian $(cat "$folder/etc/debian_version"): $* took $((SECONDS - begin)) s"
}
if (($#)); then
  inside "$@"
else
  inside scripts/run_example.sh
  inside scripts/test.sh
fi
