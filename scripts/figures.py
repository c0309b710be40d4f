#!/usr/bin/env python3
"""Figures and tables of the documents, from the files that the measuring commands wrote.

    scripts/figures.py                    check: every marked table and figure equals its results (a test)
    scripts/figures.py --write            writes them anew
    scripts/figures.py --take NAME FILE   keeps the output of a command with --json as experiments/results/NAME.json

A table stands between `<!-- table NAME -->` and `<!-- end -->`; TABLES says how it is made. A figure in the text is
followed by its source, `0.112<!-- ice-drift: schemes/name=SMF speed/metrics/metric=rms_um,part=/mean * 0.001 .3 -->`:
file, path in it (a step into a list names members of the wanted object), a factor if any, decimals.
"""
import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "experiments" / "results"
MARK = re.compile(r"(<!-- table (\S+) -->\n)(.*?)(<!-- end -->)", re.S)
SOURCE = re.compile(r"(<!-- ([\w-]+): ([^>]+?)(?: \* (\S+))? \.(\d) -->)")
FIGURE = re.compile(r"(-?\d*\.?\d+)" + SOURCE.pattern)


class NoFigure(Exception):
    """A source that names nothing, or more than one thing."""


def results(name):
    path = RESULTS / f"{name}.json"
    if not path.is_file():
        raise NoFigure(f"experiments/results/{name}.json is missing")
    return json.loads(path.read_text(encoding="utf-8"))


def lookup(data, path):
    """@returns the number at a path: `schemes/name=SMF/prints`."""
    for step in path.split("/"):
        if isinstance(data, list):
            wanted = dict(pair.split("=", 1) for pair in step.split(","))
            data = [one for one in data if all(str(one.get(key)) == value for key, value in wanted.items())]
            if len(data) != 1:
                raise NoFigure(f"{path}: {step} names {len(data)} objects")
            data = data[0]
        elif isinstance(data, dict) and step in data:
            data = data[step]
        else:
            raise NoFigure(f"{path}: there is no {step}")
    if isinstance(data, bool) or not isinstance(data, (int, float)):
        raise NoFigure(f"{path} is no number")
    return data


def figure(match):
    _, mark, name, path, factor, decimals = match.groups()
    value = lookup(results(name), path) * float(factor or 1)
    return f"{value:.{decimals}f}{mark}"


def metric(study, scheme, name, part):
    """@returns the row of a scheme's metric on a part ("" = over all parts)."""
    (found,) = [s for s in study["schemes"] if s["name"] == scheme]
    (row,) = [m for m in found["metrics"] if (m["metric"], m["part"]) == (name, part)]
    return row


def interval(row, decimals, factor=1.0):
    mean, low, high = (row[key] if row[key] is None else f"{row[key] * factor:.{decimals}f}" for key in ("mean", "low", "high"))
    return "-" if mean is None else mean if low is None else f"{mean} [{low}, {high}]"


def plain(row, decimals, factor=1.0):
    return "-" if row["mean"] is None else f"{row['mean'] * factor:.{decimals}f}"


def bold_least(rows, column):
    """Marks the least mean of a column of (mean, text) pairs."""
    least = min(rows, key=lambda row: row[column][0])
    least[column] = (least[column][0], f"**{least[column][1]}**")


def markdown(head, rows):
    lines = ["|" + "|".join(head) + "|", "|-" + "|-:" * (len(head) - 1) + "|"]
    return "\n".join(lines + ["|" + "|".join(text for _, text in row) + "|" for row in rows]) + "\n"


def study_table(name, schemes, columns, bold=()):
    """A row a scheme. @param columns (head, metric, part, decimals, factor, with interval)"""
    study = results(name)
    rows = []
    for scheme, text in schemes.items():
        row = [(0, text)]
        for _, measure, part, decimals, factor, spread in columns:
            found = metric(study, scheme, measure, part)
            shown = (interval if spread else plain)(found, decimals, factor)
            if spread and found["seeds"] < study["seeds"]:
                shown += f", survivors: {found['seeds']} of {study['seeds']}"
            row.append((float("inf") if found["mean"] is None else found["mean"], shown))
        rows.append(row)
    for column in bold:
        bold_least(rows, column)
    return markdown(["scheme", *[column[0] for column in columns]], rows)


# Parts of studies by their names there: the standard deviation of the profiler's noise.
NOISE = {"1 um a point": "1 um per sample", "1 um a cell": "1 um per cell"}


def cylinder():
    point, cell = results("cylinder")["parts"]
    names = {"open loop": "open loop, number of layers from the model", "open loop tuned": "open loop, number of layers tuned",
             "threshold": "threshold feedback [Cohen and Lipson 2010]",
             "SMF": "surface mapping feedback (SMF), the thesis's gains [Barnett 2012]",
             "SMF tuned": "SMF, tuned gains", "MPC": "model predictive control (MPC), greedy search [Lu 2015]"}
    return study_table("cylinder", names, [
        (f"RMS [um], sensor noise {NOISE[point]}", "rms_um", point, 2, 1, True),
        (f"RMS [um], sensor noise {NOISE[cell]}", "rms_um", cell, 2, 1, True),
        ("largest error [um]", "max_um", point, 1, 1, False), ("overspill [%]", "overspill_pct", point, 1, 1, False),
        ("first ring [um]", "first_ring_um", point, 0, 1, False), ("size error [um]", "size_x_um", point, 0, 1, False)],
        bold=(1, 2))


def mpc_held_out():
    """Every plant of the study: a row a plant, RMS of each scheme; the least of a row in bold."""
    study = results("mpc-held-out")
    schemes = {"SMF": "SMF", "MPC greedy N1": "greedy", "MPC strips N3 filter": "N = 3, surface estimated",
               "MPC strips N3 factors": "factors", "MPC strips N3 together": "together"}
    lines = ["|plant|" + "|".join(schemes.values()) + "|", "|-" + "|-:" * len(schemes) + "|"]
    for part in study["parts"]:
        found = [metric(study, scheme, "rms_um", part) for scheme in schemes]
        least = min(row["mean"] for row in found)
        shown = [interval(row, 2) if text in ("factors", "together") else plain(row, 2) for row, text in zip(found, schemes.values())]
        lines.append(f"|{NOISE.get(part, part)}|" + "|".join(f"**{s}**" if row["mean"] == least else s for row, s in zip(found, shown)) + "|")
    return "\n".join(lines) + "\n"


def ratio(row):
    return "-" if row["ratio"] is None else f"{row['ratio']:.2f}" + (f" [{row['low']:.2f}, {row['high']:.2f}]" if row["low"] is not None else "")


def worlds():
    """A row a world: ratios to the baseline, losses in bold; the last row is over all worlds."""
    study = results("worlds")
    ratios = study["ratios"]
    schemes = [one["scheme"] for one in ratios["over_parts"]]
    lines = ["|world|" + "|".join(schemes) + "|", "|-" + "|-:" * len(schemes) + "|"]
    for part in study["parts"]:
        found = [one for scheme in schemes for one in ratios["parts"] if (one["scheme"], one["part"]) == (scheme, part)]
        lines.append(f"|{part}|" + "|".join(f"**{ratio(one)}**" if one["low"] > 1 else ratio(one) for one in found) + "|")
    lines.append("|all of them|" + "|".join(ratio(one) for one in ratios["over_parts"]) + "|")
    return "\n".join(lines) + "\n"


def worlds_profiles():
    ratios = results("worlds")["ratios"]
    lines = ["|scheme|" + "|".join(f"{f:g}" for f in ratios["profile_factors"]) + "|", "|-" + "|-:" * len(ratios["profile_factors"]) + "|"]
    lines += [f"|{one['scheme']}|" + "|".join(f"{100 * share:.0f} %" for share in one["share"]) + "|" for one in ratios["profiles"]]
    return "\n".join(lines) + "\n"


def worlds_pareto():
    lines = ["|scheme|RMS [um]|overspill and missing [%]|layers|bettered in all three by|", "|-|-:|-:|-:|-|"]
    for one in results("worlds")["ratios"]["pareto"]:
        lines.append(f"|{one['scheme']}|{one['rms_um']:.2f}|{one['misplaced_pct']:.1f}|{one['layers']:.1f}|{one['bettered_by'] or 'none'}|")
    return "\n".join(lines) + "\n"


def worlds_auto():
    lines = ["|world|ratio of auto to the best other scheme|one-sided 95 % bound|best other scheme, chosen on other labs|", "|-|-:|-:|-|"]
    for one in results("worlds")["ratios"]["judged"]["parts"]:
        best = " or ".join(dict.fromkeys(one["best"]))
        bound = f"{one['upper']:.3f}"
        lines.append(f"|{one['part']}|{ratio(one)}|{bound if one['holds'] else f'**{bound}**'}|{best}|")
    return "\n".join(lines) + "\n"


def edges():
    """A row a part of the study and scheme: both droplets at three values of plant.slope_bias_mm, and the paper's model."""
    study = results("edges")
    names = {"threshold": "threshold", "SMF tuned": "SMF, tuned gains", "MPC": "MPC, greedy"}
    columns = (("overspill_pct", 2, "overspill [%]"), ("missing_pct", 2, "missing [%]"), ("rms_um", 2, "RMS [um]"),
               ("inside_rms_um", 2, "RMS inside [um]"), ("edge_width_um", 0, "edge width [um]"), ("size_x_um", 0, "size error [um]"),
               ("print_s", 0, "print time [s]"), ("passes", 0, "passes"), ("edge_bound_pct", 2, "least overspill [%]"))
    lines = ["|droplet|b [um]|scheme|" + "|".join(head for _, _, head in columns) + "|", "|-|-:|-|" + "-:|" * len(columns)]
    for part in study["parts"]:
        droplet = "413 um" if part.startswith("droplet413") else "Lu's model" if part == "lu2015" else "fitted"
        b = "-" if part == "lu2015" else part.removeprefix("droplet413 ").removesuffix(" um")
        for scheme, text in names.items():
            lines.append("|" + "|".join([droplet, b, text] + [plain(metric(study, scheme, name, part), decimals) for name, decimals, _ in columns]) + "|")
    return "\n".join(lines) + "\n"


def edge_outlines():
    """A row a part and value of plant.slope_bias_mm: overspill and missing volume of each scheme with its interval, and its RMS."""
    study = results("edge-outlines")
    names = {"MPC": "MPC, centres", "threshold inset 0.125": "threshold, inset 0.125", "SMF inset 0.375": "SMF, inset 0.375",
             "MPC along x": "MPC along x", "MPC 4 x 4": "MPC 4 x 4"}
    lines = ["|part|b [um]|" + "|".join(names.values()) + "|", "|-|-:|" + "-:|" * len(names)]
    for part in study["parts"]:
        name, b, _ = part.rsplit(" ", 2)
        cells = []
        for scheme in names:
            misplaced, rms = metric(study, scheme, "misplaced_pct", part), metric(study, scheme, "rms_um", part)
            cells.append([(misplaced["mean"], f"{interval(misplaced, 1)}; {plain(rms, 1)}")])
        bold_least(cells, 0)
        lines.append("|" + "|".join([name, b] + [text for ((_, text),) in cells]) + "|")
    return "\n".join(lines) + "\n"


def schemes():
    names = {"open loop": "open loop", "threshold": "threshold [Cohen and Lipson]", "SMF": "SMF", "MPC greedy": "MPC, greedy",
             "MPC strips": "MPC, strips"}
    return study_table("schemes", names, [
        ("RMS", "rms_um", "", 2, 1, True), ("std", "std_um", "", 2, 1, False), ("largest error", "max_um", "", 1, 1, False),
        ("overspill [%]", "overspill_pct", "", 1, 1, False), ("first ring", "first_ring_um", "", 0, 1, False),
        ("size error", "size_x_um", "", 0, 1, False), ("layers", "layers", "", 1, 1, False)])


def ice():
    steady, drifting = results("ice-drift")["parts"]
    names = {"open loop": "open loop", "open loop weighed": "open loop, flow calibrated once", "SMF speed": "SMF as in the thesis",
             "SMF foreseeing": "SMF with a disturbance observer"}
    return study_table("ice-drift", names, [
        ("RMS [mm], steady valves", "rms_um", steady, 3, 1e-3, True), ("RMS [mm], drifting valves", "rms_um", drifting, 3, 1e-3, True),
        ("largest error [mm]", "max_um", drifting, 2, 1e-3, False), ("overspill [%]", "overspill_pct", drifting, 1, 1, False),
        ("first ring [um]", "first_ring_um", drifting, 0, 1, False), ("size error [um]", "size_x_um", drifting, 0, 1, False)],
        bold=(1, 2))


def ice_roughness():
    names = {"open loop": "open loop", "SMF speed": "SMF by path speed", "SMF foreseeing": "SMF with a disturbance observer"}
    return study_table("ice-roughness", names, [
        (part.removeprefix("roughness "), "rms_um", part, 3, 1e-3, True) for part in results("ice-roughness")["parts"]])


def aerosol():
    names = {"open loop": "open loop", "paper": "the paper's corners, open loop", "feedback": "sections fed back",
             "section and width": "sections and widths"}
    return study_table("aerosol-drift", names, [
        (f"{part}: {head}", measure, part, decimals, 1, decimals > 0) for part in results("aerosol-drift")["parts"]
        for head, measure, decimals in (("section, RMS [%]", "section_rms_pct", 2), ("worst start [um]", "start_um", 0), ("end [um]", "end_um", 0))])


def aerosol_width():
    names = {"open loop": "open loop", "section by profiler": "section by speed", "width by camera": "width by speed",
             "width by gas": "width by gas, section by speed", "width by gas and height": "width by gas, height by speed"}
    return study_table("aerosol-width", names, [
        (f"{part}: {head}", measure, part, 1, 1, measure == "visible_rms_um") for part in results("aerosol-width")["parts"]
        for head, measure in (("width [um]", "visible_rms_um"), ("section [%]", "section_rms_pct"), ("height [%]", "height_rms_pct"))])


def aerosol_thompson():
    names = {"paper": "the paper's corners", "loops": "loops", "hybrid": "hybrid"}
    return study_table("aerosol-thompson", names, [
        (f"{part}: {head}", measure, part, decimals, 1, measure == "offset_rms_um") for part in results("aerosol-thompson")["parts"]
        for head, measure, decimals in (("middles [um]", "offset_rms_um", 1), ("camera", "seen_offset_um", 1), ("path", "followed_offset_um", 1),
                                        ("overspray [%]", "overspray_pct", 2), ("camera", "seen_overspray_pct", 2))])


TABLES = {"aerosol": aerosol, "aerosol-width": aerosol_width, "aerosol-thompson": aerosol_thompson, "cylinder": cylinder, "edges": edges, "edge-outlines": edge_outlines, "mpc-held-out": mpc_held_out, "schemes": schemes,
          "ice": ice, "ice-roughness": ice_roughness, "worlds": worlds, "worlds-auto": worlds_auto,
          "worlds-pareto": worlds_pareto, "worlds-profiles": worlds_profiles}


def take(name, file):
    """Keeps what the tables may use, a line a scheme, a metric or a row of a paper; of any other output all."""
    study = json.loads(Path(file).read_text(encoding="utf-8"))
    study.pop("trajectories", None)  # firn plan: a row a path
    if "schemes" in study:
        study = {key: study[key] for key in ("study", "provenance", "answer", "notes", "parts", "seeds", "schemes", "ratios") if key in study}
    RESULTS.mkdir(exist_ok=True)
    text = json.dumps(study, indent=None, separators=(",", ":"), ensure_ascii=False)
    for first, line in (("name", "\n"), ("metric", "\n "), ("id", "\n"), ("scheme", "\n"), ("part", "\n")):
        text = text.replace(f'{{"{first}"', f'{line}{{"{first}"')
    (RESULTS / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def renewed(text):
    if len(SOURCE.findall(text)) != len(FIGURE.findall(text)):
        raise NoFigure("a source has no figure before it")
    text = MARK.sub(lambda m: m.group(1) + TABLES[m.group(2)]() + m.group(4), text)
    return FIGURE.sub(figure, text)


def main():
    if sys.argv[1:2] == ["--take"]:
        take(*sys.argv[2:])
        return 0
    return check("--write" in sys.argv)


def check(write):
    """@returns 1 if a page differs from the results and is not to be written."""
    stale = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text, name = page.read_text(encoding="utf-8"), page.relative_to(ROOT)
        try:
            made = renewed(text)
        except (NoFigure, KeyError) as e:
            print(f"figures: {name}: {e}", file=sys.stderr)
            stale += 1
            continue
        if made == text:
            continue
        if write:
            page.write_text(made, encoding="utf-8")
            continue
        print(f"figures: {name}: a table or figure differs from experiments/results; scripts/figures.py --write", file=sys.stderr)
        stale += 1
    if not stale:
        print("figures: ok")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
