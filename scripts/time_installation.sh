#!/usr/bin/env bash
# Times the way from the wheels to a film in a bare Debian: installation, first flight, training, a
# flight of the trained policy, and its film. Prints a line of Markdown for each part. Takes root's
# rights and debootstrap.
#
#   scripts/time_installation.sh [RELEASE [FOLDER]]    # wheels of build/wheels; trixie, build/debian_trixie
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly RELEASE=${1:-trixie}
readonly FOLDER=$(realpath -m "${2:-build/debian_$RELEASE}")
source scripts/debian_root.sh
trap leave_roots EXIT

make_root "$RELEASE" user
rm -rf "$FOLDER/user/wheels" "$FOLDER/user/tmp/flights"
cp -r build/wheels "$FOLDER/user/wheels"
inside user 'command -v python3 >/dev/null ||
    { apt-get -qq update; apt-get -qq install -y --no-install-recommends python3-venv >/dev/null; }
  rm -rf /venv; python3 -m venv /venv'

total=0
# part NAME COMMAND
part() {
  local start=$EPOCHREALTIME seconds
  inside user "cd /tmp; . /venv/bin/activate; { $2; } >/tmp/log 2>&1 || { cat /tmp/log; exit 1; }"
  seconds=$(awk "BEGIN {printf \"%.1f\", $EPOCHREALTIME - $start}")
  total=$(awk "BEGIN {printf \"%.1f\", $total + $seconds}")
  echo "| $1 | $seconds |"
}
echo "| $RELEASE, load $(cut -d' ' -f1 /proc/loadavg) | s |"
echo "| --- | ---: |"
part 'pip install' 'n=$(python -c "import sys; print(\"cp311-cp311\" if sys.version_info < (3, 12) else \"abi3\")")
  pip install --no-cache-dir /wheels/libskybody-*.whl /wheels/skybody-*-$n-*.whl'
part 'skybody run hover' 'skybody run hover --policy hold --out flights/first'
part 'skybody train hover_learn' 'skybody train hover_learn --out flights/learn'
part 'skybody run hover_learn' 'skybody run hover_learn --policy flights/learn --out flights/learned'
part 'skybody render' 'skybody render flights/learned -o film.mp4'
echo "| together | $total |"
