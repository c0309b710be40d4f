#!/bin/sh
# Certified layers with a price of ink beside the part: the gap that is proved, and its processor time, on layers drawn from a
# print of experiments/cylinder.toml.
#   ./firn bench layer_gaps [--layers N] [--seed S] [--firn PROGRAM]
# Needs numpy (./firn python installs it).
set -eu
exec /usr/bin/python3 -B "$(dirname "$0")/layer_gaps.py" "$@"
