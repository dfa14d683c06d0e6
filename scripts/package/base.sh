# For scripts/package/check and system.

# make_base SUITE: makes a small Debian of that suite, build/debian-SUITE.tar, unless it is there; remove it to have a newer one. Sets $base.
make_base() {
  base=$PWD/build/debian-$1.tar
  [ ! -f "$base" ] || return 0
  mkdir -p build
  echo "making a Debian $1"
  mmdebstrap --format=tar --variant=apt "$1" "$base.new" >"$base.log" 2>&1 ||
    { tail -n 5 "$base.log" >&2; echo "no Debian $1 could be made" >&2; return 1; }
  mv "$base.new" "$base"
}
# In a system that was made so: a clean environment, and apt that asks nothing.
clean() { exec env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
