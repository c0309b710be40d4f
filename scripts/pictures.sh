#!/usr/bin/env bash
# scripts/pictures.sh: the pictures of docs/images anew, in some minutes of processor time. Needs chromium, node and
# python3-matplotlib (`./firn test` installs them). Three come otherwise: loop.svg from scripts/draw_loop.py; spy.png from
# `./firn spy RUN --screenshot docs/images/spy.png` beside a print; ice-drift.png, days of processor time, from the page of
# `./firn compare experiments/studies/ice-drift.toml`.
set -euo pipefail
cd "$(dirname "$0")/.."
images=$PWD/docs/images
work=$(mktemp -d)
view=
trap 'rm -rf "$work"; [ -z "$view" ] || kill "$view"' EXIT
print() { # FOLDER ARGUMENT…; out of tolerance (4) and stopped safely (3) are pictures too
  ./firn print experiments/cylinder.toml --bus in-process --runs "$work/$1" "${@:2}" || [[ $? =~ ^[34]$ ]]
}
photograph() { # PAGE WIDTHxHEIGHT PICTURE [SCALE]
  chromium --headless --no-sandbox --hide-scrollbars --force-device-scale-factor="${4-1}" --window-size="${2/x/,}" \
    --screenshot="$images/$3" "file://$1"
}

# Figures of the papers, beside ours
for part in lu/identification lu/model-check lu/figs-11-12 lu/figs-13-15 barnett/motion barnett/pulses barnett/gains; do
  ./firn reproduce "${part%/*}" --only "${part#*/}" -o "$work/papers"
done
while read -r from to; do cp "$work/papers/$from.svg" "$images/$to.svg"; done <<'END'
lu-lu-identification-droplets identification
lu-model-check-side model-check
lu-fig11-side open-closed
lu-figs-13-14-sections two-inks
barnett-fig-4-4 mtts-stages
barnett-fig-6-2 pulses
barnett-fig-5-12 smf-poles
END

# Plans, slices, calibrations, searches
./firn plan experiments/thompson-fig7.json --machine labs/aerosol.toml --corner loop --plot "$images/aerosol.svg" -o "$work/fig7.traj"
./firn plan experiments/barnett-fig42.csv --machine labs/cobra600.toml --origin 354,-46 -o "$work/fig42.traj" \
  --plot "$work/fig42.svg"
photograph "$work/fig42.svg" 1340x1760 certified.png 0.75
scripts/make_mesh.py "$work/gear.stl"
./firn slice "$work/gear.stl" --config experiments/slicing/gear.toml -o "$work/gear.paths" --layer 4,10,20,36 \
  --png "$images/slice-gear.png"
./firn slice experiments/ice-helical-gear.stl -o "$work/helical.paths" --layer 40 --svg "$images/contours.svg"
./firn calibrate laser-offset labs/ice-cobra600.toml -o "$work/laser.toml" --plot "$images/calibrate-laser-offset.svg"
./firn calibrate jet labs/inkjet-lu2015.toml --velocity 2.5 -o "$work/jet.toml" --plot "$work/jet.svg"
photograph "$work/jet.svg" 900x400 calibrate-jet.png
./firn bench mpc_bench gap "$images/mpc-gap.svg"

# What cameras see, and printed lines
./firn bench strobe_pictures "$work"
mkdir "$work/found"
for state in joined free; do
  ./firn droplets "$work/$state.png" --scale 1 --picture "$work/found/$state.png"
done
./firn python scripts/draw_views.py "$work/found"

# Surfaces, the report, the page
./firn python scripts/draw_surfaces.py
for scheme in mpc open_loop smf; do
  print runs --set control.scheme=$scheme # the open loop ends out of tolerance
done
./firn report "$work"/runs/* -o "$work/report.html"
photograph "$work/report.html" 1200x1800 cylinder.png
print runs --fault "200 jet trip 3" --set run.name=clogged
runs=("$work"/runs/*)
python3 -B tests/web/web_test.py . install
./firn view "$work/runs" --json >"$work/said" &
view=$!
until [ -s "$work/said" ]; do sleep 0.2; done
address=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["url"])' "$work/said")
node web/test/pictures.mjs "$address" "$images" "${runs[0]##*/}" "${runs[1]##*/}" "${runs[3]##*/}"
