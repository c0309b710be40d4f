#!/usr/bin/env python3
"""Runs a build's tests by ctest; fails where a test was skipped and the environment does not allow it.

    scripts/run_tests.py FOLDER [--full] [ctest options]

Of the tests labelled `full` each day runs a tenth, ten days run all; --full runs all at once.
FIRN_TENTH       the tenth, 0 to 9, or `none`; the number of days since 1970-01-01 modulo 10 without it. Tests with
                 long loops read it too (tests/support/long_cases.h).
FIRN_ALLOW_SKIP  what may be skipped, separated by commas: a skip's own name (cbc, multicast, network-namespace) or a
                 test's, * for any text.
"""
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as xml

TENTHS = 10
UNKNOWN_COST_S = 60.0  # of a full test that declares no COST
REASON = re.compile(r"^skipped: (?:([\w-]+): )?(.*)$", re.M)


def tests_of(folder):
    """(number, name, labels, cost [s]) of every test, as ctest counts them."""
    out = subprocess.run(["ctest", "--test-dir", folder, "--show-only=json-v1"], check=True, stdout=subprocess.PIPE,
                         stderr=subprocess.DEVNULL, text=True).stdout
    tests = []
    for number, test in enumerate(json.loads(out)["tests"], 1):
        of = {p["name"]: p["value"] for p in test["properties"]}
        labels = {part for label in of.get("LABELS", []) for part in label.split("-")}
        tests.append((number, test["name"], labels, float(of.get("COST", UNKNOWN_COST_S))))
    return tests


def tenths(tests):
    """Names of the full tests by tenth: the most expensive first, each to the tenth that costs least so far."""
    parts, costs = [[] for _ in range(TENTHS)], [0.0] * TENTHS
    for _, name, labels, cost in sorted(tests, key=lambda test: (-test[3], test[1])):
        if "full" in labels:
            cheapest = costs.index(min(costs))
            parts[cheapest].append(name)
            costs[cheapest] += cost
    return parts, costs


def chosen_tenth(environment, now_s):
    """0 to 9, or None."""
    text = environment.get("FIRN_TENTH", "")
    if text == "none":
        return None
    if text == "":
        return int(now_s // 86_400) % TENTHS
    if not re.fullmatch("[0-9]", text):
        raise ValueError(f"FIRN_TENTH: {text!r} is neither a digit nor none")
    return int(text)


def skips(report):
    """(test, name of the skip or "", reason) of every skipped test in ctest's JUnit report."""
    found = []
    for case in xml.parse(report).getroot().iter("testcase"):
        skipped = case.find("skipped")
        message = "Disabled" if case.get("status") == "disabled" else "" if skipped is None else skipped.get("message", "")
        if message.startswith(("SKIP_", "Disabled")):
            reasons = REASON.findall(case.findtext("system-out") or "") or [("", message)]
            found += [(case.get("name"), key, reason) for key, reason in dict.fromkeys(reasons)]
    return found


def allowed(test, key, patterns):
    for pattern in filter(None, map(str.strip, patterns.split(","))):
        expression = ".*".join(re.escape(part) for part in pattern.split("*"))
        if pattern == key or re.fullmatch(expression, test):
            return True
    return False


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    folder, options = sys.argv[1], sys.argv[2:]
    environment, selection = dict(os.environ), []
    scratch = tempfile.TemporaryDirectory()
    report, numbers = os.path.join(scratch.name, "report.xml"), os.path.join(scratch.name, "numbers")
    if options[:1] == ["--full"]:
        options, environment["FIRN_FULL"] = options[1:], "1"
    else:
        try:
            tenth = chosen_tenth(environment, time.time())
        except ValueError as error:
            sys.exit(f"firn test: {error}")
        environment["FIRN_TENTH"] = "none" if tenth is None else str(tenth)
        tests = tests_of(folder)
        parts, costs = tenths(tests)
        today = set() if tenth is None else set(parts[tenth])
        if tenth is not None:
            print(f"firn test: tenth {tenth} of the long cases (FIRN_TENTH): {len(today)} of {sum(map(len, parts))} full tests, "
                  f"about {costs[tenth]:.0f} s", file=sys.stderr)
            for name in sorted(today):
                print(f"  {name}", file=sys.stderr)
        run = [str(number) for number, name, labels, _ in tests if "full" not in labels or name in today]
        if run:
            with open(numbers, "w", encoding="ascii") as out:
                out.write("0,0,0," + ",".join(run) + "\n")  # without the end of line ctest drops the last
            selection = ["-I", numbers]
    status = subprocess.run(["ctest", "--test-dir", folder, "-j2", "--output-on-failure", "--output-junit", report,
                             *selection, *options], env=environment, stdin=subprocess.DEVNULL).returncode
    found = skips(report) if os.path.exists(report) else []
    patterns, refused = environment.get("FIRN_ALLOW_SKIP", ""), 0
    for test, key, reason in found:
        good = allowed(test, key, patterns)
        refused += not good
        print(f"firn test: skipped{' (allowed)' if good else ''}: {test}: {key + ': ' if key else ''}{reason}", file=sys.stderr)
    if refused:
        print("firn test: failed, because tests were skipped that FIRN_ALLOW_SKIP does not name", file=sys.stderr)
    return status or (1 if refused else 0)


if __name__ == "__main__":
    sys.exit(main())
