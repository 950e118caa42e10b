#!/usr/bin/env bash
# Installs what is missing, builds the release preset and runs every test.
# Arguments are handed to ctest, e.g. ./test.sh -R StackRun
set -euo pipefail
cd "$(dirname "$0")"

seconds() { echo "${SECONDS}s"; }
./scripts/install-packages.sh chromium  # for the test that opens a report in a browser
./scripts/install-packages.sh slurm-wlm munge || echo "test.sh: no Slurm here, its test will be skipped"
echo "building ..."
if ! ./scripts/build.sh; then
  echo "test.sh: FAILED: the build ($(seconds))"
  exit 1
fi
echo "testing ..."
status=0
ctest --preset release -j "$(nproc)" --output-log build/release-test.log "$@" </dev/null || status=$?
if [ "$status" -ne 0 ]; then
  echo "test.sh: FAILED (ctest's exit code $status, log in build/release-test.log, $(seconds))"
  exit "$status"
fi
passed=$(sed -n 's/.*tests passed, .* tests failed out of \([0-9]*\).*/\1/p' build/release-test.log | tail -n 1)
echo "test.sh: all ${passed:-?} tests passed ($(seconds))"
