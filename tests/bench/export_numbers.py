#!/usr/bin/env python3
"""Every number of an exported run beside that of `firn log cat`, message by message: for runs of any size.

    tests/bench/export_numbers.py FIRN RUN FILE.h5
"""
import json
import subprocess
import sys
from pathlib import Path

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "cli"))
from export_test import members, same  # noqa: E402


class Rows:
    """Rows of one table in the order of the log; a column is read when it is asked for first."""

    def __init__(self, group):
        self.group, self.columns, self.at = group, {}, 0
        self.events = group["log_event"][()]

    def __getitem__(self, name):
        if name not in self.columns:
            self.columns[name] = self.group[name] if self.group[name].ndim == 3 else self.group[name][()]
        return self.columns[name]

    def has(self, event):
        return self.at < len(self.events) and self.events[self.at] == event

    def differences(self, event):
        row, wrong = self.at, []
        self.at += 1
        if int(self["log_utime_us"][row]) != event["utime_us"]:
            wrong.append("log_utime_us")
        for name, expected in members(event["message"]).items():
            values = self[name]
            if not isinstance(expected, list):
                equal = same(expected, values[row])
            else:
                first = int(self[name + "_first"][row]) if values.ndim != 3 else 0
                values = values[row].ravel() if values.ndim == 3 else values[first:first + int(self[name + "_count"][row])]
                equal = len(values) == len(expected) and all(same(e, v) for e, v in zip(expected, values))
            if not equal:
                wrong.append(name)
        return wrong


def main():
    firn, run, file = sys.argv[1:]
    tables = {}

    def keep(name, node):
        if isinstance(node, h5py.Group) and "log_event" in node:
            tables[name.split("/")[-1]] = Rows(node)

    h5py.File(file, "r").visititems(keep)
    count = wrong = 0
    log = subprocess.Popen([firn, "log", "cat", Path(run) / "log.lcm", "--full"], stdout=subprocess.PIPE, text=True)
    for line in log.stdout:
        event = json.loads(line)
        rows = [t for name, t in tables.items() if name.startswith(event["channel"]) and t.has(event["event"])]
        differences = rows[0].differences(event) if len(rows) == 1 else [f"{len(rows)} rows"]
        count += 1
        wrong += bool(differences)
        if differences and wrong < 20:
            print(f"{event['channel']} {event['event']}: {', '.join(differences)}")
    left = sum(len(t.events) - t.at for t in tables.values())
    if log.wait() or not count or left:
        print(f"{left} rows that no message has")
        wrong += 1
    print(f"{count} messages, {wrong} differ")
    return wrong != 0


if __name__ == "__main__":
    sys.exit(main())
