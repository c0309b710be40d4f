#!/usr/bin/env python3
"""Tables of the documents from the files that the measuring commands wrote.

    scripts/figures.py                    check: every marked table equals its results (a test)
    scripts/figures.py --write            writes the marked tables anew
    scripts/figures.py --take NAME FILE   keeps the output of `firn compare STUDY --json` as experiments/results/NAME.json

A marked table stands between `<!-- table NAME -->` and `<!-- end -->`; TABLES says how it is made.
"""
import json
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "experiments" / "results"
MARK = re.compile(r"(<!-- table (\S+) -->\n)(.*?)(<!-- end -->)", re.S)


def metric(study, scheme, name, part):
    """@returns the row of a scheme's metric on a part ("" = over all parts)."""
    (found,) = [s for s in study["schemes"] if s["name"] == scheme]
    (row,) = [m for m in found["metrics"] if (m["metric"], m["part"]) == (name, part)]
    return row


def interval(row, decimals):
    return f"{row['mean']:.{decimals}f} [{row['low']:.{decimals}f}, {row['high']:.{decimals}f}]"


def bold_least(rows, column):
    """Marks the least mean of a column of (mean, text) pairs."""
    least = min(rows, key=lambda row: row[column][0])
    least[column] = (least[column][0], f"**{least[column][1]}**")


def cylinder():
    study = json.loads((RESULTS / "cylinder.json").read_text(encoding="utf-8"))
    point, cell = study["parts"]
    names = {"open loop": "open loop, layers by the model", "open loop tuned": "open loop, layers tuned",
             "threshold": "threshold feedback [Cohen and Lipson 2010]",
             "SMF": "surface mapping feedback (SMF), the thesis's gains [Barnett 2012]",
             "SMF tuned": "SMF, gains tuned", "MPC": "model predictive control (MPC), greedy search [Lu 2015]"}
    rows = []
    for scheme in names:
        rms = [metric(study, scheme, "rms_um", part) for part in (point, cell)]
        largest, outside = (metric(study, scheme, m, point) for m in ("max_um", "overspill_pct"))
        ring, size = (metric(study, scheme, m, point) for m in ("first_ring_um", "size_x_um"))
        rows.append([(0, names[scheme]), *[(r["mean"], interval(r, 2)) for r in rms],
                     *[(r["mean"], f"{r['mean']:.{d}f}") for r, d in ((largest, 1), (outside, 1), (ring, 0), (size, 0))]])
    for column in (1, 2):
        bold_least(rows, column)
    head = ["scheme", f"RMS [um], noise {point}", f"RMS [um], noise {cell}", "largest error [um]", "overspill [%]",
            "first ring [um]", "size error [um]"]
    lines = ["|" + "|".join(head) + "|", "|-" + "|-:" * (len(head) - 1) + "|"]
    return "\n".join(lines + ["|" + "|".join(text for _, text in row) + "|" for row in rows]) + "\n"


def mpc():
    study = json.loads((RESULTS / "mpc.json").read_text(encoding="utf-8"))
    names = {"MPC greedy N1": "greedy search, as published", "MPC strips N3": "three layers ahead, strips solved exactly, model and surface estimated",
             "MPC strips N3 filter": "the same, the surface estimated, the model as published", "MPC strips N3 factors": "the same, rates of inside and rim learned",
             "MPC strips N3 together": "and inside and rim rise together"}
    rows = []
    for scheme, text in names.items():
        rms, outside = (metric(study, scheme, m, "") for m in ("rms_um", "overspill_pct"))
        rows.append([(0, text), (rms["mean"], interval(rms, 2)), (0, f"{outside['mean']:.1f}")])
    bold_least(rows, 1)
    head = ["MPC", "RMS [um]", "overspill [%]"]
    lines = ["|" + "|".join(head) + "|", "|-" + "|-:" * (len(head) - 1) + "|"]
    return "\n".join(lines + ["|" + "|".join(text for _, text in row) + "|" for row in rows]) + "\n"


TABLES = {"cylinder": cylinder, "mpc": mpc}


def take(name, file):
    study = json.loads(Path(file).read_text(encoding="utf-8"))
    kept = {key: study[key] for key in ("study", "provenance", "answer", "notes", "parts", "seeds", "schemes")
            if key in study}
    RESULTS.mkdir(exist_ok=True)
    text = json.dumps(kept, indent=None, separators=(",", ":"), ensure_ascii=False)
    (RESULTS / f"{name}.json").write_text(text.replace('{"name"', '\n{"name"').replace('{"metric"', '\n {"metric"') + "\n",
                                          encoding="utf-8")


def main():
    if sys.argv[1:2] == ["--take"]:
        take(*sys.argv[2:])
        return 0
    stale = 0
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        made = MARK.sub(lambda m: m.group(1) + TABLES[m.group(2)]() + m.group(4), text)
        if made == text:
            continue
        if "--write" in sys.argv:
            page.write_text(made, encoding="utf-8")
        else:
            print(f"figures: {page.relative_to(ROOT)}: a table differs from experiments/results; scripts/figures.py --write", file=sys.stderr)
            stale += 1
    if not stale:
        print("figures: ok")
    return 1 if stale else 0


if __name__ == "__main__":
    sys.exit(main())
