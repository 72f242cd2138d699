#!/usr/bin/env bash
# Builds the consumer project against a build tree (prefix empty) or an install prefix, and runs it.
# usage: build_and_run.sh BUILD_TREE SOURCE_TREE WORK_DIR tree|prefix
set -euo pipefail
build_tree=$1 source_tree=$2 work=$3 kind=$4
rm -rf "$work"
mkdir -p "$work"
config=(-DSkybody_DIR="$build_tree")
scenario="$source_tree/scenarios/hover/hover.yaml"
if [ "$kind" = prefix ]; then
  cmake --install "$build_tree" --prefix "$work/prefix" >"$work/install.log"
  config=(-DCMAKE_PREFIX_PATH="$work/prefix")
  scenario="$work/prefix/share/skybody/scenarios/hover/hover.yaml"
fi
cmake -S "$source_tree/tests/consumer/project" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release "${config[@]}" >"$work/configure.log"
cmake --build "$work/build" >"$work/build.log" || { cat "$work/build.log"; exit 1; }
"$work/build/consumer" "$scenario"
"$work/build/pool" "$scenario"
(cd "$work" && build/learn 20000 && test -s policy.h5)
