"""The source tree as the lints see it: files of the house, without build folders, and C++ without comments."""
import re
from pathlib import Path

ROOMS = ("core", "lcmtypes", "files", "config", "estimators", "drivers", "runtime", "plant", "runs", "procs", "replay", "report",
         "print", "studies", "page", "cli", "python", "tests")
CPP = {".h", ".cpp"}
_TOKENS = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)


def sources(root, rooms=ROOMS, suffixes=CPP):
    """Paths relative to `root`, as strings with '/', in order; recorded runs are data, in tests/replay/golden and, beside the room's
    folders, in runs/<utc>-<name>; what examples add to a copy of the house is not built here."""
    found = []
    for room in rooms:
        folder = Path(root) / room
        found += [p.relative_to(root).as_posix() for p in folder.rglob("*") if p.suffix in suffixes and p.is_file()]
    return sorted(path for path in found if "/golden/" not in path and not path.startswith("tests/examples/")
                  and not re.match(r"runs/[^/]*-", path))


def read(root, path):
    return (Path(root) / path).read_text(encoding="utf-8")


def code(text, keep_strings=False):
    """C++ with comments (and strings, unless kept) blanked; line numbers stay."""
    def blank(match):
        token = match.group(0)
        if keep_strings and not token.startswith("/"):
            return token
        return ("" if token.startswith("/") else '""') + "\n" * token.count("\n")
    return _TOKENS.sub(blank, text)


def finish(name, problems):
    """Prints the problems and returns the exit code."""
    for problem in problems:
        print(f"{name}: {problem}")
    print(f"{name}: {len(problems)} problem(s)" if problems else f"{name}: ok")
    return 1 if problems else 0
