#!/bin/sh
# Processor time and memory of all that is done with a long run of the ink-jet lab: see long_run.py.
#   ./firn bench long_run [--layers N[,N…]] [--rows WORD,…] [--rounds N] [--against PROGRAM] [--cells N]
set -eu
exec python3 -B "$(dirname "$0")/long_run.py" "$@"
