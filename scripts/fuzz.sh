#!/bin/sh
# Builds the libFuzzer targets of tests/fuzz with clang++ in build-fuzz/ and runs each for SECONDS (default 30), or all
# together until they have read N inputs: an equal share each, and the rest of a target that has not come through its
# share in FIRN_FUZZ_SECONDS (default 600) is shared out among the others.
#   scripts/fuzz.sh [SECONDS] [TARGET...]
#   scripts/fuzz.sh --inputs N [TARGET...]
#   scripts/fuzz.sh --each N [TARGET...]
# --each reads N inputs of each target (N / 20 of slow ones), from the seeds alone: the same effort on any machine.
# FIRN_FUZZ_SEED=N starts from the same random numbers every time; without it each run looks elsewhere.
# The build joins sources, which the compiler parses in half of the time; scripts/check_names.py and scripts/check_includes.py
# look at them one by one.
# FIRN_FUZZ_JOBS=N runs so many targets side by side (default 1); FIRN_FUZZ_BUILT=1 takes the targets as they are.
# What is found stays in build-fuzz/found/; the corpus grows in build-fuzz/corpus/.
set -eu
cd "$(dirname "$0")/.."
inputs= each= corpus=build-fuzz/corpus slow="fuzz_slice fuzz_valve_firmware fuzz_restore fuzz_experiment fuzz_config_message fuzz_droplets fuzz_line_picture fuzz_layer_record fuzz_study_journal fuzz_paths"
if [ "${1:-}" = --inputs ]; then
  inputs=${2:?"--inputs needs a number"}
  shift 2
elif [ "${1:-}" = --each ]; then
  each=${2:?"--each needs a number"}
  shift 2
else
  seconds=${1:-30}
  [ $# -gt 0 ] && shift
fi
targets=${*:-"fuzz_record_file fuzz_packed fuzz_event_log fuzz_messages fuzz_type_texts fuzz_npy fuzz_transport fuzz_instruments fuzz_ice_codecs fuzz_valve_firmware fuzz_heater_firmware fuzz_experiment fuzz_study fuzz_machine fuzz_paths fuzz_trajectory fuzz_mesh fuzz_path_file fuzz_slice fuzz_write_ahead fuzz_restore fuzz_config_message fuzz_vplus fuzz_world_record fuzz_world_state fuzz_run_documents fuzz_png fuzz_3mf fuzz_study_journal fuzz_layer_record fuzz_lcm_packet fuzz_print_queue fuzz_relay fuzz_own_message fuzz_device_lines fuzz_cassette fuzz_client_frame fuzz_droplets fuzz_line_picture"}

if [ -z "${FIRN_FUZZ_BUILT:-}" ]; then
  cmake --preset fuzz >/dev/null
  ninja -C build-fuzz fuzz_seeds $targets >build-fuzz/build.log || { grep -A 8 -E "^FAILED|error:|fatal" build-fuzz/build.log | cut -c1-400 | head -n 60; exit 1; }
fi
if [ -n "$each" ]; then
  corpus=$(mktemp -d)
  trap 'rm -rf "$corpus"' EXIT
  trap 'exit 130' INT TERM
fi
build-fuzz/fuzz/fuzz_seeds "$corpus"
mkdir -p build-fuzz/found

# One target: its row goes to found/TARGET.row, with the inputs and hours of earlier rounds added.
fuzz_one='
  target=$1 found=build-fuzz/found
  begin=$(date +%s)
  result=nothing
  if [ -n "$each" ]; then
    case " $slow " in *" $target "*) limit="-runs=$((each / 20))" ;; *) limit="-runs=$each" ;; esac
  fi
  build-fuzz/fuzz/"$target" $limit -seed="${FIRN_FUZZ_SEED:-0}" -max_len=4096 -timeout=10 -rss_limit_mb=2048 \
    -print_final_stats=1 -artifact_prefix="$found/$target-" "$corpus/$target" \
    >"$found/$target.log" 2>&1 || result=FAILED
  runs=$(sed -n "s/^stat::number_of_executed_units: *//p" "$found/$target.log" | tail -n 1)
  [ -f "$found/$target.row" ] || echo "$target 0 0 nothing" >"$found/$target.row"
  awk -v n="${runs:-0}" -v s="$(($(date +%s) - begin))" -v r="$result" \
    "{ printf \"%-22s %11d %9.4f  %s\\n\", \$1, \$2 + n, \$3 + s / 3600, r == \"FAILED\" ? r : \$4 }" \
    "$found/$target.row" >"$found/$target.new"
  mv "$found/$target.new" "$found/$target.row"
  cat "$found/$target.row"
  if [ "$result" = FAILED ]; then tail -n 40 "$found/$target.log"; fi
  if [ "$result" = nothing ] && [ "${runs:-0}" -ge "${share:-1}" ]; then echo "$target" >>"$found/in_time"; fi
'
fuzz_all() {
  rm -f build-fuzz/found/in_time
  export limit share each slow corpus FIRN_FUZZ_SEED
  printf '%s\n' $1 | xargs -P "${FIRN_FUZZ_JOBS:-1}" -I TARGET sh -c "$fuzz_one" fuzz TARGET
}
made() { cat build-fuzz/found/*.row | awk '{ n += $2 } END { printf "%d", n }'; }

rm -f build-fuzz/found/*.row
printf '%-22s %11s %9s  %s\n' target inputs hours found
if [ -n "$inputs" ]; then
  left=$inputs list=$targets
  while [ "$left" -gt 0 ] && [ -n "$list" ]; do
    set -- $list
    share=$(((left + $# - 1) / $#))
    limit="-runs=$share -max_total_time=${FIRN_FUZZ_SECONDS:-600}"
    fuzz_all "$list"
    left=$((inputs - $(made)))
    list=$(cat build-fuzz/found/in_time 2>/dev/null || true)
  done
else
  [ -n "$each" ] || limit="-max_total_time=$seconds"
  fuzz_all "$targets"
fi
cat build-fuzz/found/*.row | awk '{ n += $2; h += $3; bad += $4 == "FAILED" }
  END { printf "%-22s %11d %9.4f  %s\n", "total", n, h, bad ? bad " targets FAILED" : "nothing"; exit bad > 0 }'
