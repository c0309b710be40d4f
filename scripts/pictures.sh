#!/usr/bin/env bash
# scripts/pictures.sh: pictures of docs/images anew: surfaces.png, which the README begins with; cylinder.png, the report of a
# cylinder under three schemes as a browser shows it; certified.png, the plan of Fig. 4-2's path; those of docs/page.md, with a
# fourth print whose nozzle dies; slice-gear.png, four layers of a gear.
set -euo pipefail
cd "$(dirname "$0")/.."
work=$(mktemp -d)
view=
trap 'rm -rf "$work"; [ -z "$view" ] || kill "$view"' EXIT
print() { # FOLDER ARGUMENT…; out of tolerance (4) and stopped safely (3) are pictures too
  ./firn print experiments/cylinder.toml --bus in-process --runs "$work/$1" "${@:2}" || [[ $? =~ ^[34]$ ]]
}
./firn python scripts/draw_surfaces.py
for scheme in mpc open_loop smf; do
  print runs --set control.scheme=$scheme # the open loop ends out of tolerance
done
./firn report "$work"/runs/* -o "$work/report.html"
chromium --headless --no-sandbox --hide-scrollbars --window-size=1200,1800 \
  --screenshot="$PWD/docs/images/cylinder.png" "file://$work/report.html"

./firn plan experiments/barnett-fig42.csv --machine labs/cobra600.toml --origin 354,-46 -o "$work/fig42.traj" \
  --plot "$work/fig42.svg"
chromium --headless --no-sandbox --hide-scrollbars --force-device-scale-factor=0.75 --window-size=1340,1760 \
  --screenshot="$PWD/docs/images/certified.png" "file://$work/fig42.svg"

scripts/make_mesh.py "$work/gear.stl"
./firn slice "$work/gear.stl" --config experiments/slicing/gear.toml -o "$work/gear.paths" --layer 4,10,20,36 \
  --png docs/images/slice-gear.png

print runs --fault "200 jet trip 3" --set run.name=clogged
runs=("$work"/runs/*)
python3 -B tests/web/web_test.py . install
./firn view "$work/runs" --json >"$work/said" &
view=$!
until [ -s "$work/said" ]; do sleep 0.2; done
address=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["url"])' "$work/said")
node web/test/pictures.mjs "$address" docs/images "${runs[0]##*/}" "${runs[1]##*/}" "${runs[3]##*/}"
