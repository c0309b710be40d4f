#!/usr/bin/env python3
"""The rules of the house that a compiler does not check: same bytes, sizes, nothing unfinished, nothing unlisted.

    scripts/check_house.py [ROOT]
"""
import keyword
import re
import runpy
import sys
from pathlib import Path

import test_names
from firn_tree import ROOMS, code, finish, read, sources

MAX_LINES, MAX_MAIN_LINES, MAX_COLUMNS = 600, 60, 110

# Where the same input must give the same bytes. Processes outside replay (bus, recorder, launcher) may read clocks.
OUTSIDE_REPLAY = ("procs/bus/", "procs/recorder/", "procs/relay/", "procs/launcher/", "procs/runner/")
PURE_ROOMS = ("core", "estimators", "drivers", "plant", "procs")

FORBIDDEN = {
    "a clock": r"<chrono>|<ctime>|<time\.h>|<sys/time\.h>|\bclock_gettime\b|\bgettimeofday\b|\bstd::time\b|_clock::now\b"
               r"|rdtscp?\b",
    "a thread": r"<thread>|<mutex>|<atomic>|<future>|<condition_variable>|<pthread\.h>|\bpthread_\w+|\bstd::(j?thread|async)\b"
                r"|\bsetNumThreads\b|\bthread_local\b",
    "sleeping": r"\b(?:u|nano)?sleep(?:_for|_until)?\s*\(",
    "randomness that is not keyed": r"<random>|\bstd::rand\b|\bs?rand\s*\(|\brandom_device\b|\bmt19937(_64)?\b|\bgetrandom\b|\bdrand48\b"
                                    r"|\bminstd_rand0?\b|\branlux\w+|\bdefault_random_engine\b|\bknuth_b\b",
    "a library-defined distribution or shuffle": r"(?<!boost::math::)\b\w+_distribution\b|\bshuffle\b|\bstd::(ranges::)?sample\b",
    "a name for std, behind which nothing here is found": r"\bnamespace\s+\w+\s*=\s*(?:::)?std\b(?!::)|\busing\s+namespace\s+(?:::)?std\s*;",
    "a time limit": r"\bmaxtime\b|\bset_maxtime\b",
    "a search whose steps depend on the CPU": r"\b(?:NLOPT_)?GN_ISRES\b",
    "a file": r"<fstream>|<filesystem>|\bfopen\s*\(",
    "the environment": r"\bgetenv\b",
}
# Last bits of these differ between CPUs with and without FMA. What a node decides must not depend on them
# (core/exact has such functions for it).
EXACT_ROOMS = ("core/deposition/", "core/control/", "core/motion/", "core/planning/", "core/slice/", "procs/")
INEXACT = re.compile(r"(?<!exact::)\b(?:std::)?(?:exp|exp2|expm1|log|log2|log10|log1p|pow|sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|cbrt|hypot)[fl]?\s*\(")

UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b|\bplaceholder\b", re.I)
HIDDEN_TEST = re.compile(r'TEST_CASE\([^)]*"\s*,\s*"[^"]*\[(?:\.|!hide|!mayfail|!shouldfail)')
EMPTY_TEST = re.compile(r'TEST_CASE\((?:[^()]|\([^()]*\))*\)\s*\{\s*\}')
PRIVATE_PATH = re.compile(r"(?<![\w.])/(?:work|home|root|Users)/\w")

# SIM_TRUTH: declared, published by whoever runs the world, read by tests, audit, reports and exports.
TRUTH = re.compile(r"SIM_TRUTH|\bkSimTruth\b|\bsim_truth_t\b")
TRUTH_READERS = ("lcmtypes/", "tests/", "replay/audit", "runs/folder/truth_check", "runs/read/truth", "report/run/", "report/export/", "cli/audit")
TRUTH_PUBLISHERS = ("print/", "plant/")
TRUTH_DECODE = re.compile(r"sim_truth_t\s+\w+\s*;[^}]*?\.decode\s*\(|subscribe\s*\(\s*channels::kSimTruth", re.S)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def is_pure(path):
    return path.split("/")[0] in PURE_ROOMS and not path.startswith(OUTSIDE_REPLAY) \
        and not path.endswith("/main.cpp") and not path.startswith(("plant/world/setup.", "plant/world/serve"))


def check_same_bytes(root):
    problems = []
    for path in sources(root, PURE_ROOMS):
        if not is_pure(path):
            continue
        text = code(read(root, path))
        for what, pattern in FORBIDDEN.items():
            if what == "a file" and path.startswith("plant/"):
                continue  # nature keeps its own record of what happened
            for match in re.finditer(pattern, text):
                problems.append(f"{path}:{line_of(text, match.start())}: {what} ({match.group(0).strip()})")
        if path.startswith(EXACT_ROOMS):
            for match in INEXACT.finditer(text):
                problems.append(f"{path}:{line_of(text, match.start())}: inexact function {match.group(0).strip()}…): its last bit "
                                "depends on the CPU")
        problems += unordered_iteration(root, path, text)
    return problems


def unordered_iteration(root, path, text):
    """Loops over anything that this file or its header declares as an unordered container."""
    header = Path(root) / re.sub(r"\.cpp$", ".h", path)
    declared_in = text + (code(header.read_text(encoding="utf-8")) if path.endswith(".cpp") and header.is_file() else "")
    names = set(re.findall(r"unordered_(?:map|set|multimap|multiset)\s*<[^;{}()]*>[&\s]+(\w+)", declared_in))
    return [f"{path}:{line_of(text, m.start())}: iterates over the unordered container {name}"
            for name in sorted(names)
            for m in re.finditer(rf"for\s*\([^;)]*:\s*{name}\s*\)|\b{name}\.c?begin\s*\(", text)]


def check_sizes(root):
    problems = []
    for path in sources(root, suffixes={".h", ".cpp", ".py", ".lcm"}) + sources(root, ("scripts",), {".py", ".sh"}):
        lines = read(root, path).count("\n")
        limit = MAX_MAIN_LINES if path.endswith("/main.cpp") else MAX_LINES
        if lines > limit:
            problems.append(f"{path}: {lines} lines, the limit is {limit}")
    return problems


def check_finished(root):
    problems = []
    files = sources(root, suffixes={".h", ".cpp", ".py", ".lcm", ".txt"}) + sources(root, ("cmake", "scripts"), {".cmake", ".py", ".sh"})
    for path in files:
        if path in ("scripts/check_house.py", "tests/house/lints_test.py"):
            continue  # they name what they look for
        text = read(root, path)
        for pattern, what in ((UNFINISHED, "unfinished"), (HIDDEN_TEST, "hidden test"), (EMPTY_TEST, "empty test"),
                              (PRIVATE_PATH, "absolute path of one machine")):
            for match in pattern.finditer(text):
                problems.append(f"{path}:{line_of(text, match.start())}: {what} ({match.group(0)[:40]})")
    return problems


def check_test_names(root):
    """CMake's lists would take such a name apart, and ctest would run nothing under either half."""
    return [f"{path}:{line_of(read(root, path), at)}: a test's name has ';' or a single bracket ({name[:40]})"
            for path, at, name in test_names.names(root) if ";" in name or name.count("[") != name.count("]")]


def check_listed(root):
    """Every .cpp stands in the CMakeLists.txt of its folder or of one above it or in a list of cmake/; lcmtypes/ takes
    every .lcm that it holds."""
    problems = []
    tables = " ".join(re.sub(r"#[^\n]*", "", file.read_text(encoding="utf-8"))
                      for file in sorted((Path(root) / "cmake").glob("*.cmake")))
    in_tables = set(tables.replace(")", " ").split())
    for path in sources(root, suffixes={".cpp", ".lcm"}):
        folder = (Path(root) / path).parent
        listed = re.fullmatch(r"lcmtypes/\w+_t\.lcm", path) is not None or any(path.endswith("/" + name) for name in in_tables)
        while not listed and folder != Path(root).parent:
            lists = folder / "CMakeLists.txt"
            name = (Path(root) / path).relative_to(folder).as_posix()
            listed = lists.is_file() and re.search(rf"(?<![\w/.]){re.escape(name)}(?![\w.])",
                                                   re.sub(r"#[^\n]*", "", lists.read_text(encoding="utf-8"))) is not None
            folder = folder.parent
        if not listed:
            problems.append(f"{path}: stands in no CMakeLists.txt")
    return problems


NAMESPACE = re.compile(r"^namespace(?: ([\w:]+))? \{(?!.*\})|^\}  // namespace|^(?:struct|class|enum class) (\w+)(?: final)?(?: :[^:].*)? \{", re.M)


def check_type_names(root):
    """Two types of one name in one namespace: no compiler sees both, and the linker takes the one's std::vector for the other's.
    Nor may firn:: and firn::drivers:: share a name."""
    places = {}
    for path in sources(root):
        spaces = []
        for match in NAMESPACE.finditer(read(root, path)):
            if match.group(0).startswith("namespace"):
                spaces.append(match.group(1))
            elif match.group(0).startswith("}"):
                del spaces[-1:]
            elif None not in spaces:
                places.setdefault("::".join([*spaces, match.group(2)]), set()).add(path)
    problems = [f"{sorted(where)[0]}: {name} is another type in {', '.join(sorted(where)[1:])}" for name, where in sorted(places.items()) if len(where) > 1]
    for name, where in sorted(places.items()):  # code of firn:: that uses the drivers' namespace would have to qualify both
        outer = name.replace("firn::drivers::", "firn::")
        if name.startswith("firn::drivers::") and outer in places:
            problems.append(f"{sorted(where)[0]}: {name} has the name of {outer} in {', '.join(sorted(places[outer]))}")
    return problems


def check_messages_begin_empty(root):
    """lcm-gen's structs leave their numbers as they were in memory: a message is made with {}, or a field that its maker does not
    know carries any bytes, and the receiver refuses it."""
    types = "|".join(sorted(p.stem for p in (Path(root) / "lcmtypes").glob("*_t.lcm"))) or "none_t"
    made = re.compile(rf"^\s*(?:const )?(?:firn::)?(?:{types}) \w+;", re.M)
    found = []
    for path in sources(root):
        text = code(read(root, path))
        found += [f"{path}:{line_of(text, m.end())}: {m.group(0).strip()} a message is made with {{}}" for m in made.finditer(text)]
    return found


OWN_SPACE = re.compile(r"^namespace firn::(\w+)[\w:]* \{(.*?)^\}", re.M | re.S)
DECLARATION = re.compile(r"(?:class|struct|enum class) \w+;|namespace [\w:]+ \{|\}|\s+")


def check_namespaces(root):
    """A namespace below firn is named after a folder of its file's path or after the file. Types that another room defines may be
    declared in their own namespace."""
    problems = []
    for path in sources(root):
        words = set(re.split(r"[/_.]", path)) | set(path.split("/")) | {Path(path).stem}
        text = code(read(root, path))
        for match in OWN_SPACE.finditer(text):
            if match.group(1) not in words | {"detail"} and not path.startswith("tests/") and DECLARATION.sub("", match.group(2)):
                problems.append(f"{path}:{line_of(text, match.start())}: namespace firn::{match.group(1)} names no folder of the path")
    return problems


MEMBER = re.compile(r"^(?!#|//|/\*|using |namespace |return )[^\s;={}][^\n;={}]*?(?<![\w:<])((?:\w+(?:<[^<>\n]*>)?::)+)~?(?:operator[^\w(]{1,3}|\w+)\("
                    r"|^((?:\w+(?:<[^<>\n]*>)?::)+)~?\w+\(", re.M)
MAX_CLASS_SOURCES = 2


def check_class_sources(root):
    """A class lives in one header and one or two sources: what needs a third is a type of its own. Members of a class within a
    class count for the outer one."""
    places = {}
    for path in sources(root, suffixes={".cpp"}):
        if path.startswith("tests/"):
            continue
        text = read(root, path)
        spaces = []
        for match in sorted([*NAMESPACE.finditer(text), *MEMBER.finditer(text)], key=lambda m: m.start()):
            if match.re is NAMESPACE and match.group(0).startswith("namespace"):
                spaces.append(match.group(1))
            elif match.re is NAMESPACE and match.group(0).startswith("}"):
                del spaces[-1:]
            elif match.re is MEMBER and None not in spaces:
                names = re.findall(r"(\w+)(?:<[^<>\n]*>)?::", match.group(1) or match.group(2))
                inner = next((n for n, name in enumerate(names) if name[0].isupper()), None)  # namespaces are snake_case
                if inner is not None:
                    places.setdefault("::".join([*spaces, *names[:inner + 1]]), {})[path] = None
    return [f"{min(where)}: {name} has members in {len(where)} sources, the limit is {MAX_CLASS_SOURCES}: {', '.join(sorted(where)[1:])} too"
            for name, where in sorted(places.items()) if len(where) > MAX_CLASS_SOURCES]


def check_truth(root):
    problems = []
    for path in sources(root):
        if path.startswith(TRUTH_READERS):
            continue
        text = code(read(root, path), keep_strings=True)
        publisher = path.startswith(TRUTH_PUBLISHERS)
        pattern = TRUTH_DECODE if publisher else TRUTH
        for match in pattern.finditer(text):
            problems.append(f"{path}:{line_of(text, match.start())}: only tests, audit and reports read SIM_TRUTH")
    return problems


HIDDEN = re.compile(r"^namespace \{\n(.*?)^\}  // namespace\n", re.M | re.S)
HIDDEN_FUNCTION = re.compile(r"^(?:\[\[\w+\]\] )?(?:template <[^\n]*>\n)?(?:(?:static|inline|constexpr|const) )*[A-Za-z_][\w:<>,&*\[\] ]*?[ &*](\w+)"
                             r"\(([^;{}]*?)\)[^;{}]*\{", re.M)


def parameters(text):
    for inner in (r"\([^()]*\)", r"\{[^{}]*\}", r"<[^<>]*>", r"<[^<>]*>", r"<[^<>]*>"):
        text = re.sub(inner, "", text)
    return text.count(",") + 1 if text.strip() else 0


def batch_groups(root):
    """(path, group) of sources that may be compiled in one batch, as cmake/firn.cmake makes them: those of one firn_library, BY_FOLDER
    those of one folder of it. What a list of cmake/ names belongs to the library of its CMakeLists.txt that takes a list."""
    for lists in sorted(Path(root).rglob("CMakeLists.txt")):
        folder = lists.parent.relative_to(root).as_posix()
        if folder.split("/")[0] in ROOMS and not folder.startswith("tests"):
            text = re.sub(r"#[^\n]*", "", lists.read_text(encoding="utf-8"))
            alone = set(" ".join(re.findall(r"firn_alone\(([^)]*)\)", text)).split())
            libraries = [body.split() for body in re.findall(r"firn_library\(([^)]*)\)", text)]
            listed = {word for words in libraries for word in words}
            deeper = [p.parent.relative_to(root).as_posix() + "/" for p in lists.parent.rglob("CMakeLists.txt") if p != lists]
            others = [path[len(folder) + 1:] for path in sources(root, (folder,), {".cpp"}) if not path.startswith(tuple(deeper))]
            others = [name for name in others if name not in listed and not name.endswith("main.cpp")]
            for words in libraries:
                names = [w for w in words if w.endswith(".cpp")] + (others if any("${FIRN_" in w for w in words) else [])
                for name in names:
                    path = f"{folder}/{name}"
                    if name not in alone and "$" not in name and (Path(root) / path).is_file():
                        yield path, (folder, words[0], path.rsplit("/", 1)[0] if "BY_FOLDER" in words else "")


def check_hidden_functions(root):
    """Sources of one library are compiled several at a time: two hidden functions of one name and as many parameters become
    overloads of each other where they meet, and which sources meet changes with every new one."""
    places = {}
    for path, group in batch_groups(root):
        for hidden in HIDDEN.finditer(read(root, path)):
            for function in HIDDEN_FUNCTION.finditer(code(hidden.group(1))):
                key = (*group, function.group(1), parameters(function.group(2)))
                places.setdefault(key, {})[path] = None
    return [f"{min(where)}: {name}, a hidden function of {count} parameter(s), stands in {', '.join(sorted(where)[1:])} too"
            for (*_, name, count), where in sorted(places.items()) if len(where) > 1 and name not in ("if", "for", "while", "switch", "return")]


def check_protocol(root):
    """The names and numbers that the browser's sources have are those of page/protocol.table."""
    script, made = Path(root) / "page/protocol.py", "web/src/generated/protocol.ts"
    if not script.is_file() or read(root, made) == runpy.run_path(str(script))["typescript"]():
        return []
    return [f"{made}: is not what page/protocol.table gives: run python3 page/protocol.py {made}, then npm run build in web/"]


# Names of the files of a run folder, alone in a literal or joined to a path. A node names the text that it is handed in its errors.
LAYOUT = "files/run_paths.h"
# The format of packed files itself names the log; what makes a folder one of a run lies below the layout.
LAYOUT_EXCEPTIONS = ("tests/", "files/record/packed.cpp", "files/record/open_file.h")
LAYOUT_NAME = re.compile(r'(?<!config_toml, )"/?(?:nodes/)?(?:experiment\.toml|provenance\.json|result\.json|sources\.diff|log\.lcm(?:\.idx)?|world\.rec'
                         r'|metrics\.csv|\.wal|\.sent)"|"(?:nodes|inputs|io|world|seals)/[^"\n]*"|/ "(?:nodes|inputs|io|seals|clocks)"|/ "world" /')


def check_layout(root):
    """The layout of a run folder stands in one header."""
    problems = []
    for path in sources(root):
        if path != LAYOUT and not path.startswith(LAYOUT_EXCEPTIONS):
            text = code(read(root, path), keep_strings=True)
            problems += [f"{path}:{line_of(text, match.start())}: {match.group()}: {LAYOUT} names the files of a run"
                         for match in LAYOUT_NAME.finditer(text)]
    return problems


# A table of words: `kWords[] = {"a", ...` or `kWords{{"a", 1}, ...`, and its use by a number.
WORD_TABLE = re.compile(r'\b(k[A-Z]\w*)\s*(?:\[[^\]]*\])?\s*=?\s*\{+\s*""')
WORD_BY_NUMBER = re.compile(r"\b(k[A-Z]\w*)(?:\[(?:std::)?(?:size_t|int)\(|\.at\()|\b(?:word|name)_of\((k[A-Z]\w*),")


def check_tables(root):
    """A table of words beside an enumeration has a static_assert of its size, which a new enumerator fails. Where an option
    struct holds the enumeration, config/field_rows.h has it."""
    problems = []
    for path in sources(root, tuple(room for room in ROOMS if room != "tests")):
        text = code(read(root, path))
        tables = set(WORD_TABLE.findall(text))
        used = {}
        for match in WORD_BY_NUMBER.finditer(text):
            used.setdefault(match.group(1) or match.group(2), match.start())
        problems += [f"{path}:{line_of(text, at)}: {name} is read by a number, and no static_assert compares its size with kTableSize<>"
                     for name, at in used.items() if name in tables and not re.search(rf"static_assert\([^;]*\b{name}\b", text)]
    return problems


# A member of a message becomes an identifier of each language for which lcm-gen writes a type.
RESERVED = frozenset(keyword.kwlist) | frozenset("""
alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class co_await co_return co_yield
compl concept const const_cast consteval constexpr constinit continue decltype default delete do double dynamic_cast else enum explicit
export extern false float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private
protected public register reinterpret_cast requires restrict return short signed sizeof static static_assert static_cast struct switch
template this thread_local throw true try typedef typeid typename union unsigned using virtual void volatile wchar_t while xor xor_eq
abstract assert boolean byte extends final finally implements import instanceof interface native null package strictfp super synchronized
throws transient""".split())
MESSAGE_MEMBER = re.compile(r"^\s+[\w.]+\s+(\w+)\s*(?:\[[^\]]*\]\s*)*;", re.M)


def check_members(root):
    """No member of a message is a reserved word of C, C++, Python or Java."""
    problems = []
    for path in sources(root, ("lcmtypes",), {".lcm"}):
        text = re.sub(r"//[^\n]*", "", read(root, path))
        problems += [f"{path}:{line_of(text, match.start(1))}: {match.group(1)} is a reserved word of a language that messages have types in"
                     for match in MESSAGE_MEMBER.finditer(text)
                     if match.group(1) in RESERVED]
    return problems


# Text is read as a number in one place, so that "2,5", "2.5mm" and "1e" are refused everywhere.
NUMBER_READER = re.compile(r"\b(?:from_chars|strto(?:d|f|ld|l|ll|ul|ull|imax|umax)|sto(?:i|l|ll|ul|ull|f|d|ld)|ato(?:i|l|ll|f)|sscanf)\s*\(")
NUMBER_EXCEPTIONS = {
    "core/options/number.cpp",
    "cli/options.cpp",  # looks at what the library of the command line read
    "files/mesh/mesh_file.cpp",  # a coordinate beyond a double is a facet that the slicer reports
    "print/simulated/sim_truth.cpp",  # hexadecimal floats
    "lcmtypes/schema_parse.cpp",  # octal and hexadecimal sizes of arrays, and a room below core/
}


def check_numbers(root):
    """A text becomes a number by core/options/number.h alone."""
    problems = []
    for path in sources(root, tuple(room for room in ROOMS if room != "tests")):
        if path not in NUMBER_EXCEPTIONS:
            text = code(read(root, path))
            problems += [f"{path}:{line_of(text, match.start())}: {match.group().rstrip('(')}: read it with core/options/number.h"
                         for match in NUMBER_READER.finditer(text)]
    return problems


CHECKS = (check_same_bytes, check_sizes, check_finished, check_test_names, check_listed, check_type_names, check_namespaces,
          check_messages_begin_empty, check_class_sources, check_hidden_functions, check_truth, check_layout, check_protocol, check_tables,
          check_members, check_numbers)


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    return finish("check_house", [problem for check in CHECKS for problem in check(root)])


if __name__ == "__main__":
    sys.exit(main())
