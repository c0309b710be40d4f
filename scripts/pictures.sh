#!/usr/bin/env bash
# scripts/pictures.sh: docs/images/cylinder.png anew, the report of a cylinder under three schemes as a browser shows it.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for scheme in mpc open_loop smf; do
  ./firn print experiments/cylinder.toml --bus in-process --set control.scheme=$scheme --runs "$work/runs" ||
    [ $? = 4 ] # the open loop ends out of tolerance
done
./firn report "$work"/runs/* -o "$work/report.html"
chromium --headless --no-sandbox --hide-scrollbars --window-size=1200,1800 \
  --screenshot="$PWD/docs/images/cylinder.png" "file://$work/report.html"
