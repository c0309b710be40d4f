"""Rows of a study's runs.csv: prints, layers, stops by cause, and what a false stop's rate is at most."""
import csv
import math
import re


def rows(folder):
    with open(folder / "runs.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def layers_of(prints):
    """@returns layers begun; a print that was cut short counts those it printed"""
    return sum(int(float(p["layers"])) for p in prints if p["layers"] not in ("", "nan"))


def stopped(print_):
    return print_["finished"] == "0"


def cause(print_):
    """@returns the reason of a stop without its numbers, so that equal causes are equal texts"""
    return re.sub(r"-?\d+(\.\d+)?", "#", print_["reason"])


def by_cause(prints, outcome=""):
    """@returns {cause: prints that stopped by it}; with an outcome those that ended with this one alone"""
    found = {}
    for p in prints:
        if stopped(p) and (not outcome or p["outcome"] == outcome):
            found[cause(p)] = found.get(cause(p), 0) + 1
    return found


def most(events, confidence=0.95):
    """@returns the upper confidence limit of a Poisson mean of which `events` were seen: 3.00 for none (rule of three)"""
    low, high = 0.0, 10.0 + 5.0 * events
    for _ in range(100):
        mean = 0.5 * (low + high)
        term = total = math.exp(-mean)
        for k in range(1, events + 1):
            term *= mean / k
            total += term
        low, high = (mean, high) if total > 1.0 - confidence else (low, mean)
    return high
