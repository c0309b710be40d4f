#!/usr/bin/env bash
# Builds and tests this source tree on an empty Debian of another release, or of this one. Needs root, debootstrap and a package
# source (scripts/fresh_machine.sh); exits with 3 where no such machine can be had.
#
#   scripts/try_debian.sh RELEASE FOLDER [--build TARGET]... [--test ROOM]...
#       RELEASE: bookworm or trixie. FOLDER: the machine, made there unless it is there, and kept. Without --build: everything, and
#       all tests. --build: these targets alone, then a print, its replay and an export by them; --test: tests of these rooms.
#       It says which libraries the programs are linked with or open, and their versions.
set -euo pipefail
usage() { sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "$0" >&2; exit 2; }
say() { printf 'try_debian: %s\n' "$*" >&2; }

root=$(dirname "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")")
machine_of=$root/scripts/fresh_machine.sh
(($# >= 2)) || usage
release=$1 machine=$2
shift 2
targets=() rooms=()
while (($#)); do
  (($# > 1)) || usage
  case $1 in
    --build) targets+=("$2") ;;
    --test) rooms+=("$2") ;;
    *) usage ;;
  esac
  shift 2
done

[[ -x $machine/bin/sh ]] || "$machine_of" make "$machine" "$release"
machine=$(realpath "$machine")
codename=$(sed -n 's/^VERSION_CODENAME=//p' "$machine/etc/os-release")
[[ $codename == "$release" ]] || { say "$machine is a $codename, not a $release"; exit 2; }

# The files of the tree as they are, also those that are not committed yet, with the repository that names the commit.
say "copying the sources"
mkdir -p "$machine/firn"
find "$machine/firn" -mindepth 1 -maxdepth 1 ! -name build -exec rm -rf {} +
(cd "$root" && git ls-files -z --cached --others --exclude-standard | xargs -0 sh -c 'for f; do [ ! -e "$f" ] || printf "%s\0" "$f"; done' sh |
  tar --null -T - -cf -) | tar -C "$machine/firn" -xf -
git clone -q --bare "$root" "$machine/firn/.git"
git -C "$machine/firn" config core.bare false
git -C "$machine/firn" reset -q

inside() { "$machine_of" run "$machine" -- bash -ec "cd /firn; git config --global --replace-all safe.directory /firn; $1"; }

sections="demo build test spy python droplets"  # the tests are configured whatever is built
((${#targets[@]} + ${#rooms[@]})) || sections+=" package"
say "installing packages: $sections"
"$machine_of" run "$machine" -- sh -ec "apt-get -qq update
  command -v git >/dev/null || apt-get -qq install -y --no-install-recommends git ca-certificates >/dev/null"
inside "source <(sed -n '/^say()/,/^# Plain progress/p' firn); root=/firn; package_list=/firn/scripts/packages.txt
  install_packages $sections; unpack_headers"

say "building"
if ((${#targets[@]} + ${#rooms[@]} == 0)); then
  inside "./firn test"
else
  inside "[ -f build/build.ninja ] || cmake --preset default >/dev/null; ninja -C build ${targets[*]} ${rooms[*]/#/test_}"
  for room in "${rooms[@]}"; do inside "ctest --test-dir build -L '^$room' --output-on-failure"; done
fi

say "what the programs need on $release"
inside 'dpkg-query -W -f "\${Package} \${Version}\n" "libsundials-cvode*" "libhdf5-*" "catch2" "libopencv-core*" "g++" "libsleef*" 2>/dev/null | grep -v " $"
  ldd build/bin/firn | sed -n "s/ => .*//p" | sort
  grep -haoE "libhdf5_serial(_hl)?\.so\.[0-9]+" build/bin/firn | sort -u'
inside 'build/bin/firn print experiments/cuboid.toml --bus in-process --set part.height_mm=0.02 --runs /tmp/runs >/dev/null
  run=$(ls -d /tmp/runs/* | tail -n 1); build/bin/firn replay "$run"; build/bin/firn export "$run" -o /tmp/run.h5; rm -r /tmp/runs /tmp/run.h5'
say "$release: done"
