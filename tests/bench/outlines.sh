#!/bin/sh
# Prints of fresh outlines by every feedback scheme, at 1 um of noise a point and 1 um a cell: which stop, which end out of
# tolerance, RMS of the true surface. Options: tests/bench/outlines.py --help. The whole bench (40 outlines, 10 seeds) takes
# hours; --outlines 5 --seeds 1 takes minutes.
set -eu
exec python3 -B "$(dirname "$0")/outlines.py" "$@"
