#!/usr/bin/env bash
# A first ./firn demo on an empty Debian 12, from the clone to the report, packages included: wall and processor time of each
# commit, in alternation. Needs root, debootstrap, a network and 6 GB in FOLDER, where chroots are made; apt goes the host's way.
#
#   tests/bench/demo_cold.sh FOLDER COMMIT... [--rounds N]
set -euo pipefail
usage() { sed -n '2,5s/^# \{0,1\}//p' "$0" >&2; exit 2; }

rounds=1 words=()
while (($#)); do
  case $1 in
    --rounds) rounds=${2-}; shift ;;
    -*) usage ;;
    *) words+=("$1") ;;
  esac
  shift
done
((${#words[@]} >= 2 && EUID == 0)) || usage
work=$(realpath "${words[0]}") commits=("${words[@]:1}")
source=$(dirname "$(readlink -f "$0")")/../..

trap 'rm -rf --one-file-system "$work/demo-cold"' EXIT
base=$work/empty-debian
if [[ ! -d $base ]]; then
  command -v debootstrap >/dev/null || { printf 'demo_cold: needs debootstrap\n' >&2; exit 2; }
  rm -rf --one-file-system "$base.new"
  "$source/scripts/fresh_machine.sh" make "$base.new"
  mv "$base.new" "$base"
fi

printf 'commit,wall_s,cpu_s,load_before,load_after\n'
for ((round = 0; round < rounds; ++round)); do
  for commit in "${commits[@]}"; do
    root=$work/demo-cold
    cp -a "$base" "$root"
    git clone -q --no-hardlinks "$source" "$root/firn"
    git -C "$root/firn" -c advice.detachedHead=false checkout -q "$commit"
    before=$(cut -d' ' -f1 /proc/loadavg)
    TIMEFORMAT='%R %U %S'
    took=$({ time "$source/scripts/fresh_machine.sh" run "$root" /firn/firn demo >"$work/$commit.out" 2>"$work/$commit.err"; } 2>&1) || {
      tail -n 20 "$work/$commit.err" >&2
      exit 1
    }
    awk -v c="$commit" -v b="$before" -v a="$(cut -d' ' -f1 /proc/loadavg)" \
      '{ printf "%s,%.0f,%.0f,%s,%s\n", c, $1, $2 + $3, b, a }' <<<"$took"
    rm -rf --one-file-system "$root"
  done
done
