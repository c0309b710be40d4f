#!/bin/sh
# Processor time and wake-ups of a live print's processes, each by itself: while it prints, and while it is paused.
#   ./firn bench waiting [--seconds S] [--experiment FILE] [--firn PROGRAM]
# PROGRAM of another build is measured in the same way.
set -eu
exec python3 -B "$(dirname "$0")/waiting.py" "$@"
