#!/bin/sh
# firn slice against the slicers people use: whole commands on one core, user + system seconds, medians of alternating runs.
#   tests/bench/slicing_peers.sh MESHES [--row NAME]... [--command NAME]... [--rounds N] [--ours] [--keep FILE]
# MESHES holds igea_1075k.stl, lucy500_1215k.stl and lucy500_10140k.stl (rows whose mesh is missing are left out). Rows, with
# the minutes that three rounds take on a quiet machine:
#   lucy        no support, G-code                       13      stages    igea, all stages of Table 3-5           0.2
#   igea        no support, G-code                        8      linked    igea, STL to linked contours            0.1
#   scaffold    lucy, support, both filled, G-code       12     large     lucy of 10 million facets               11
#                                                                threads   lucy, all stages, one and two threads   1
# --ours runs Firn alone (needs nothing installed). --keep also writes the figures as JSON, beside those of rows and commands
# that the file already holds (experiments/results/slicing.json). A command that takes more than LIMIT_S seconds (900) is
# stopped. --command keeps some of the rows' commands, by their names in the table: 31 rounds of one of them tell how much a
# shared machine's figures differ from minute to minute.
#
# A command's last word is its chord tolerance [mm]; each is compared with Firn at the same one. Layers of 0.25 mm, a line
# every 1.5 mm, one outline, concentric infill of 100 %. Peers: Debian's prusa-slicer, cura-engine and slic3r, installed once
# as root; Cura's definitions come out of its package, which is not installed. What they do beyond that is switched off:
# solid shells, gap fill, thin walls, bridges and overhangs, overlap of infill and outline, closing of slices, combing,
# wiping, cooling, the search for hidden seams (PrusaSlicer's rear seam is its fastest), PrusaSlicer's and Cura's extra lines
# between walls. PrusaSlicer runs its classic perimeter generator, 2.7 times faster here than its default (Arachne). Its
# tolerance applies twice, to slices and to paths; Firn's limits the sum. Firn lays no beads in gaps either
# (firn-beads: as `firn slice` does unless told otherwise); the same job then gives the same number of layers and the same
# metres of outline and infill, which the table prints. Peers' support is not Firn's full scaffold: compare row scaffold by
# the metres. Prints Markdown; progress on stderr.
set -eu

usage() {
  sed -n '2,/^set -eu/{/^set/!s/^# \{0,1\}//p}' "$0" >&2
  exit 2
}
meshes='' rows='' commands='' rounds=3 ours=no keep='' ran=''
while [ $# -gt 0 ]; do
  case $1 in
    --row) rows="$rows ${2:?--row wants a name}"; shift 2 ;;
    --command) commands="$commands ${2:?--command wants a name}"; shift 2 ;;
    --rounds) rounds=${2:?--rounds wants a number}; shift 2 ;;
    --ours) ours=yes; shift ;;
    --keep) keep=$(realpath -m "${2:?--keep wants a file}"); shift 2 ;;
    -*) usage ;;
    *) meshes=$1; shift ;;
  esac
done
[ -d "$meshes" ] || usage
for row in $rows; do
  case $row in lucy | igea | scaffold | stages | linked | large | threads) ;; *) echo "no row '$row'" >&2; usage ;; esac
done
meshes=$(cd "$meshes" && pwd)
cd "$(dirname "$0")/../.."
firn=${FIRN:-build/bin/firn}
limit_s=${LIMIT_S:-900}
work=build/slicing_peers
mkdir -p "$work"
work=$(cd "$work" && pwd)
out=$(mktemp -d "$work/run.XXXXXX")
trap 'rm -rf "$out"' EXIT
trap 'exit 130' INT TERM
cura=$work/cura/usr/share/cura/resources/definitions

install_peers() {
  for package in prusa-slicer cura-engine slic3r; do
    dpkg -s "$package" >/dev/null 2>&1 || apt-get install -y --no-install-recommends "$package" >&2
  done
  if [ ! -f "$cura/fdmprinter.def.json" ]; then
    (cd "$work" && apt-get download cura >&2 && dpkg -x cura_*.deb cura && rm cura_*.deb)
  fi
}

# One core: no time is spent in waiting for each other, and every slicer can be compared in processor time.
core=$(taskset -cp $$ | sed 's/.*: *\([0-9]*\).*/\1/')

prusa="prusa-slicer --export-gcode --layer-height 0.25 --first-layer-height 0.25 --nozzle-diameter 1.5 --extrusion-width 1.5 \
  --first-layer-extrusion-width 1.5 --perimeters 1 --perimeter-generator classic --fill-pattern concentric --fill-density 100% \
  --top-fill-pattern concentric --bottom-fill-pattern concentric --top-solid-layers 0 --bottom-solid-layers 0 \
  --solid-infill-below-area 0 --gap-fill-enabled=0 --no-thin-walls --no-overhangs --no-extra-perimeters --infill-overlap 0 \
  --slice-closing-radius 0 --seam-position rear --no-cooling --retract-length 0 \
  --skirts 0 --brim-width 0 --bed-shape 0x0,600x0,600x600,0x600 --center 300,300 --max-print-height 600"
# Outlines at 30 mm/s, infill at 60: G-code without comments shows them by their speeds.
slic3r="slic3r -j 1 --layer-height 0.25 --first-layer-height 0.25 --nozzle-diameter 1.5 --extrusion-width 1.5 \
  --first-layer-extrusion-width 1.5 --perimeters 1 --fill-pattern concentric --fill-density 100% --top-infill-pattern concentric \
  --bottom-infill-pattern concentric --top-solid-layers 0 --bottom-solid-layers 0 --solid-infill-below-area 0 --no-fill-gaps \
  --no-thin-walls --no-extra-perimeters --no-detect-bridging-perimeters --infill-overlap 0 --seam-position nearest --no-cooling \
  --perimeter-speed 30 --small-perimeter-speed 30 --external-perimeter-speed 30 --infill-speed 60 --solid-infill-speed 60 \
  --top-solid-infill-speed 60 --first-layer-speed 100% --skirts 0 --brim-width 0 --bed-shape 0x0,600x0,600x600,0x600 \
  --print-center 300,300"
engine="CuraEngine slice -m1 -j $cura/fdmprinter.def.json -s layer_height=0.25 -s layer_height_0=0.25 -s line_width=1.5 \
  -s wall_line_width_0=1.5 -s wall_line_width=1.5 -s wall_line_count=1 -s infill_line_width=1.5 -s skin_line_width=1.5 \
  -s infill_pattern=concentric -s infill_line_distance=1.5 -s infill_sparse_density=100 -s infill_sparse_thickness=0.25 \
  -s top_layers=0 -s bottom_layers=0 -s initial_bottom_layers=0 -s roofing_layer_count=0 -s skin_outline_count=0 \
  -s skin_edge_support_layers=0 -s skin_edge_support_thickness=0 -s skin_overlap_mm=0 -s infill_overlap=0 -s infill_overlap_mm=0 \
  -s fill_perimeter_gaps=nowhere -s filter_out_tiny_gaps=false -s connect_infill_polygons=false \
  -s travel_compensate_overlapping_walls_enabled=false -s travel_compensate_overlapping_walls_0_enabled=false \
  -s travel_compensate_overlapping_walls_x_enabled=false -s wall_0_wipe_dist=0 -s infill_wipe_dist=0 -s retraction_combing=off \
  -s z_seam_type=shortest -s cool_min_layer_time=0 -s adhesion_type=none \
  -s meshfix_maximum_resolution=3 -s meshfix_maximum_travel_resolution=3 \
  -s machine_nozzle_size=1.5 -s machine_width=600 -s machine_depth=600 -s machine_height=600"
# Firn's own fill is 3 mm wide by default; against the others it is 1.5 mm.
narrow="--threads 1 --set part.fill_width_mm=1.5 --set scaffold.fill_width_mm=1.5 --set part.first_offset_mm=0.75"
# The stages of Table 3-5: boundaries and fill, no beads where rings leave spots between them.
rings="--set part.gap_mm=0 --set scaffold.gap_mm=0"

command_of() {  # NAME MESH
  tolerance=${1##*-}
  chord="--resolution $tolerance --gcode-resolution $tolerance"
  deviation="-s meshfix_maximum_deviation=$tolerance"
  case $1 in
    prusa-support-*) echo "$prusa $chord --support-material --support-material-spacing 0 --support-material-extrusion-width 1.5 \
      -o $out/paths.gcode $2" ;;
    prusa-*) echo "$prusa $chord -o $out/paths.gcode $2" ;;
    slic3r-*) echo "$slic3r --resolution $tolerance -o $out/paths.gcode $2" ;;
    cura-support-*) echo "$engine $deviation -s support_enable=true -s support_infill_rate=100 -s support_line_width=1.5 \
      -s support_line_distance=1.5 -l $2 -o $out/paths.gcode" ;;
    cura-*) echo "$engine $deviation -s support_enable=false -l $2 -o $out/paths.gcode" ;;
    firn-none-*) echo "$firn slice $2 --support none --tolerance $tolerance --gcode $out/paths.gcode $narrow $rings" ;;
    firn-beads-none-*) echo "$firn slice $2 --support none --tolerance $tolerance --gcode $out/paths.gcode $narrow" ;;
    firn-full-*) echo "$firn slice $2 --support full --tolerance $tolerance --gcode $out/paths.gcode $narrow $rings" ;;
    firn-stages-*) echo "$firn slice $2 --support full --threads 1 --tolerance $tolerance $rings -o $out/firn.paths" ;;
    firn-beads-*) echo "$firn slice $2 --support full --threads 1 --tolerance $tolerance -o $out/firn.paths" ;;
    firn-threads-*) threads=${1#firn-threads-}
      echo "$firn slice $2 --support full --threads ${threads%%-*} --tolerance $tolerance -o $out/firn.paths" ;;
    firn-linked-*) echo "build/bench/slice_stages $2 $tolerance 1" ;;
  esac
}

run() {  # NAME MESH -> appends "processor-time wall MiB" to a file of its own; what it has written to one beside it
  file=$out/$(basename "$2")-$1.runs
  case $1 in firn-threads-*) where= ;; *) where="taskset -c $core" ;; esac
  rm -f "$out/paths.gcode"
  # shellcheck disable=SC2046,SC2086
  if CURA_ENGINE_SEARCH_PATH=$cura timeout "$limit_s" $where /usr/bin/time -f "%U %S %e %M" -o "$out/time" $(command_of "$1" "$2") >"$out/log" 2>&1; then
    case $1 in
      # Processor time of one stage within the command.
      firn-linked-*) sed -n 's/.*read to linked *median \([0-9.]*\) s.*/\1 \1 0/p' "$out/log" >>"$file" ;;
      *) awk 'END {printf "%.2f %.2f %.0f\n", $1 + $2, $3, $4 / 1024}' "$out/time" >>"$file" ;;
    esac
    [ -f "$file.paths" ] || [ ! -f "$out/paths.gcode" ] || python3 -B tests/bench/gcode_metres.py measure "$out/paths.gcode" >"$file.paths"
  else
    echo "$1 failed or took more than $limit_s s on $2: $(tail -n 1 "$out/log" | cut -c 1-200)" >&2
    echo "failed failed failed" >>"$file"
  fi
}

median() {  # FILE COLUMN
  cut -d ' ' -f "$2" "$1" | sort -n | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'
}

least() {
  cut -d ' ' -f 1 "$1" | sort -n | sed -n 1p
}

most() {
  cut -d ' ' -f 1 "$1" | sort -n | sed -n '$p'
}

value() {  # FILE KEY -> the figure of a line "key=value...", - if there is none
  [ -f "$1" ] && sed -n "s/.*\b$2=\([0-9.]*\).*/\1/p" "$1" || echo -
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
  echo '| command | CPU s | least to most | wall s | MiB | by Firn'\''s | layers | outline m | infill m | support m | moves |'
  echo '|---|---|---|---|---|---|---|---|---|---|---|'
  for name in $names; do
    file=$out/$(basename "$mesh")-$name.runs
    cpu=$(median "$file" 1) wall=$(median "$file" 2) mib=$(median "$file" 3)
    # The row's first command of Firn at the same tolerance.
    base=''
    for other in $names; do
      case $other in firn-*-"${name##*-}") base=$(median "$out/$(basename "$mesh")-$other.runs" 1); break ;; esac
    done
    ratio=$(echo "$cpu ${base:-0}" | awk '{if ($1 + 0 > 0 && $2 + 0 > 0) printf "%.2f", $1 / $2; else printf "-"}')
    printf '| %s | %s | %s to %s | %s | %s | %s |' "$name" "$cpu" "$(least "$file")" "$(most "$file")" "$wall" "$mib" "$ratio"
    for key in layers outline_m infill_m support_m moves; do printf ' %s |' "$(value "$file.paths" "$key")"; done
    echo
    [ "$cpu" != failed ] || continue
    line="$row $(basename "$mesh") $(wc -l <"$file") $name cpu_s=$cpu least_s=$(least "$file") most_s=$(most "$file") wall_s=$wall mib=$mib"
    [ ! -f "$file.paths" ] || line="$line $(cat "$file.paths")"
    echo "$line" >>"$out/rows"
  done
  [ -z "$keep" ] || python3 -B tests/bench/gcode_metres.py keep "$keep" "$out/rows"
}

echo "A command's last word is its chord tolerance in mm. $(nproc) cores, $(date -u +%F), load $(cut -d ' ' -f 1 /proc/loadavg)."
table lucy "no support, G-code written" lucy500_1215k.stl firn-none-0.05 prusa-0.05 cura-0.05 slic3r-0.05 \
  firn-none-0.0125 prusa-0.0125 cura-0.0125 slic3r-0.0125 firn-beads-none-0.05 firn-none-0
table igea "no support, G-code written" igea_1075k.stl firn-none-0.05 prusa-0.05 cura-0.05 slic3r-0.05 \
  firn-none-0.0125 prusa-0.0125 cura-0.0125 slic3r-0.0125 firn-beads-none-0.05 firn-none-0
table scaffold "support, both materials filled, G-code written" lucy500_1215k.stl firn-full-0.05 prusa-support-0.05 cura-support-0.05 \
  firn-full-0.0125 prusa-support-0.0125 cura-support-0.0125 firn-full-0
table stages "all stages of Table 3-5, one thread, path file written" igea_1075k.stl firn-stages-0.05 firn-beads-0.05 firn-stages-0.01 firn-stages-0
table linked "STL to linked contours, one thread, processor time" igea_1075k.stl firn-linked-0.05 firn-linked-0.01 firn-linked-0
table large "no support, G-code written; all stages, path file written" lucy500_10140k.stl firn-none-0.05 prusa-0.05 \
  firn-none-0.0125 prusa-0.0125 firn-stages-0.05 firn-beads-0.05 firn-stages-0
table threads "all stages, one and two threads" lucy500_1215k.stl firn-threads-1-0.05 firn-threads-2-0.05 \
  firn-threads-1-0.01 firn-threads-2-0.01 firn-threads-1-0 firn-threads-2-0
[ -n "$ran" ] || { echo "nothing to run: no mesh, or no command$commands in these rows" >&2; exit 2; }
for name in $commands; do
  case " $ran " in *" $name "*) ;; *) echo "no command '$name' in the rows that ran" >&2; exit 2 ;; esac
done
