# Functions of scripts that work in another Debian than this machine's. They need root's rights and
# debootstrap. FOLDER has the roots; MIRROR is this machine's.

readonly MIRROR=$(sed -n 's/^URIs: *//p' /etc/apt/sources.list.d/debian.sources | head -1)
readonly CACHE=${CCACHE_DIR:-$HOME/.cache/ccache}

say() { printf '\033[1m%s\033[0m\n' "$*" >&2; }

leave_roots() {
  local place
  for place in "$FOLDER"/*/{root/.cache/ccache,proc,dev}; do
    ! mountpoint -q "$place" || umount "$place"
  done
}

# inside ROOT COMMAND: runs a command in a root, with this machine's network and ccache.
inside() {
  local root=$FOLDER/$1 path=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin
  mkdir -p "$root/root/.cache/ccache" "$CACHE"
  mountpoint -q "$root/proc" || mount -t proc proc "$root/proc"
  mountpoint -q "$root/dev" || mount --bind /dev "$root/dev"
  mountpoint -q "$root/root/.cache/ccache" || mount --bind "$CACHE" "$root/root/.cache/ccache"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  chroot "$root" /usr/bin/env -i HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive PATH="$path" \
    SKYBODY_JOBS="${SKYBODY_JOBS:-$(nproc)}" bash -ec "$2"
}

# make_root RELEASE ROOT
make_root() {
  [[ ! -e $FOLDER/$2/etc/debian_version ]] || return 0
  say "a bare $1 in $FOLDER/$2"
  mkdir -p "$FOLDER"
  debootstrap --variant=minbase --include=ca-certificates "$1" "$FOLDER/$2" "$MIRROR" >"$FOLDER/$2.log"
  cp /etc/ssl/certs/ca-certificates.crt "$FOLDER/$2/etc/ssl/certs/"
}
