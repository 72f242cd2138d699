#!/usr/bin/env bash
# Writes requirements/*.txt, every package with its version and hashes, from the names in
# requirements/*.in. Locked versions are kept; -U, or -P PACKAGE, takes the newest.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../requirements"

tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
python3 -m venv "$tools"
"$tools/bin/python" -m pip install --quiet --disable-pip-version-check uv==0.13.9

# lock NAME [OPTION...]
lock() {
  "$tools/bin/uv" pip compile --quiet --no-config --universal --python-version 3.11 --generate-hashes \
    --no-annotate --custom-compile-command scripts/lock_requirements.sh "$1.in" -o "$1.txt" "${@:2}" >/dev/null
}

lock dev "$@"
lock no-deps --no-deps "$@"
lock pictures -c dev.txt
lock packages -c dev.txt
# Ray's environment extends that of the tests and has its packages, except Gymnasium (./dev ray).
sed -n 's/^\([a-z0-9-]*==[^ ]*\).*/\1/p' dev.txt | grep -v '^gymnasium==' >"$tools/shared.txt"
lock ray -c "$tools/shared.txt" "$@"
lock ros -c dev.txt "$@"
lock docs "$@"
