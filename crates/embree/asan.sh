#!/usr/bin/env bash
# Runs the wrapper's scene and ray tests under AddressSanitizer, shim and Rust alike, with the widest instructions that the
# processor has: valgrind knows no AVX-512. Embree itself is not built anew; what it reads and writes of ours lies in memory
# that AddressSanitizer allocated, and its calls of malloc, free and memcpy are checked. Skips without nightly Rust.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo +nightly --version >/dev/null 2>&1 || { echo "skip: nightly Rust is not installed"; exit 0; }
# A target is named, so that build scripts and macros are built without it. What Embree keeps to its end is no leak of ours.
export CFLAGS_x86_64_unknown_linux_gnu="-fsanitize=address -fno-omit-frame-pointer -g"
export RUSTFLAGS="-Zsanitizer=address -Cforce-frame-pointers=yes"
export CARGO_TARGET_DIR=target/asan ASAN_OPTIONS="detect_leaks=0:abort_on_error=0:exitcode=1"
cargo +nightly test --target x86_64-unknown-linux-gnu -p ambake-embree --locked --quiet --test scenes --test rays \
  -- --test-threads=1
