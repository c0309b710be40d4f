#!/bin/sh
# Builds the tests of the rooms that read foreign bytes, hold the bus and drive instruments, with ASan and UBSan, and runs them.
#   scripts/sanitized_tests.sh [PROGRAM...]
# In the tree of scripts/fuzz.sh, which has compiled these rooms already. `./firn test --asan` builds and runs all tests.
set -eu
cd "$(dirname "$0")/.."
programs=${*:-"test_files test_runtime test_procs test_drivers test_page"}
cmake --preset fuzz >/dev/null
# shellcheck disable=SC2086  # a list of names
ninja -C build-fuzz $programs >build-fuzz/build.log || { grep -A 8 -E "^FAILED|error:|fatal" build-fuzz/build.log | cut -c1-400 | head -n 60; exit 1; }
names=$(echo "$programs" | tr ' ' '|')
export LSAN_OPTIONS="suppressions=$PWD/tests/lsan.supp ${LSAN_OPTIONS-}"
exec ctest --test-dir build-fuzz -j "$(nproc)" -R "^($names):[^ ]" -LE 'live|full' --output-on-failure --no-tests=error --progress
