#!/bin/sh
# firn slice against the slicers people use: whole commands, user and wall seconds, medians of 3 alternating runs.
#   bench/slicing_peers.sh MESHES [ROUNDS]
# MESHES holds igea_1075k.stl, lucy500_1215k.stl and perhaps lucy500_10140k.stl. Needs root once, to install Debian's
# prusa-slicer, cura-engine and slic3r; Cura's definitions come out of its package, which is not installed. Settings as
# near as they allow: layers of 0.25 mm, width 1.5 mm, one outline, concentric infill of 100 %, no skirt; a run writes
# G-code. PrusaSlicer runs its classic perimeter generator, 2.7 times faster here than its default (Arachne). Wants a quiet machine. Prints Markdown.
set -eu
meshes=$(cd "${1:?usage: bench/slicing_peers.sh MESHES [ROUNDS]}" && pwd)
rounds=${2:-3}
cd "$(dirname "$0")/.."
firn=${FIRN:-build/bin/firn}
work=build/slicing_peers
mkdir -p "$work"
out=$(cd "$work" && pwd)

for package in prusa-slicer cura-engine slic3r; do
  dpkg -s "$package" >/dev/null 2>&1 || apt-get install -y --no-install-recommends "$package" >&2
done
cura=$out/cura/usr/share/cura/resources/definitions
if [ ! -f "$cura/fdmprinter.def.json" ]; then
  (cd "$out" && apt-get download cura >&2 && dpkg -x cura_*.deb cura && rm cura_*.deb)
fi

prusa="prusa-slicer --export-gcode --layer-height 0.25 --first-layer-height 0.25 --nozzle-diameter 1.5 --extrusion-width 1.5 \
  --perimeters 1 --perimeter-generator classic --fill-pattern concentric --fill-density 100% --top-fill-pattern concentric --bottom-fill-pattern concentric \
  --skirts 0 --brim-width 0 --bed-shape 0x0,600x0,600x600,0x600 --center 300,300 --max-print-height 600"
slic3r="slic3r --layer-height 0.25 --first-layer-height 0.25 --nozzle-diameter 1.5 --extrusion-width 1.5 --first-layer-extrusion-width 1.5 \
  --perimeters 1 --fill-pattern concentric --fill-density 100% --top-infill-pattern concentric --bottom-infill-pattern concentric \
  --skirts 0 --brim-width 0 --bed-shape 0x0,600x0,600x600,0x600 --print-center 300,300"
engine="CuraEngine slice -j $cura/fdmprinter.def.json -s layer_height=0.25 -s layer_height_0=0.25 -s line_width=1.5 -s wall_line_width_0=1.5 \
  -s wall_line_width=1.5 -s wall_line_count=1 -s infill_line_width=1.5 -s skin_line_width=1.5 -s infill_pattern=concentric \
  -s infill_line_distance=1.5 -s infill_sparse_density=100 -s top_layers=0 -s bottom_layers=0 -s adhesion_type=none \
  -s machine_nozzle_size=1.5 -s machine_width=600 -s machine_depth=600 -s machine_height=600"
# Firn's own fill is 3 mm wide by default; against the others it is 1.5 mm.
ours="--set part.fill_width_mm=1.5 --set scaffold.fill_width_mm=1.5 --set part.first_offset_mm=0.75"

command_of() {  # NAME MESH
  case $1 in
    prusa) echo "$prusa -o $out/prusa.gcode $2" ;;
    prusa-support) echo "$prusa --support-material --support-material-spacing 0 --support-material-extrusion-width 1.5 -o $out/prusa.gcode $2" ;;
    slic3r) echo "$slic3r -o $out/slic3r.gcode $2" ;;
    cura) echo "$engine -s support_enable=false -l $2 -o $out/cura.gcode" ;;
    cura-support) echo "$engine -s support_enable=true -s support_infill_rate=100 -s support_line_width=1.5 -s support_line_distance=1.5 -l $2 -o $out/cura.gcode" ;;
    firn-*-support) tolerance=${1#firn-}; echo "$firn slice $2 --support full --tolerance ${tolerance%-support} --gcode $out/firn.gcode $ours" ;;
    firn-*) echo "$firn slice $2 --support none --tolerance ${1#firn-} --gcode $out/firn.gcode $ours" ;;
    all-*) echo "$firn slice $2 --support full --tolerance ${1#all-} -o $out/firn.paths" ;;
    contours-*) echo "$firn slice $2 --support none --tolerance ${1#contours-} --set part.fill=none" ;;
  esac
}

run() {  # NAME MESH -> appends "user wall MiB" to a file of its own
  # shellcheck disable=SC2046
  if CURA_ENGINE_SEARCH_PATH=$cura /usr/bin/time -f "%U %S %e %M" -o "$out/time" $(command_of "$1" "$2") >"$out/log" 2>&1; then
    awk '{printf "%.2f %.2f %.2f %.0f\n", $1, $2, $3, $4 / 1024}' "$out/time" | tail -n 1 >>"$out/$(basename "$2")-$1.runs"
  else
    echo "$1 failed on $2: $(tail -n 1 "$out/log" | cut -c 1-200)" >&2
    echo "failed failed failed failed" >>"$out/$(basename "$2")-$1.runs"
  fi
}

median() {  # FILE COLUMN
  cut -d ' ' -f "$2" "$1" | sort -n | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

table() {  # TITLE MESH NAMES...
  title=$1 mesh=$meshes/$2
  shift 2
  if [ ! -f "$mesh" ]; then
    echo "no $mesh: left out" >&2
    return
  fi
  for name in "$@"; do rm -f "$out/$(basename "$mesh")-$name.runs"; done
  n=0
  while [ "$n" -lt "$rounds" ]; do
    for name in "$@"; do
      echo "$title: $name, round $((n + 1)) of $rounds" >&2
      run "$name" "$mesh"
    done
    n=$((n + 1))
  done
  printf '\n**%s** (%s)\n\n| command | user s | system s | wall s | MiB |\n|---|---|---|---|---|\n' "$title" "$(basename "$mesh")"
  for name in "$@"; do
    file=$out/$(basename "$mesh")-$name.runs
    printf '| %s | %s | %s | %s | %s |\n' "$name" "$(median "$file" 1)" "$(median "$file" 2)" "$(median "$file" 3)" "$(median "$file" 4)"
  done
}

table "No support, G-code written" lucy500_1215k.stl firn-0.05 prusa cura slic3r firn-0.01 firn-0
table "No support, G-code written" igea_1075k.stl firn-0.05 prusa cura slic3r firn-0.01 firn-0
table "Full scaffold, both filled, G-code written" lucy500_1215k.stl firn-0.05-support prusa-support cura-support firn-0.01-support firn-0-support
table "All stages of Table 3-5, path file written" igea_1075k.stl all-0.05 all-0.01 all-0
table "STL to outlines" igea_1075k.stl contours-0.05
table "All stages, path file written" lucy500_10140k.stl all-0.05 prusa
