#!/bin/sh
# Live prints beside a busy computer's other work: how many end as they do on an idle one.
#   ./firn bench busy [--prints N] [--load PER_CORE] [--stress 'OPTIONS'] [--experiment FILE] [--firn PROGRAM]
# Needs stress-ng. The prints take the priority that limits.conf allows them (docs/safety.md).
set -eu
exec python3 -B "$(dirname "$0")/busy.py" "$@"
