#!/bin/sh
# Configures and builds the release preset: build.sh [TARGET...]. Quiet unless something fails.
set -eu
cd "$(dirname "$0")/.."

jobs=$(nproc)
# CGAL's headers take up to 1.5 GB per compiler: fewer jobs where memory is short.
memory_kb=$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo 2>/dev/null || echo 0)
if [ "${memory_kb:-0}" -gt 0 ]; then
  fitting=$((memory_kb / 1500000))
  [ "$fitting" -ge 1 ] || fitting=1
  [ "$jobs" -le "$fitting" ] || jobs=$fitting
fi

mkdir -p build
log=build/release-build.log
run() {
  if ! "$@" </dev/null >>"$log" 2>&1; then
    tail -n 60 "$log" >&2
    echo "build: failed: $* (the whole log: $log)" >&2
    exit 1
  fi
}
: >"$log"
run cmake --preset release
if [ "$#" -gt 0 ]; then
  run cmake --build --preset release -j "$jobs" --target "$@"
else
  run cmake --build --preset release -j "$jobs"
fi
