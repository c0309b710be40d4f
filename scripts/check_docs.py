#!/usr/bin/env python3
"""Documents and comments name only things that exist: links, files, programs, tests, commands, options, keys.

    scripts/check_docs.py [ROOT]
"""
import re
import sys
from itertools import product
from pathlib import Path

from firn_tree import ROOMS, finish, read

PICTURES = {".png", ".svg"}
# Beside the folders of the room runs/ lie the runs and studies that were printed here.
FOLDERS = tuple(room for room in ROOMS if room != "runs") + ("runs/folder", "runs/migrate", "runs/read", "docs", "scripts", "experiments",
                                                             "labs", "cmake")

FENCE = re.compile(r"^```[^\n]*\n(.*?)^```", re.M | re.S)
INDENTED = re.compile(r"(?:^    [^\n]*\n)+", re.M)
SPAN = re.compile(r"`((?:[^`\n]|\n(?!\n))+)`")  # may go on in the next line
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ (.*)$", re.M)
NAMED = re.compile(rf"(?<![\w/.$-])((?:{'|'.join(FOLDERS)})/[\w./*{{}},+-]*)")
BUILT = re.compile(r"\bbuild/(bin|bench|tests)/(\w+)(?:\s+\"([^\"]+)\")?")
COMMAND = re.compile(r"(?:^|(?<=[\s(]))(?:\./|build/bin/)?firn +([a-z][\w-]*)([^\n]*)")
IN_SOURCES = re.compile(r"(?<![\w/.-])(docs/[\w./*-]+\.(?:md|h))")
SOURCES = {".h", ".cpp", ".py", ".toml", ".sh", ".lcm", ".java", ".txt", ".cmake", ".cff", ".ts"}
C_LIKE = {".h", ".cpp", ".lcm", ".java", ".ts"}
C_COMMENT = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
HASH_COMMENT = re.compile(r'^ *""".*?"""|""".*?"""|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|(?<![\w$\\])#[^\n]*', re.M | re.S)
MADE = {"node_modules"}
ANY_NAME = re.compile(r"[A-Z][A-Z_-]*(\.(?!md)\w+)?")
FIXTURES = ("tests/house/lints_test.py",)  # its texts are trees that break the rules
KEY_ROW = re.compile(r"^## (\[.*\])$|^\|([\w, ]+)\|", re.M)
TEST_CASE = re.compile(r'TEST_CASE\(\s*((?:"(?:[^"\\]|\\.)*"\s*)+)')


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def documents(root):
    """README.md, CONTRIBUTING.md and every page below docs/."""
    pages = [p.relative_to(root).as_posix() for p in (Path(root) / "docs").rglob("*.md")]
    return [p for p in ("README.md", "CONTRIBUTING.md") if (Path(root) / p).is_file()] + sorted(pages)


def blank(match):
    return re.sub(r"[^\n]", " ", match.group(0))


def blanked(text):
    """The prose: code keeps its length and its lines, and says nothing."""
    return SPAN.sub(blank, FENCE.sub(blank, text))


def slug(heading):
    """The anchor that GitHub gives a heading."""
    kept = re.sub(r"[^\w\- ]", "", heading.replace("`", "").strip().lower())
    return kept.replace(" ", "-")


def links(root, page):
    """(line, target file, anchor) of every link to a place in the tree."""
    text = blanked(read(root, page))
    for match in LINK.finditer(text):
        if re.match(r"[a-z]+:", match.group(1)):
            continue
        target, _, anchor = match.group(1).partition("#")
        file = (Path(root) / page).parent / target if target else Path(root) / page
        yield line_of(text, match.start()), Path(file.resolve()), anchor


def check_links(root):
    problems = []
    for page in documents(root):
        for line, file, anchor in links(root, page):
            if not file.exists():
                problems.append(f"{page}:{line}: a link to {file.name}, which does not exist")
            elif anchor and anchor not in {slug(h) for h in HEADING.findall(file.read_text(encoding="utf-8"))}:
                problems.append(f"{page}:{line}: {file.name} has no heading #{anchor}")
    return problems


def check_reached(root):
    """Every page is linked from docs/README.md, over others at most; every picture is shown by a page."""
    start, base = Path(root) / "docs" / "README.md", Path(root).resolve()
    if not start.is_file():
        return ["docs/README.md: the index of the documents is missing"]
    reached, waiting = set(), [start.resolve()]
    while waiting:
        file = waiting.pop()
        if file in reached or not file.exists():
            continue
        reached.add(file)
        if file.suffix == ".md":
            waiting += [target for _, target, _ in links(root, file.relative_to(base).as_posix())]
    shown = reached | {target for page in documents(root) for _, target, _ in links(root, page)}
    problems = [f"{page}: not linked from docs/README.md, nor from a page that is"
                for page in documents(root) if page.startswith("docs/") and (base / page) not in reached]
    pictures = [p for p in (base / "docs").rglob("*") if p.suffix in PICTURES and p not in shown]
    return problems + [f"{p.relative_to(base).as_posix()}: no page shows it" for p in sorted(pictures)]


def check_tables(root):
    """A table begins with its head; rows behind an empty line would be shown as text."""
    problems = []
    for page in documents(root):
        lines = FENCE.sub(lambda block: re.sub(r"[^\n]", "", block.group(0)), read(root, page)).split("\n") + [""]
        problems += [f"{page}:{n + 1}: a row of a table without the table's head"
                     for n, line in enumerate(lines) if line.startswith("|") and not (n and lines[n - 1].startswith("|"))
                     and not re.fullmatch(r"\|[|: -]*-[|: -]*", lines[n + 1])]
    return problems


def alternatives(path):
    """a/{b,c}.h -> a/b.h, a/c.h"""
    parts = re.split(r"\{([^{}]*)\}", path)
    choices = [part.split(",") if n % 2 else [part] for n, part in enumerate(parts)]
    return ["".join(choice) for choice in product(*choices)]


def exists(root, path):
    """As a file, a folder, a pattern, or the stem of a header and its sources; in the house or among the files that an
    example of tests/examples adds to it. A part in capitals is any name (drivers/NAME, procs/X)."""
    if "mine" in Path(path).stem or any(ANY_NAME.fullmatch(part) for part in Path(path).parts[1:]):
        return True
    example = f"tests/examples/*/{path}"
    if any(list(Path(root).glob(pattern)) for pattern in (path, path + ".*", example, example + ".*")):
        return True
    return any(f"+++ b/{path}" in patch.read_text(encoding="utf-8") for patch in Path(root).glob("tests/examples/*.patch"))


def check_named(root):
    problems = []
    for page in documents(root):
        text = re.sub(r"\]\([^)\s]*\)", lambda link: " " * len(link.group(0)), read(root, page))
        text = re.sub(r"^```diff\n.*?^```", lambda diff: "\n" * diff.group(0).count("\n"), text, flags=re.M | re.S)
        for match in NAMED.finditer(text):
            for path in alternatives(match.group(1).rstrip(".,-")):
                if not exists(root, path.rstrip("/")):
                    problems.append(f"{page}:{line_of(text, match.start())}: {path} does not exist")
    return problems


def comments(path, text):
    """(position, comment) of a source; a docstring of Python, which begins its line, is one."""
    for match in (C_COMMENT if Path(path).suffix in C_LIKE else HASH_COMMENT).finditer(text):
        token, column = match.group(0), match.start() - text.rfind("\n", 0, match.start()) - 1
        if token.startswith(("/", "#")) or token.lstrip().startswith('"""') and column == 0:
            yield match.start(), token


def check_sources(root):
    """Comments name files and folders of the house by paths that exist, and any text of a source such documents. A path of a run
    (nodes/, runs/NAME/) or of the build begins with none of FOLDERS; a folder that a package manager makes is left out."""
    problems, files = [], [Path(root) / "CMakeLists.txt"]
    for folder in FOLDERS:
        files += sorted((Path(root) / folder).rglob("*"))
    known = {}
    for file in files:
        path = file.relative_to(root).as_posix()
        if file.suffix not in SOURCES or not file.is_file() or "/golden/" in path or "/node_modules/" in path \
                or path.startswith("tests/examples/") or path in FIXTURES:
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        named = [(m.start(), m.group(1)) for m in IN_SOURCES.finditer(text)]
        named += [(start + m.start(), m.group(1).rstrip(".,-/")) for start, comment in comments(path, text) for m in NAMED.finditer(comment)]
        for position, name in sorted(set(named)):
            for one in alternatives(name):
                if one not in known:
                    known[one] = bool(MADE & set(Path(one).parts)) or exists(root, one)
                if not known[one]:
                    problems.append(f"{path}:{line_of(text, position)}: {one} does not exist")
    return problems


def lists(root):
    """The text of every CMakeLists.txt, but for those of build folders."""
    files = [f for f in sorted(Path(root).rglob("CMakeLists.txt")) if not f.relative_to(root).parts[0].startswith("build")]
    return "\n".join(f.read_text(encoding="utf-8") for f in files)


def test_names(root):
    names = []
    for file in (Path(root) / "tests").rglob("*.cpp"):
        for match in TEST_CASE.finditer(file.read_text(encoding="utf-8")):
            names.append("".join(re.findall(r'"((?:[^"\\]|\\.)*)"', match.group(1))))
    return names


def check_programs(root):
    """Programs of the build, and the tests that a page runs by name."""
    known, problems, names = lists(root), [], test_names(root)
    made = {"bin": r"firn_process|add_executable", "bench": r"firn_bench", "tests": r"firn_test"}
    for page in documents(root):
        text = read(root, page)
        for match in BUILT.finditer(text):
            folder, program, test = match.groups()
            where = f"{page}:{line_of(text, match.start())}"
            if not re.search(rf"(?:{made[folder]})\(\s*{program}\b", known):
                problems.append(f"{where}: nothing makes build/{folder}/{program}")
            elif folder == "tests" and test and not test.startswith("["):
                pattern = re.compile(".*".join(re.escape(part) for part in test.split("*")))
                if not any(pattern.fullmatch(name) for name in names):
                    problems.append(f"{where}: no test is called \"{test}\"")
    return problems


def calls(text):
    """(position, command, rest of the line) of every call of firn in code."""
    prose = FENCE.sub(blank, text)
    blocks = [(m.start(), m.group(1)) for m in FENCE.finditer(text)]
    blocks += [(m.start(), m.group(0)) for m in INDENTED.finditer(prose)]
    blocks += [(m.start(), m.group(1).replace("\n", " ")) for m in SPAN.finditer(prose)]
    for start, body in blocks:
        for match in COMMAND.finditer(body.replace("\\\n", "  ")):
            yield start, match.group(1), re.split(r"&&|[|;]|\s#\s|`| (?:\./)?firn ", match.group(2))[0]


def keys(root):
    """section.key of every generated table."""
    found = set()
    for page in ("configuration", "machines", "slice-settings"):
        file, sections = Path(root) / "docs" / f"{page}.md", []
        for match in KEY_ROW.finditer(file.read_text(encoding="utf-8") if file.is_file() else ""):
            sections = re.findall(r"\[([\w.]+)\]", match.group(1)) if match.group(1) else sections
            found.update(f"{s}.{key}" for s in sections for key in (match.group(2) or "").split(", "))
    for example in sorted((Path(root) / "tests" / "docs").glob("*.h")):  # the scheme of a tutorial
        found.update(f"control.extra.{name}" for name in re.findall(r'ExtraOption\{"(\w+)"', example.read_text(encoding="utf-8")))
    return found


def is_bench(root, name):
    folder = Path(root) / "tests" / "bench"
    return (folder / f"{name}.sh").is_file() or bool(re.search(rf"firn_(bench|test)\({name}\b", lists(root)))


def check_commands(root):
    commands = {f.stem.removesuffix("_command") for f in (Path(root) / "cli").glob("*_command.cpp")} | {"test", "python", "package"}
    declared = "\n".join(f.read_text(encoding="utf-8") for f in sorted((Path(root) / "cli").glob("*.cpp")))
    wrapper = Path(root) / "firn"
    declared += wrapper.read_text(encoding="utf-8") if wrapper.is_file() else ""
    options, settable, problems = set(re.findall(r"--[\w-]+", declared)) | {"--help"}, keys(root), []
    for page in documents(root):
        text = read(root, page)
        for position, command, rest in calls(text):
            where = f"{page}:{line_of(text, position)}"
            if command == "bench":  # its options are its own
                name = rest.split()[0] if rest.split() else ""
                if name and name.islower() and not is_bench(root, name):
                    problems.append(f"{where}: there is no bench {name}")
                continue
            if command not in commands:
                problems.append(f"{where}: firn has no command {command}")
            problems += [f"{where}: no command has the option {option}"
                         for option in re.findall(r"(?<![\w-])(--[a-z][\w-]*)", rest) if option not in options]
        problems += [f"{page}:{line_of(text, m.start())}: there is no key {m.group(1)}"
                     for m in re.finditer(r"--set \"?([a-z][\w.]*)=", text) if m.group(1) not in settable]
    return problems


def tagged_tests(root):
    """tag -> programs: test_X holds the files of tests/X."""
    programs = {}
    for file in (Path(root) / "tests").rglob("*.cpp"):
        room = file.relative_to(Path(root) / "tests").parts[0]
        for tags in re.findall(r'TEST_CASE\(\s*(?:"(?:[^"\\]|\\.)*"\s*)+,\s*"([^"]*)"', file.read_text(encoding="utf-8")):
            for tag in re.findall(r"\[I[\d-]+\]", tags):
                programs.setdefault(tag, set()).add(f"test_{room}")
    return programs


def check_interlocks(root):
    """Each row of the interlocks' table has test cases of its tag, [I6], in the programs that its last column names."""
    page, tests, problems, rows = "docs/safety.md", tagged_tests(root), [], set()
    if not (Path(root) / page).is_file():
        return []
    text = read(root, page)
    for match in re.finditer(r"^\|([\d-]+)\|(?=[^-\n]).*\|([^|\n]*)\|$", text, re.M):
        tag = f"[I{match.group(1)}]"
        rows.add(tag)
        named = set(match.group(2).split(", "))
        if named != tests.get(tag, set()):
            problems.append(f"{page}:{line_of(text, match.start())}: interlock {match.group(1)} names {sorted(named)}, "
                            f"test cases tagged {tag} are in {sorted(tests.get(tag, set()))}")
    words = "page/event_words.cpp"
    if (Path(root) / words).is_file():
        shown = {f"[I{code}]" for code in re.findall(r"^    \{(\d+), \"", read(root, words), re.M)}
        problems += [f"{words}: has no words for interlock {tag}" for tag in sorted(rows - shown - {"[I-]"})]
    return problems + [f"{page}: a test case is tagged {tag}, which is no interlock" for tag in sorted(set(tests) - rows)]


CHECKS = (check_links, check_reached, check_tables, check_named, check_sources, check_programs, check_commands, check_interlocks)


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    return finish("check_docs", [problem for check in CHECKS for problem in check(root)])


if __name__ == "__main__":
    sys.exit(main())
