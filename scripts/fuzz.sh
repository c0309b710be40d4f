#!/bin/sh
# Builds the libFuzzer targets of tests/fuzz with clang++ in build-fuzz/ and runs each for SECONDS (default 30).
#   scripts/fuzz.sh [SECONDS] [TARGET...]
# FIRN_FUZZ_SEED=N starts from the same random numbers every time; without it each run looks elsewhere.
# What is found stays in build-fuzz/found/; the corpus grows in build-fuzz/corpus/.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-30}
[ $# -gt 0 ] && shift
targets=${*:-"fuzz_record_file fuzz_event_log fuzz_messages fuzz_type_texts fuzz_npy fuzz_transport fuzz_instruments fuzz_ice_codecs fuzz_experiment fuzz_study fuzz_machine fuzz_paths fuzz_trajectory fuzz_mesh fuzz_path_file fuzz_slice"}

cmake -G Ninja -S . -B build-fuzz -DCMAKE_CXX_COMPILER=clang++ -DFIRN_FUZZ=ON \
  -DFIRN_SANITIZE=fuzzer-no-link,address,undefined >/dev/null
ninja -C build-fuzz fuzz_seeds $targets >build-fuzz/build.log || { grep -v "^\\[" build-fuzz/build.log | head -n 60; exit 1; }
build-fuzz/fuzz/fuzz_seeds build-fuzz/corpus
mkdir -p build-fuzz/found
failed=0
for target in $targets; do
  if build-fuzz/fuzz/"$target" -max_total_time="$seconds" -seed="${FIRN_FUZZ_SEED:-0}" -max_len=4096 -timeout=10 -rss_limit_mb=2048 \
      -print_final_stats=1 -artifact_prefix="build-fuzz/found/$target-" "build-fuzz/corpus/$target" \
      >"build-fuzz/found/$target.log" 2>&1; then
    runs=$(sed -n 's/^stat::number_of_executed_units: *//p' "build-fuzz/found/$target.log")
    echo "$target: $runs runs in $seconds s, nothing found"
  else
    echo "$target: FAILED"
    tail -n 40 "build-fuzz/found/$target.log"
    failed=1
  fi
done
exit $failed
