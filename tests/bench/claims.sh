#!/bin/sh
# The rows of docs/measurements.md again, each beside its claim: see claims.py.
#   ./firn bench claims [WORD…] [--within RATIO]     # WORDs: rows whose figure has one of them; default: all that are run
set -eu
exec python3 -B "$(dirname "$0")/claims.py" "$@"
