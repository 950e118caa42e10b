#!/bin/sh
# Installs the Debian 12 packages that the build needs and that are missing. Needs root or sudo for
# that; with everything in place it changes nothing and needs neither. Further package names may be
# given as arguments.
set -eu

packages="g++ cmake ninja-build ccache
  libcgal-dev libosd-dev libeigen3-dev libtbb-dev libcli11-dev libfmt-dev nlohmann-json3-dev libpng-dev
  libtomlplusplus-dev libxxhash-dev
  libgtest-dev libbenchmark-dev"

missing=""
for package in $packages "$@"; do
  state=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
  [ "$state" = "install ok installed" ] || missing="$missing $package"
done
[ -n "$missing" ] || exit 0

if ! command -v apt-get >/dev/null; then
  echo "install-packages: no apt-get here; please install:$missing" >&2
  exit 1
fi
as_root=""
if [ "$(id -u)" -ne 0 ]; then
  if ! command -v sudo >/dev/null; then
    echo "install-packages: run this as root, or install:$missing" >&2
    exit 1
  fi
  as_root="sudo"
fi

echo "installing:$missing" >&2
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o Dpkg::Use-Pty=0 \
    -o DPkg::Lock::Timeout=300 -o Acquire::Retries=3 "$@" </dev/null >"$log" 2>&1
}
# The package lists are often fresh enough; on a new machine there are none.
# shellcheck disable=SC2086  # a list of words
if ! apt install -y --no-install-recommends $missing; then
  if ! { apt update && apt install -y --no-install-recommends $missing; }; then
    cat "$log" >&2
    echo "install-packages: apt-get failed (see above)" >&2
    exit 1
  fi
fi
