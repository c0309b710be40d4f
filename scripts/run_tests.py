#!/usr/bin/env python3
"""Runs a build's tests by ctest; fails where a test was skipped and the environment does not allow it.

    scripts/run_tests.py FOLDER [--full] [ctest options]

Without --full the tests labelled `full` are left out, and long loops try few of their cases (tests/support/long_cases.h):
the same set every time.
FIRN_ALLOW_SKIP says what may be skipped, separated by commas: a skip's own name (avr, cbc, multicast, network-namespace) or a
test's, * for any text.
"""
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as xml

REASON = re.compile(r"^skipped: (?:([\w-]+): )?(.*)$", re.M)


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
    environment, selection = dict(os.environ), ["-LE", "(^|-)full(-|$)"]
    scratch = tempfile.TemporaryDirectory()
    environment.pop("FIRN_RUNS", None)
    environment["XDG_CONFIG_HOME"] = os.path.join(scratch.name, "config")  # of the user who runs the tests: no test knows it
    report = os.path.join(scratch.name, "report.xml")
    if options[:1] == ["--full"]:
        options, environment["FIRN_FULL"], selection = options[1:], "1", []
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
