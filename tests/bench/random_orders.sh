#!/usr/bin/env bash
# Random sequences of the operator's orders, kills, SIGSTOP and SIGCONT, SIGHUP and full disks on live prints; a line a
# print and a table of the disturbances.
#   ./firn bench random_orders [N] [--seed S]
# N prints (50) from seed S (1). A failed print is repeated by FIRN_ORDER_SEED=its seed FIRN_ORDERS=1.
set -uo pipefail
cd "$(dirname "$0")/../.."
prints=50 seed=1
while [ $# -gt 0 ]; do
  case $1 in
    --seed) seed=${2:?a number}; shift ;;
    [0-9]*) prints=$1 ;;
    *) echo "random_orders.sh: no option '$1'" >&2; exit 2 ;;
  esac
  shift
done
FIRN_ORDER_SEED=$seed FIRN_ORDERS=$prints build/tests/live_test 'a print under random orders*' | tee /dev/stderr | awk -F '  ' '
  /^seed / {
    ++prints
    finished += $NF ~ /status 0$/
    split($NF, words, " ")
    resumes += words[1] - 1
    for (n = 2; n < NF; ++n) {
      name = $n
      sub(/=.*/, "", name)
      ++of[name]
    }
  }
  /FAILED:/ { ++failed }
  END {
    printf "\n|disturbance|times|\n|-|-|\n"
    for (name in of) printf "|%s|%d|\n", name, of[name] | "sort"
    close("sort")
    printf "\n%d prints, %d finished, %d resumes, %d failed checks\n", prints, finished, resumes, failed
    exit failed > 0 || finished < prints
  }'
