#!/usr/bin/env bash
# Packages and golden flights on another Debian than this machine's: builds a root of that release,
# makes the Debian packages of HEAD in it by `./dev deb`, compares all golden flights on the tree
# engine with the pinned hashes (Simbody is another build there), and installs, uses, removes and
# purges the packages in a bare root. With --clang it also runs `./dev clang` there. Takes root's
# rights, debootstrap, 6 GB and 40 minutes.
#
#   scripts/check_debian.sh [--clang] [RELEASE [FOLDER]]    # trixie, build/debian_trixie
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

clang=0
if [[ ${1:-} == --clang ]]; then
  clang=1
  shift
fi
readonly RELEASE=${1:-trixie}
readonly FOLDER=$(realpath -m "${2:-build/debian_$RELEASE}")
source scripts/debian_root.sh
trap leave_roots EXIT

copy_checkout() {
  local there=$FOLDER/build/src
  [[ -d $there/.git ]] || git clone -q . "$there"
  git -C "$there" fetch -q "$PWD" HEAD
  git -C "$there" reset -q --hard FETCH_HEAD
  # The sources of DAQP, where they are here already: their package may be out of reach from there.
  [[ ! -d .daqp || -d $there/.daqp ]] || cp -a .daqp "$there/"
}

make_root "$RELEASE" build
copy_checkout
say "./dev deb"
inside build 'command -v git >/dev/null ||
    { apt-get -qq update; apt-get -qq install -y --no-install-recommends git >/dev/null; }
  git config --global --replace-all safe.directory "*"; cd /src; ./dev deb'
say "golden flights, by $(inside build 'g++ --version | head -1')"
inside build 'cd /src; flights=$(basename -s .json tests/golden/*.json)
  .venv/bin/python tests/golden/golden.py --program build/package/bin/skybody --flights $flights'
if ((clang)); then
  say "./dev clang"
  inside build 'cd /src; ./dev clang'
fi

say "lintian"
inside build 'apt-get -qq install -y --no-install-recommends lintian >/dev/null
  lintian --allow-root --no-tag-display-limit --fail-on error /src/build/deb/*.deb'

make_root "$RELEASE" bare
say "install, use, remove, purge"
rm -rf "$FOLDER/bare/packages"
mkdir -p "$FOLDER/bare/packages"
cp "$FOLDER"/build/src/build/deb/*.deb "$FOLDER/bare/packages/"
inside bare 'apt-get -qq update
  apt-get -qq install -y --no-install-recommends /packages/*.deb >/dev/null
  cd /tmp; rm -rf flight
  skybody run hover --policy hold --out flight
  skybody plot flight
  skybody render flight -o flight/still.png --at 1
  apt-get -qq remove -y skybody python3-skybody "libskybody*" >/dev/null
  dpkg --purge $(dpkg-query -W -f "\${Package} " "*skybody*") >/dev/null
  left=$(find /usr /etc -name "*skybody*")
  [ -z "$left" ] || { echo "error: left after the purge: $left"; exit 1; }'
say "$RELEASE: packages work, hashes of the tree engine are as on this machine"
