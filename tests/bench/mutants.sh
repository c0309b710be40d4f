#!/bin/sh
# Changes one operator, constant or statement of the product at a time, and shows which changes no test of its room notices.
#   ./firn bench mutants N [--seed S] [--rooms ROOM,…] [--json FILE]
# A mutant takes a compilation and its room's tests: a minute or two. docs: CONTRIBUTING.md.
set -eu
exec python3 -B "$(dirname "$0")/mutants.py" "$@"
