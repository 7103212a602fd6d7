#!/usr/bin/env bash
# Runs the wrapper's scene tests (handles, meshes, filters, instances, packets, errors, memory, threads) under valgrind.
# Embree is held to AVX2, the widest instruction set that valgrind knows. Skips, with a printed line, without
# valgrind; with AMBAKE_TEST_STRICT=1 that is a failure.
set -euo pipefail
cd "$(dirname "$0")/../.."
command -v valgrind >/dev/null || {
  echo "skip: valgrind is not installed"
  [[ ${AMBAKE_TEST_STRICT:-} != 1 ]]
  exit
}
AMBAKE_EMBREE_ISA=avx2 \
  CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUNNER="valgrind --quiet --error-exitcode=1" \
  cargo test -p ambake-embree --test scenes --locked --quiet -- --test-threads=1 --skip a_cpu_without
