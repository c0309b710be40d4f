#!/bin/sh
# Planning time with the exact trigonometry of core/exact over that with glibc's, which differs between CPUs.
#   ./firn bench exact_planning [ROUNDS = 15]
exec python3 -B "$(dirname "$0")/exact_planning.py" "$@"
