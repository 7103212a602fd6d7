#!/bin/bash
# Runs bake.yaml with openjd-cli (PyPI). One part is killed in the middle first, and a part that lacks stops the merge. The result must be
# the bytes of a plain bake.
#
#     integrations/openjd/test.sh [SCENE [SIZE RAYS]]
#
# AMBAKE is the program, else target/debug/ambake. OPENJD is openjd-cli's program, else `openjd`.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
AMBAKE=$(realpath "${AMBAKE:-$root/target/debug/ambake}")
OPENJD=${OPENJD:-openjd}
scene=$(realpath "${1:-$root/scenes/courtyard.obj}")
size=${2:-256}
rays=${3:-256}

# With AMBAKE_TEST_STRICT=1 what is skipped has failed.
skip() {
    echo "skip: $*"
    [ "${AMBAKE_TEST_STRICT:-}" != 1 ] || exit 1
    exit 0
}
command -v "$OPENJD" >/dev/null || skip "openjd is absent: pip install openjd-cli"
[ -x "$AMBAKE" ] || skip "$AMBAKE is absent: cargo build --locked"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$OPENJD" check "$here/bake.yaml"
"$AMBAKE" bake "$scene" -o "$work/whole" --size "$size" --rays "$rays" --quiet

# A task of the job that dies.
"$AMBAKE" layout "$scene" -o "$work/parts" --size "$size" --rays "$rays" --quiet
"$AMBAKE" bake "$scene" -o "$work/parts" --size "$size" --rays "$rays" --quiet --shard 2/4 &
task=$!
sleep "${KILL_AFTER:-0.5}"
kill -KILL "$task" 2>/dev/null || true
wait "$task" 2>/dev/null || true
find "$work/parts" -name '.*.ambake-resume' -printf 'left by the killed task: %f, %s bytes\n'

run() {
    "$OPENJD" run "$here/bake.yaml" --step "$1" "${@:2}" --run-dependencies \
        -p Scene="$scene" -p Output="$work/parts" -p Size="$size" -p Rays="$rays" -p Parts=4 \
        -p Ambake="$AMBAKE" >"$work/log" 2>&1
}
if "$AMBAKE" merge "$work/parts" --quiet 2>"$work/log"; then
    echo "a merge without its parts must fail"
    exit 1
fi
run Merge || { tail -n 40 "$work/log"; exit 1; }

rm -f "$work"/parts/layout.json "$work"/parts/*.layout "$work"/parts/*.layout.png
different=$(diff -rq -x bake.json "$work/whole" "$work/parts" || true)
[ -z "$different" ] || { echo "$different"; exit 1; }
echo "ok: the bytes of a plain bake ($(find "$work/parts" -type f | wc -l) files)"
