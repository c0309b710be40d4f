#!/bin/sh
# firn slice against the slicers people use: whole commands, user and wall seconds, medians of alternating runs.
#   tests/bench/slicing_peers.sh MESHES [--row NAME]... [--command NAME]... [--rounds N] [--ours]
# MESHES holds igea_1075k.stl, lucy500_1215k.stl and lucy500_10140k.stl (rows whose mesh is missing are left out). Rows, with
# the minutes that three rounds take on a quiet machine of two cores:
#   lucy        no support, G-code                        8      stages    igea, all stages of Table 3-5           0.2
#   igea        no support, G-code                        4      linked    igea, STL to linked contours            0.1
#   scaffold    lucy, full scaffold, both filled, G-code  12     large     lucy of 10 million facets, all stages   11
#                                                                threads   lucy, all stages, one and two threads   1
# --ours runs Firn alone (needs nothing installed; 6 minutes for all rows). Firn's figures stand at chord tolerances of 0.05
# (a thirtieth of the path's width), 0.01 and 0 mm (every point kept: slow, one round only). firn-beads lays beads in gaps
# too, as `firn slice` does unless told otherwise; Table 3-5 has none. A command that takes more than LIMIT_S seconds (900)
# is stopped. --command keeps some of the rows' commands, by their names in the table: 31 rounds of one of them tell how much a
# shared machine's figures differ from minute to minute.
# Peers: Debian's prusa-slicer, cura-engine and slic3r, installed once as root; Cura's definitions come out of its package,
# which is not installed. Settings as near as they allow: layers of 0.25 mm, width 1.5 mm, one outline, concentric infill of
# 100 %, no skirt; a run writes G-code. PrusaSlicer runs its classic perimeter generator, 2.7 times faster here than its
# default (Arachne). Prints Markdown; progress on stderr.
set -eu

usage() {
  sed -n '2,14s/^# \{0,1\}//p' "$0" >&2
  exit 2
}
meshes='' rows='' commands='' rounds=3 ours=no ran=''
while [ $# -gt 0 ]; do
  case $1 in
    --row) rows="$rows ${2:?--row wants a name}"; shift 2 ;;
    --command) commands="$commands ${2:?--command wants a name}"; shift 2 ;;
    --rounds) rounds=${2:?--rounds wants a number}; shift 2 ;;
    --ours) ours=yes; shift ;;
    -*) usage ;;
    *) meshes=$1; shift ;;
  esac
done
[ -d "$meshes" ] || usage
for row in $rows; do
  case $row in lucy | igea | scaffold | stages | linked | large | threads) ;; *) echo "no row '$row'" >&2; usage ;; esac
done
meshes=$(cd "$meshes" && pwd)
cd "$(dirname "$0")/.."
firn=${FIRN:-build/bin/firn}
limit_s=${LIMIT_S:-900}
work=build/slicing_peers
mkdir -p "$work"
out=$(cd "$work" && pwd)
cura=$out/cura/usr/share/cura/resources/definitions

install_peers() {
  for package in prusa-slicer cura-engine slic3r; do
    dpkg -s "$package" >/dev/null 2>&1 || apt-get install -y --no-install-recommends "$package" >&2
  done
  if [ ! -f "$cura/fdmprinter.def.json" ]; then
    (cd "$out" && apt-get download cura >&2 && dpkg -x cura_*.deb cura && rm cura_*.deb)
  fi
}

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
narrow="--set part.fill_width_mm=1.5 --set scaffold.fill_width_mm=1.5 --set part.first_offset_mm=0.75"
# The stages of Table 3-5: boundaries and fill, no beads where rings leave spots between them.
rings="--set part.gap_mm=0 --set scaffold.gap_mm=0"

command_of() {  # NAME MESH
  case $1 in
    prusa) echo "$prusa -o $out/prusa.gcode $2" ;;
    prusa-support) echo "$prusa --support-material --support-material-spacing 0 --support-material-extrusion-width 1.5 -o $out/prusa.gcode $2" ;;
    slic3r) echo "$slic3r -o $out/slic3r.gcode $2" ;;
    cura) echo "$engine -s support_enable=false -l $2 -o $out/cura.gcode" ;;
    cura-support) echo "$engine -s support_enable=true -s support_infill_rate=100 -s support_line_width=1.5 -s support_line_distance=1.5 -l $2 -o $out/cura.gcode" ;;
    firn-none-*) echo "$firn slice $2 --support none --tolerance ${1#firn-none-} --gcode $out/firn.gcode $narrow" ;;
    firn-full-*) echo "$firn slice $2 --support full --tolerance ${1#firn-full-} --gcode $out/firn.gcode $narrow" ;;
    firn-stages-*) echo "$firn slice $2 --support full --threads 1 --tolerance ${1#firn-stages-} $rings -o $out/firn.paths" ;;
    firn-beads-*) echo "$firn slice $2 --support full --threads 1 --tolerance ${1#firn-beads-} -o $out/firn.paths" ;;
    firn-threads-*) threads=${1#firn-threads-}
      echo "$firn slice $2 --support full --threads ${threads%%-*} --tolerance ${threads#*-} -o $out/firn.paths" ;;
    firn-linked-*) echo "build/bench/slice_stages $2 ${1#firn-linked-} 1" ;;
  esac
}

run() {  # NAME MESH -> appends "user system wall MiB" to a file of its own
  file=$out/$(basename "$2")-$1.runs
  # shellcheck disable=SC2046
  if CURA_ENGINE_SEARCH_PATH=$cura timeout "$limit_s" /usr/bin/time -f "%U %S %e %M" -o "$out/time" $(command_of "$1" "$2") >"$out/log" 2>&1; then
    case $1 in
      # Processor time of one stage within the command: user and system in one.
      firn-linked-*) sed -n 's/.*read to linked *median \([0-9.]*\) s.*/\1 0 \1 0/p' "$out/log" >>"$file" ;;
      *) awk 'END {printf "%.2f %.2f %.2f %.0f\n", $1, $2, $3, $4 / 1024}' "$out/time" >>"$file" ;;
    esac
  else
    echo "$1 failed or took more than $limit_s s on $2: $(tail -n 1 "$out/log" | cut -c 1-200)" >&2
    echo "failed failed failed failed" >>"$file"
  fi
}

median() {  # FILE COLUMN
  cut -d ' ' -f "$2" "$1" | sort -n | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

spread() {  # FILE COLUMN
  cut -d ' ' -f "$2" "$1" | sort -n | sed -n '1p;$p' | paste -s -d ' ' | sed 's/ / to /'
}

table() {  # ROW TITLE MESH NAMES...
  case " ${rows:-$1} " in *" $1 "*) ;; *) return 0 ;; esac
  row=$1 title=$2 mesh=$meshes/$3
  shift 3
  if [ ! -f "$mesh" ]; then
    echo "no $mesh: row $row is left out" >&2
    return 0
  fi
  names=''
  for name in "$@"; do
    case " ${commands:-$name} " in *" $name "*) ;; *) continue ;; esac
    case $ours-$name in yes-firn-* | no-*) names="$names $name" ;; esac
  done
  [ -n "$names" ] || return 0
  ran="$ran$names"
  case $names in *prusa* | *cura* | *slic3r*) install_peers ;; esac
  for name in $names; do rm -f "$out/$(basename "$mesh")-$name.runs"; done
  n=0
  while [ "$n" -lt "$rounds" ]; do
    n=$((n + 1))
    for name in $names; do
      case $n-$name in 1-*) ;; *-0) continue ;; esac
      echo "$row: $name, round $n of $rounds" >&2
      run "$name" "$mesh"
    done
  done
  printf '\n**%s: %s** (%s, medians of %s)\n\n' "$row" "$title" "$(basename "$mesh")" "$rounds"
  printf '| command | user s | least to most | system s | wall s | MiB | user by Firn'\''s | wall by Firn'\''s |\n|---|---|---|---|---|---|---|---|\n'
  base='' base_wall=''
  for name in $names; do
    file=$out/$(basename "$mesh")-$name.runs
    user=$(median "$file" 1) wall=$(median "$file" 3)
    : "${base:=$user}" "${base_wall:=$wall}"
    ratios=$(echo "$user $base $wall $base_wall" | awk '{if ($1 + 0 > 0 && $2 + 0 > 0) printf "%.2f | %.2f", $1 / $2, $3 / $4; else printf "- | -"}')
    printf '| %s | %s | %s | %s | %s | %s | %s |\n' "$name" "$user" "$(spread "$file" 1)" "$(median "$file" 2)" "$wall" "$(median "$file" 4)" "$ratios"
  done
}

echo "Firn's last word is its chord tolerance in mm. $(nproc) cores, $(date -u +%F), load $(cut -d ' ' -f 1 /proc/loadavg)."
table lucy "no support, G-code written" lucy500_1215k.stl firn-none-0.05 prusa cura slic3r firn-none-0.01 firn-none-0
table igea "no support, G-code written" igea_1075k.stl firn-none-0.05 prusa cura slic3r firn-none-0.01 firn-none-0
table scaffold "full scaffold, both materials filled, G-code written" lucy500_1215k.stl firn-full-0.05 prusa-support cura-support firn-full-0.01 firn-full-0
table stages "all stages of Table 3-5, one thread, path file written" igea_1075k.stl firn-stages-0.05 firn-beads-0.05 firn-stages-0.01 firn-stages-0
table linked "STL to linked contours, one thread, processor time" igea_1075k.stl firn-linked-0.05 firn-linked-0.01 firn-linked-0
table large "all stages, one thread, path file written; PrusaSlicer without support" lucy500_10140k.stl firn-stages-0.05 firn-beads-0.05 prusa firn-stages-0.01 firn-stages-0
table threads "all stages, one and two threads" lucy500_1215k.stl firn-threads-1-0.05 firn-threads-2-0.05 \
  firn-threads-1-0.01 firn-threads-2-0.01 firn-threads-1-0 firn-threads-2-0
[ -n "$ran" ] || { echo "nothing to run: no mesh, or no command$commands in these rows" >&2; exit 2; }
for name in $commands; do
  case " $ran " in *" $name "*) ;; *) echo "no command '$name' in the rows that ran" >&2; exit 2 ;; esac
done
