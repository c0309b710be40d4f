#!/usr/bin/env python3
"""Draws docs/images/loop.svg: the processes of an ink-jet print and the messages between them.

    scripts/draw_loop.py            check: the picture is this drawing, and each of its arrows is in docs/dataflow.md (a test)
    scripts/draw_loop.py --write    draws it anew

docs/dataflow.md is written by `firn dataflow` from the subscriptions of the nodes, so the picture shows no arrow that the code
has not.
"""
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PICTURE, FLOW = "docs/images/loop.svg", "docs/dataflow.md"
WIDTH, HEIGHT = 960, 590

STYLE = ("text{font-family:system-ui,'DejaVu Sans',sans-serif;fill:#1c2024}.name{font-size:16px;font-weight:600}"
         ".words{font-size:13px;fill:#46505a}.channel{font-size:12px;font-family:ui-monospace,'DejaVu Sans Mono',monospace;fill:#0b5cad}"
         ".note{font-size:13px;fill:#46505a}.matter{font-size:13px;fill:#9a4a00}"
         ".box{fill:#f4f7fa;stroke:#46505a;stroke-width:1.3}.guard{fill:#fdf3f2;stroke:#b3261e;stroke-width:1.3}"
         ".flow{stroke:#0b5cad;stroke-width:2;fill:none}.hold{stroke:#b3261e;stroke-width:1.5;stroke-dasharray:5 4;fill:none}"
         ".thing{stroke:#9a4a00;stroke-width:2;fill:none}.world{fill:#fff9f0;stroke:#c98a3a;stroke-width:1.3;stroke-dasharray:6 5}"
         ".layer{fill:#ffd27a;stroke:#9a4a00;stroke-width:1}")

# process: left, top, width, words, style
BOXES = {
    "droplet_estimator": (375, 26, 210, "learns how a droplet spreads", "box"),
    "surface_mapper": (30, 150, 210, "makes the height map", "box"),
    "controller": (375, 150, 210, "decides the next layer", "box"),
    "scheduler": (720, 150, 210, "runs the print step by step", "box"),
    "laser_profiler": (30, 322, 210, "measures the surface", "box"),
    "safety": (375, 322, 210, "permits for 0.3 s at a time", "guard"),
    "stage": (720, 322, 64, "moves", "box"),
    "jet": (793, 322, 64, "fires", "box"),
    "lamp": (866, 322, 64, "cures", "box"),
}
BOX_HEIGHT = 60

# publisher, subscriber, channels, style, points of the arrow, place of the words and where they are anchored
MESSAGES = (
    ("surface_mapper", "controller", ("HEIGHT_MAP",), "flow", "240,180 371,180", (306, 171, "middle")),
    ("controller", "scheduler", ("LAYER_PLAN",), "flow", "585,180 716,180", (651, 171, "middle")),
    ("scheduler", "stage", ("STAGE_COMMAND",), "flow", "752,210 752,318", (744, 238, "end")),
    ("scheduler", "jet", ("JET_COMMAND",), "flow", "825,210 825,318", (744, 258, "end")),
    ("scheduler", "lamp", ("LAMP_COMMAND",), "flow", "898,210 898,318", (744, 278, "end")),
    ("laser_profiler", "surface_mapper", ("HEIGHT_PROFILE",), "flow", "135,322 135,214", (145, 272, "start")),
    ("surface_mapper", "droplet_estimator", ("HEIGHT_MAP",), "flow", "135,150 135,56 371,56", (253, 47, "middle")),
    ("scheduler", "droplet_estimator", ("DEPOSITION_REPORT",), "flow", "825,150 825,56 589,56", (707, 47, "middle")),
    ("droplet_estimator", "controller", ("HEIGHT_MODEL",), "flow", "480,86 480,146", (490, 121, "start")),
    ("safety", "laser_profiler", ("ENABLE", "SAFE_STOP"), "hold", "375,352 244,352", (309, 343, "middle")),
    ("safety", "stage", ("ENABLE", "SAFE_STOP"), "hold", "585,352 716,352", (651, 343, "middle")),
)
ARROW = re.compile(r"^  (.+?) -->\|(.+?)\| (.+)$", re.M)


def arrows_of(text):
    """Set of (publisher, channel, subscriber) of the flowchart in docs/dataflow.md."""
    return {(publisher, channel, subscriber) for publishers, channels, subscribers in ARROW.findall(text) for publisher in publishers.split(" & ")
            for channel in channels.split("<br/>") for subscriber in subscribers.split(" & ")}


def text(x, y, style, words, anchor="middle"):
    return f'<text x="{x}" y="{y}" text-anchor="{anchor}" class="{style}">{words}</text>'


def drawing():
    parts = [f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" role="img" xmlns="http://www.w3.org/2000/svg">',
             "<title>The loop of an ink-jet print: the surface is measured after each layer, and the next layer is decided from it</title>",
             f"<style>{STYLE}</style><defs>"]
    for style, colour in (("flow", "#0b5cad"), ("hold", "#b3261e"), ("thing", "#9a4a00")):
        parts.append(f'<marker id="{style}" viewBox="0 0 10 10" refX="8" refY="5" markerWidth="9" markerHeight="9" '
                     f'markerUnits="userSpaceOnUse" orient="auto"><path d="M0 0L10 5L0 10z" fill="{colour}"/></marker>')
    parts.append(f'</defs><rect width="{WIDTH}" height="{HEIGHT}" rx="8" fill="#ffffff"/>')
    parts.append('<rect x="14" y="424" width="932" height="118" rx="8" class="world"/>')
    parts.append(text(30, 532, "matter", "real instruments, or one process, world, that simulates them byte by byte", "start"))
    for n in range(5):
        parts.append(f'<rect x="{410 + (n % 2)}" y="{504 - 9 * n}" width="{140 - 2 * (n % 2)}" height="9" class="layer"/>')
    parts.append(text(480, 456, "matter", "the part, layer on layer"))
    parts.append('<path d="M825 382V482H558" class="thing" marker-end="url(#thing)"/>' + text(690, 473, "matter", "droplets"))
    parts.append('<path d="M402 482H135V386" class="thing" marker-end="url(#thing)"/>' + text(268, 473, "matter", "laser line"))
    for name, (x, y, width, words, style) in BOXES.items():
        parts.append(f'<rect x="{x}" y="{y}" width="{width}" height="{BOX_HEIGHT}" rx="6" class="{style}"/>')
        parts.append(text(x + width / 2, y + 26, "name", name) + text(x + width / 2, y + 46, "words", words))
    for _, _, channels, style, points, (x, y, anchor) in MESSAGES:
        parts.append(f'<polyline points="{points}" class="{style}" marker-end="url(#{style})"/>')
        for n, channel in enumerate(channels):
            parts.append(text(x, y + 24 * n, "channel", channel, anchor))
    parts.append(text(480, 570, "note", "Each box is a process. It writes every event to its own file before it handles it; replay feeds it that file again."))
    return "\n".join(parts) + "\n</svg>\n"


def problems(root):
    known = arrows_of((root / FLOW).read_text(encoding="utf-8"))
    found = [f"{PICTURE}: {publisher} sends no {channel} to {subscriber}" for publisher, subscriber, channels, *_ in MESSAGES
             for channel in channels if (publisher, channel, subscriber) not in known]
    if (root / PICTURE).read_text(encoding="utf-8") != drawing():
        found.append(f"{PICTURE}: differs from its drawing; scripts/draw_loop.py --write")
    return found


def main():
    if "--write" in sys.argv:
        (ROOT / PICTURE).write_text(drawing(), encoding="utf-8")
    found = problems(ROOT)
    print("\n".join(f"draw_loop: {one}" for one in found or ["ok"]))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
