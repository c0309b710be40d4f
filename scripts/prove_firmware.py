#!/usr/bin/env python3
"""Proofs about the firmware's parsers by Frama-C's abstract interpretation (Eva): no access outside a buffer, whatever comes.

    scripts/prove_firmware.py [ROOT]

Each program of PROOFS gives a parser any bytes; every alarm, and every assertion of it that is not shown, is a problem. The lines
of the heaters' box are not among them: they are fuzzed (tests/fuzz/fuzz_heater_firmware.cpp), since Eva did not end in 150 s.
"""
import re
import subprocess
import sys
from pathlib import Path

from firn_tree import finish

PROOFS = {"tests/firmware/eva/valve_frames.c": ("firmware/valve/frames.c", "firmware/common/crc16.c")}
OPTIONS = ("-eva", "-eva-precision", "4", "-eva-auto-loop-unroll", "600", "-eva-warn-undefined-pointer-comparison", "all")


def problems(root, program, sources):
    files = [str(Path(root) / file) for file in (program, *sources)]  # a relative path would be one from $PWD, not from cwd
    done = subprocess.run(["frama-c", *OPTIONS, f"-cpp-extra-args=-I{root}", *files], capture_output=True, text=True, check=False)
    said = done.stdout + done.stderr
    found = [" ".join(m.group(1).split()) for m in re.finditer(r"\[eva:alarm\] (.*?)(?=\n\[|\Z)", said, re.S)]
    if done.returncode != 0 or "ANALYSIS SUMMARY" not in said:
        found.append(f"{program}: frama-c failed: {said.strip().splitlines()[-1] if said.strip() else 'it said nothing'}")
    elif not re.search(r"Assertions\s+[1-9]\d* valid\s+0 unknown\s+0 invalid", said):
        found.append(f"{program}: an assertion is not shown")
    return found


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent).resolve()
    return finish("prove_firmware", [p for program, sources in PROOFS.items() for p in problems(root, program, sources)])


if __name__ == "__main__":
    sys.exit(main())
