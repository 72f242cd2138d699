#!/usr/bin/env bash
# Times the way from the wheels, or with --deb from the Debian packages, to a film in a bare Debian:
# installation, first flight, training, a flight of the trained policy, and its film. Prints a row of
# Markdown for each part. Takes root's rights and debootstrap; packages are those of build/wheels or
# build/deb.
#
#   scripts/time_installation.sh [--deb] [RELEASE [FOLDER]]    # trixie, build/debian_trixie
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

kind=wheels
if [[ ${1:-} == --deb ]]; then
  kind=deb
  shift
fi
readonly RELEASE=${1:-trixie}
readonly FOLDER=$(realpath -m "${2:-build/debian_$RELEASE}")
source scripts/debian_root.sh
trap leave_roots EXIT

readonly ROOT=user_of_$kind
make_root "$RELEASE" "$ROOT"
rm -rf "$FOLDER/$ROOT"/{packages,venv,tmp/flights}
cp -r "build/$kind" "$FOLDER/$ROOT/packages"
if [[ $kind == wheels ]]; then
  start='. /venv/bin/activate'
  inside "$ROOT" 'command -v python3 >/dev/null ||
      { apt-get -qq update; apt-get -qq install -y --no-install-recommends python3-venv >/dev/null; }
    python3 -m venv /venv'
else
  start=true
  inside "$ROOT" 'there=$(dpkg-query -W -f "\${Package} " "*skybody*" ffmpeg 2>/dev/null) || true
    [ -z "$there" ] || apt-get -qq purge -y --autoremove $there >/dev/null
    apt-get -qq clean; apt-get -qq update'
fi

TIMEFORMAT='%R %U %S'
all=()
# part NAME COMMAND: seconds of the clock, and of processors, which tell more under load.
part() {
  local script="cd /tmp; $start; { $2; } >/tmp/log 2>&1 || { cat /tmp/log >&2; exit 1; }"
  local spent
  spent=$({ time inside "$ROOT" "$script" 2>"$FOLDER/error.log"; } 2>&1) || {
    cat "$FOLDER/error.log" >&2
    exit 1
  }
  all+=("$spent")
  awk -v name="$1" '{printf "| %s | %.1f | %.1f |\n", name, $1, $2 + $3}' <<<"$spent"
}
echo "| $RELEASE, load $(cut -d' ' -f1 /proc/loadavg) on $(nproc) processors | s | processor s |"
echo "| --- | ---: | ---: |"
if [[ $kind == wheels ]]; then
  part 'pip install' 'n=$(python -c "import sys; print(\"cp311-cp311\" if sys.version_info < (3, 12) else \"abi3\")")
    pip install --no-cache-dir /packages/libskybody-*.whl /packages/skybody-*-$n-*.whl'
else
  part 'apt install' 'apt-get install -y --no-install-recommends ffmpeg /packages/*.deb'
fi
part 'skybody run hover' 'skybody run hover --policy hold --out flights/first'
part 'skybody train hover_learn' 'skybody train hover_learn --out flights/learn'
part 'skybody run hover_learn' 'skybody run hover_learn --policy flights/learn --out flights/learned'
part 'skybody render' 'skybody render flights/learned -o film.mp4'
printf '%s\n' "${all[@]}" |
  awk '{wall += $1; work += $2 + $3} END {printf "| together | %.1f | %.1f |\n", wall, work}'
