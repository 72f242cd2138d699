#!/usr/bin/env bash
# Builds the program and the plugins of two scenarios a second time, as Debug without symbols (or
# Release, where this build is Debug), and compares hashes. usage: build_types.sh BUILD_TREE SOURCE_TREE WORK_DIR BUILD_TYPE
set -euo pipefail
build_tree=$1 source_tree=$2 work=$3 type=$4
other=Debug
[ "$type" = Debug ] && other=Release
cmake -S "$source_tree" -B "$work" -G Ninja -DCMAKE_BUILD_TYPE=$other -DCMAKE_CXX_FLAGS_DEBUG=-O0 \
  -DSKYBODY_BUILD_TESTS=OFF -DSKYBODY_BUILD_PYTHON=OFF >"$work.log" 2>&1 || { cat "$work.log"; exit 1; }
cmake --build "$work" --target skybody_cli rotor_speed start inertia imu hover payload >>"$work.log" 2>&1 || { tail -40 "$work.log"; exit 1; }
for scenario in hover payload; do
  arguments=(hash "$source_tree/scenarios/$scenario.yaml" --envs 1 --threads 1 --batch 1 --steps 300 --seed 7)
  here=$("$build_tree/bin/skybody" "${arguments[@]}")
  there=$("$work/bin/skybody" "${arguments[@]}")
  echo "$scenario: $type $here, $other $there"
  [ "$here" = "$there" ]
done
