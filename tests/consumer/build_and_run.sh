#!/usr/bin/env bash
# Builds the consumer project against one source of Skybody, and runs it: two programs with the
# library, learners, renderer, and a plugin. KIND is
#   tree        the build tree
#   prefix      an installation, made for this test; pkg-config, too
#   fetch       FetchContent: configures Skybody as a part of the project, and builds the renderer
#               and a plugin
#   FOLDER      the folder of an installed SkybodyConfig.cmake: `python -P -m skybody --cmake-dir` of a
#               wheel, /usr/lib/cmake/Skybody of the Debian packages
# CXX may name the compiler.
# usage: build_and_run.sh BUILD_TREE SOURCE_TREE WORK_DIR KIND
set -euo pipefail
build_tree=$1 source_tree=$2 work=$3 kind=$4
rm -rf "$work"
mkdir -p "$work"
skybody=$build_tree/bin/skybody
case $kind in
  tree) config=(-DSkybody_DIR="$build_tree") ;;
  prefix)
    cmake --install "$build_tree" --prefix "$work/prefix" >"$work/install.log"
    config=(-DCMAKE_PREFIX_PATH="$work/prefix")
    skybody=$work/prefix/bin/skybody
    ;;
  fetch) config=(-DSKYBODY_FETCH="$source_tree" -DSKYBODY_BUILD_PYTHON=OFF) ;;
  *)
    config=(-DSkybody_DIR="$kind")
    skybody=$kind/../../../bin/skybody
    ;;
esac

cmake -S "$source_tree/tests/consumer/project" -B "$work/build" -G Ninja -DCMAKE_BUILD_TYPE=Release \
  "${config[@]}" >"$work/configure.log" || { cat "$work/configure.log"; exit 1; }

# Programs are compiled with none of our flags; sanitized builds need theirs.
line=$(grep -m 1 'command.*project/main.cpp' "$work/build/compile_commands.json")
if [[ $line == *-ffp-contract* || $line == *-Werror* || $line == *-Wno-* ]]; then
  echo "our flags leak into a program: $line"
  exit 1
fi

build() { cmake --build "$work/build" --target "$@" >"$work/build.log" || { cat "$work/build.log"; exit 1; }; }
if [[ $kind == fetch ]]; then # the library takes many minutes
  build draw_sphere visit_points
  "$work/build/draw_sphere"
  "$skybody" check "$source_tree/examples/visit_points.yaml" --plugin-path "$work/build/plugins"
  exit 0
fi
build all
"$work/build/consumer" hover
[[ ! -x $work/build/pool ]] || "$work/build/pool" hover
"$work/build/draw_sphere"
(cd "$work" && build/learn 20000 && test -s policy.h5)
(cd "$work" && rm policy.h5 && build/own_algorithm 20000 && test -s policy.h5)
"$skybody" check "$source_tree/examples/visit_points.yaml" --plugin-path "$work/build/plugins"

if [[ $kind == prefix ]] && command -v pkg-config >/dev/null; then
  export PKG_CONFIG_PATH=$work/prefix/lib/pkgconfig
  read -ra flags < <(pkg-config --cflags --libs skybody)
  "${CXX:-c++}" "$source_tree/tests/consumer/project/main.cpp" "${flags[@]}" -Wl,-rpath,"$work/prefix/lib" -o "$work/by_pkg_config"
  "$work/by_pkg_config" hover
fi
