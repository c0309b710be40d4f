#!/usr/bin/env bash
# Kills random processes of live prints at random moments, resumes each print until it is finished, checks audit and
# replay, and prints a line a print and a table of the victims.
#   tests/bench/random_kills.sh [N] [--seed S] [--victim NAME] [--lab inkjet|two_inks|watched|lines|camera_alone|ice|places] [--hardships]
# --hardships: a network that loses a tenth in half of the prints, a disk that stalls or fills in half of them.
# N prints (100) from seed S (1). A failed print is repeated by FIRN_KILL_SEED=its seed FIRN_KILLS=1.
set -uo pipefail
cd "$(dirname "$0")/../.."
prints=100 seed=1
while [ $# -gt 0 ]; do
  case $1 in
    --seed) seed=${2:?a number}; shift ;;
    --victim) export FIRN_KILL_VICTIM=${2:?a process}; shift ;;
    --hardships) export FIRN_KILL_HARDSHIPS=1 ;;
    --lab) export FIRN_KILL_LAB=${2:?a lab}; shift ;;
    [0-9]*) prints=$1 ;;
    *) echo "random_kills.sh: no option '$1'" >&2; exit 2 ;;
  esac
  shift
done
FIRN_KILL_SEED=$seed FIRN_KILLS=$prints build/tests/live_test '*quarter' | tee /dev/stderr | awk '
  /^seed / {
    ++prints
    resumes += $(NF - 3) - 1
    finished += $NF == 0
    for (n = 4; n <= NF - 4;)
      if ($n ~ /^(loss|stalled|full)$/) { ++with[$n]; ++n }
      else { ++kills; ++of[$n]; n += 3 }
  }
  /FAILED:/ { ++failed }
  END {
    printf "\n|process|kills|\n|-|-|\n"
    for (name in of) printf "|%s|%d|\n", name, of[name] | "sort"
    close("sort")
    for (name in with) printf "\n%s: %d prints", name, with[name]
    printf "\n%d prints, %d finished, %d kills, %d resumes, %d failed checks\n", prints, finished, kills, resumes, failed
    exit failed > 0 || finished < prints
  }'
