#!/usr/bin/env python3
"""An own controller (level.py, twenty lines) against four schemes on the same seeds, with intervals.

    ./firn python experiments/python/compare_own.py [SEEDS [HEIGHT_MM]]
"""
import sys
from pathlib import Path

import firn

HERE = Path(__file__).resolve().parent
SCHEMES = {
    "level": f"python:{HERE}/level.py:Level",
    "open loop": "open_loop",
    "threshold": "threshold",
    "SMF": "smf",
    "MPC": ("mpc", {"control.mpc.method": "certified"}),
}


def main():
    seeds = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    height_mm = float(sys.argv[2]) if len(sys.argv) > 2 else 0.2
    told = firn.compare(HERE.parent / "cuboid.toml", SCHEMES, seeds=seeds, baseline="open loop",
                        settings={"part.height_mm": height_mm}, metrics=["rms_um", "std_um", "layers"])
    for scheme in told["schemes"]:
        rms = next(m for m in scheme["metrics"] if (m["metric"], m["part"]) == ("rms_um", ""))
        print(f"{scheme['name']:10} RMS {rms['mean']:6.3f} um  [{rms['low']:.3f}, {rms['high']:.3f}]")
    print(told["answer"])


if __name__ == "__main__":
    main()
