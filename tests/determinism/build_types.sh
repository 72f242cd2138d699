#!/usr/bin/env bash
# Builds libskybody and the plugins of two scenarios a second time, as Debug without optimisation and symbols (or
# Release, where this build is Debug) and for one instruction set, and compares hashes. Many files at a time (CMAKE_UNITY_BUILD), for most of the
# work is reading headers. usage: build_types.sh BUILD_TREE SOURCE_TREE WORK_DIR BUILD_TYPE
set -euo pipefail
build_tree=$1 source_tree=$2 work=$3 type=$4
other=Debug
[ "$type" = Debug ] && other=Release
cmake -S "$source_tree" -B "$work" -G Ninja -DCMAKE_BUILD_TYPE=$other -DCMAKE_CXX_FLAGS_DEBUG=-O0 -DCMAKE_CXX_FLAGS=-w \
  -DCMAKE_UNITY_BUILD=ON -DSKYBODY_PORTABLE=ON -DSKYBODY_BUILD_PYTHON=OFF >"$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake --build "$work" --target scenario_hash >>"$work.log" 2>&1 || { tail -40 "$work.log"; exit 1; }
here=$("$build_tree/bin/scenario_hash" hover payload)
there=$("$work/bin/scenario_hash" hover payload)
printf '%s\n%s\n%s\n%s\n' "$type" "$here" "$other" "$there"
[ -n "$here" ] && [ "$here" = "$there" ]
