#!/usr/bin/env python3
"""Cost of a long run, row by row: user + system time and peak memory of each command, for one or more numbers of layers.

Prints under SMF on 40 x 40 cells, in one process. With --against, the commands of another firn
are measured in turn with those of this one, so that both meet the same load of the machine; medians over --rounds.
"""
import argparse
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LAYER_MM = 7.6e-3  # of the paper's droplets


def measured(command):
    """(user + system time [s], peak memory [MB], exit status, what it says on stderr) of a command."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True)
    error = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, child.returncode, error.strip()


class Bench:
    def __init__(self, given, folder):
        self.given, self.folder, self.shown = given, Path(folder), {}

    def print_command(self, firn, layers, name, plain):
        into = self.folder / name
        cells = self.given.cells
        sets = [f"part.height_mm={layers * LAYER_MM:.4f}", f"process.nozzle_gap_mm={1 + layers * LAYER_MM:.4f}",
                f"grid.nx={cells}", f"grid.ny={cells}", f"control.max_layers={2 * layers}"]
        return into, [firn, "print", ROOT / "experiments" / "cylinder.toml", "--bus", "in-process", "--runs", into, "--set",
                      "control.scheme=" + self.given.scheme, *(x for s in sets for x in ("--set", s)), *(["--plain"] if plain else [])]

    def run_of(self, kind, layers):
        """A run folder, printed once."""
        key = (kind, layers)
        if key not in self.shown:
            into, command = self.print_command(self.given.firn, layers, f"{kind}-{layers}", kind != "packed")
            error = measured(command)[-1]
            if not list(into.glob("*/result.json")):
                sys.exit(f"the print failed: {error}")
            self.shown[key] = next(into.glob("*"))
        return self.shown[key]

    def rows(self, layers):
        """(name, command made for a program, bytes it is measured by)."""
        plain, packed = (lambda: self.run_of("plain", layers)), (lambda: self.run_of("packed", layers))
        out = self.folder / "out"
        log = lambda run: (run / "log.lcm").stat().st_size
        return [
            ("print-plain", lambda firn: self.print_command(firn, layers, "again", True)[1], None),
            ("print-packed", lambda firn: self.print_command(firn, layers, "again", False)[1], None),
            ("replay-plain", lambda firn: [firn, "replay", plain()], None),
            ("replay-packed", lambda firn: [firn, "replay", packed()], None),
            ("audit-plain", lambda firn: [firn, "audit", plain()], None),
            ("audit-packed", lambda firn: [firn, "audit", packed()], None),
            ("report", lambda firn: [firn, "report", plain(), "--no-replay", "-o", f"{out}.html"], None),
            ("report-packed", lambda firn: [firn, "report", packed(), "--no-replay", "-o", f"{out}.html"], None),
            ("identify", lambda firn: [firn, "identify", plain()], None),
            ("export-h5", lambda firn: [firn, "export", plain(), "-o", f"{out}.h5"], lambda: log(plain())),
            ("export-mcap", lambda firn: [firn, "export", plain(), "-o", f"{out}.mcap"], lambda: log(plain())),
            ("export-csv", lambda firn: [firn, "export", plain(), "-o", f"{out}.csv"], lambda: log(plain())),
        ]

    def clean(self):
        for path in [self.folder / "again", *self.folder.glob("out*")]:
            subprocess.run(["rm", "-rf", path], check=True)

    def go(self):
        programs = [self.given.firn] + ([self.given.against] if self.given.against else [])
        print(f"{'layers':>7} {'row':15}" + "".join(f"{'s':>10}{'MB':>8}{'MB/s':>8}" for _ in programs)
              + ("    of the other" if len(programs) > 1 else "") + "   exponent", flush=True)
        before = {}
        for layers in self.given.layers:
            for name, command, size in self.rows(layers):
                if self.given.rows and not any(name.startswith(w) for w in self.given.rows):
                    continue
                times = {p: [] for p in programs}
                memory = dict.fromkeys(programs, 0.0)
                for _ in range(self.given.rounds):
                    for program in programs:
                        self.clean()
                        made = command(program)
                        seconds, peak, status, error = measured(made)
                        if status not in (0, 1, 4):
                            sys.exit(f"{' '.join(map(str, made))}: exit status {status}: {error}")
                        times[program].append(seconds)
                        memory[program] = max(memory[program], peak)
                        self.clean()
                medians = [statistics.median(times[p]) for p in programs]
                line = f"{layers:7d} {name:15}"
                for program, seconds in zip(programs, medians):
                    line += f"{seconds:10.2f}{memory[program]:8.0f}" + (f"{size() / 1e6 / seconds:8.0f}" if size else " " * 8)
                if len(programs) > 1:
                    line += f"{medians[0] / medians[1]:15.2f}"
                if name in before:
                    line += f"{math.log(medians[0] / before[name][1]) / math.log(layers / before[name][0]):11.2f}"
                before[name] = layers, medians[0]
                print(line, flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--layers", type=lambda s: [int(n) for n in s.split(",")], default=[250, 500, 1000])
    arguments.add_argument("--rows", type=lambda s: s.split(","), default=[], help="beginnings of names; default: all")
    arguments.add_argument("--rounds", type=int, default=1)
    arguments.add_argument("--cells", type=int, default=40, help="along each side of the grid")
    arguments.add_argument("--scheme", default="smf")
    arguments.add_argument("--firn", default=str(ROOT / "build" / "bin" / "firn"))
    arguments.add_argument("--against", help="another build's firn")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        Bench(given, folder).go()


if __name__ == "__main__":
    main()
