#!/usr/bin/env bash
# Bakes three scenes, shows them in Bevy without a window, and compares with ambake's own pictures. Needs a Vulkan driver.
# Usage: test.sh [AMBAKE]
set -euo pipefail
cd "$(dirname "$0")/../.."
ambake=$(realpath "${1:-target/debug/ambake}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cargo build --locked --manifest-path integrations/bevy/Cargo.toml
program=${CARGO_TARGET_DIR:-integrations/bevy/target}/debug/ambake-bevy

shown() { # shown SCENE EYE LOOK OPTIONS...: bakes, renders and compares
  local scene=$1 eye=$2 look=$3 stem
  shift 3
  stem=$(basename "${scene%.*}")
  "$ambake" bake "$scene" -o "$folder/$stem" --for bevy --quiet "$@"
  "$ambake" render "$scene" --bake "$folder/$stem" -o "$folder/$stem.exr" --model lambert --eye "$eye" --look "$look" --fov-deg 40 \
    --size 320x240 --samples 1 --background 0,0,0.5 --quiet
  echo "$stem"
  "$program" "$folder/$stem" "$stem" "$eye" "$look" 40 "$folder/$stem.exr" 2>"$folder/log" || { cat "$folder/log"; return 1; }
}

shown scenes/instances_twin.obj 6,5,8 0,0.5,0 --size 64 --density 10 --gutter 4 --rays 16 --sky 0.9,0.6,0.3
shown scenes/instances.gltf 6,5,8 0,0.5,0 --size 256 --rays 32
shown scenes/courtyard.obj 7,5,8 0,0.5,0 --size 512 --rays 64
