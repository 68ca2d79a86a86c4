#!/usr/bin/env bash
# Installs the missing packages of scripts/apt-packages.txt. Does nothing if none is missing.
#   scripts/setup.sh                   install what the programs, pictures and the core of the tests need
#   scripts/setup.sh --without-tests   install what the programs and pictures need
#   scripts/setup.sh --full            install what all tests and the benchmarks need, too, apart from packages that the system does not have
#   scripts/setup.sh --documentation   install what scripts/docs.sh needs
#   scripts/setup.sh --clang-mpich     install clang and MPICH with its HDF5, for scripts/test.sh clang-mpich
#   scripts/setup.sh --slurm           install Slurm, for tests/cluster/check_slurm.sh
#   scripts/setup.sh --list            print the packages of the first form, one per line
# PACKMESH_SKIP_SETUP=1 skips it (libraries installed in another way).
set -euo pipefail
list="$(dirname "${BASH_SOURCE[0]}")/apt-packages.txt"
part='1,/^# only for all tests/'
case ${1:-} in
  --without-tests) part='1,/^# only for tests/' ;;
  --full) part='1,/^# only for the documentation/' ;;
  --documentation) part='/^# only for the documentation/,/^$/' ;;
  --clang-mpich) part='/^# only for another compiler/,/^$/' ;;
  --slurm) part='/^# only for Slurm/,$' ;;
esac
mapfile -t packages < <(sed -n "${part}p" "$list" | sed -e 's/#.*//' -e 's/[[:space:]]*$//' -e '/^$/d')

if [[ ${1:-} == --list ]]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi
[[ ${PACKMESH_SKIP_SETUP:-0} == 1 ]] && exit 0

if ! command -v apt-get > /dev/null || ! command -v dpkg-query > /dev/null; then
  cat >&2 << MESSAGE
(packMesh) (Error) This system has no apt-get, so the packages cannot be installed automatically.
Install what corresponds to these Debian packages, then run this again with PACKMESH_SKIP_SETUP=1:
  ${packages[*]}
MESSAGE
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  status=$(dpkg-query -W -f='${db:Status-Status}' "$package" 2> /dev/null) || status=absent
  [[ $status == installed || $status == triggers-* ]] || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  echo "(packMesh) All ${#packages[@]} packages are installed."
  exit 0
fi

echo "(packMesh) Installing: ${missing[*]}"
as_root=()
if [[ $(id -u) -ne 0 ]]; then
  if ! command -v sudo > /dev/null; then
    echo "(packMesh) (Error) Installing packages needs root or sudo. As root, run: apt-get install ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
install() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -q --no-install-recommends -o Dpkg::Use-Pty=0 -o DPkg::Lock::Timeout=600 "${missing[@]}"
}
# Package lists are fetched only when they are absent or too old to install from.
if ! apt-cache show "${missing[@]}" &> /dev/null || ! install; then
  "${as_root[@]}" apt-get update -q
  if [[ ${1:-} == --full ]]; then # CMake leaves out tests whose programs are not there: Ubuntu has Chromium as a snap alone
    present=()
    for package in "${missing[@]}"; do
      if apt-cache policy "$package" | grep 'Candidate: [^(]' > /dev/null || "${BASH_SOURCE[0]}" --list | grep -xF "$package" > /dev/null; then
        present+=("$package")
      else
        echo "(packMesh) Not installed, because this system does not have it: $package"
      fi
    done
    missing=("${present[@]}")
  fi
  if ! install; then
    cat >&2 << MESSAGE
(packMesh) (Error) apt-get could not install: ${missing[*]}
packMesh is built and tested on Debian 12 and 13; other releases may name these packages differently.
MESSAGE
    exit 1
  fi
fi
