#!/bin/sh
# False stops of the interlocks: the shipped experiments of the three labs at their shipped noises, by seed, none of whose
# instruments has a fault. Options: tests/bench/false_stops.py --help.
set -eu
exec python3 -B "$(dirname "$0")/false_stops.py" "$@"
