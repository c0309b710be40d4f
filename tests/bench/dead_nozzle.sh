#!/bin/sh
# A nozzle that dies in the middle of a print, in the labs of five worlds: how many prints are stopped, and how soon.
# Options: tests/bench/dead_nozzle.py --help.
set -eu
exec python3 -B "$(dirname "$0")/dead_nozzle.py" "$@"
