#!/usr/bin/env python3
"""What the object files call: neither a pure room nor anything that is linked into a node calls a clock, a thread, a file ...

A symbol has no alias: `time()`, `__builtin_exp(x)`, `using std::thread` and a member pointer to `set_maxtime` all leave the
name of what they call in the object file. Objects of nodes are followed through Firn's other objects, as the linker does.

    scripts/check_symbols.py BUILD_FOLDER [ROOT]
"""
import json
import re
import shlex
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path

from check_house import OUTSIDE_REPLAY, is_pure
from firn_tree import code, finish, read, sources

MATH = "exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|sin|cos|tan|sincos|asin|acos|atan|atan2|sinh|cosh|tanh|asinh|acosh|atanh|" \
       "cbrt|hypot|erf|erfc|tgamma|lgamma|lgamma_r|gamma|j0|j1|jn|y0|y1|yn|c(?:exp|log|pow|sin|cos|tan|sqrt|abs|arg)"

# Mangled names, as the object files have them. A variable of the thread is state (check_state); position-independent code reaches
# it by __tls_get_addr.
FORBIDDEN = {
    "a clock": r"time|clock|clock_\w+|gettimeofday|ftime|times|getrusage|timespec_get|localtime\w*|_ZNSt6chrono3_V2\w*_clock3nowEv|"
               r"_ZN2cv1[23]getTick\w*",
    "a thread": r"pthread_(?!getspecific)\w+|sem_\w+|_ZNSt6thread\w*|_ZNSt18condition_variable\w*|_ZNSt13__future_base\w*|_ZNSt7promise\w*|"
                r"_ZNSt11this_thread\w*|thrd_\w+|mtx_\w+|_ZN?K?3tbb\w*|_ZN?K?2cv1[23](?:setNumThreads|parallel_for_)\w*|"
                r"_ZT[HW]\w+|GOMP_\w+|omp_\w+",
    "sleeping": r"u?sleep|nanosleep|clock_nanosleep|_ZNSt11this_thread.*sleep\w*",
    "randomness that is not keyed": r"s?rand|rand_r|s?random|random_r|[dejlmn]rand48|srand48|getrandom|getentropy|arc4random\w*|"
                                    r"_ZNSt13random_device\w*|nlopt_srand\w*|_ZN2cv(?:3RNG|6theRNG|5randu|5randn)\w*",
    "a time limit": r"nlopt_set_maxtime|nlopt_get_maxtime|CVodeSetMaxCPU\w*",
    "a file": r"fopen(?:64)?|freopen(?:64)?|fdopen|open(?:64)?|openat(?:64)?|creat(?:64)?|tmpfile\w*|mkstemp\w*|opendir|scandir\w*|"
              r"l?stat(?:64)?|fstat(?:64)?|access|unlink|rename|remove|mkdir|rmdir|truncate(?:64)?|mmap(?:64)?|"
              r"_ZNSt13basic_filebuf\w*|_ZNSt14basic_(?:i|o)?fstream\w*|_ZNSt14basic_[io]fstream\w*|"
              r"_ZNSt10filesystem(?!7__cxx114path)\w*|_ZN2cv6im(?:read|write)\w*",
    "a socket or a device": r"socket|socketpair|connect|bind|listen|accept4?|send(?:to|msg)?|recv(?:from|msg)?|p?poll|select|epoll_\w+|ioctl|"
                            r"tc[gs]etattr|getaddrinfo|gethostby\w+|read|write|pipe2?",
    "the environment": r"(?:secure_)?getenv|setenv|putenv|getcwd|gethostname|getpid|getppid|gettid|uname|sysconf|get_nprocs\w*|"
                       r"getlogin\w*|getpwuid\w*|isatty",
    "another process": r"fork|vfork|exec[lv]\w*|posix_spawn\w*|system|popen|kill|raise|signal|sigaction|dlopen|dlsym",
    "LCM": r"lcm_\w+|_ZN?K?3lcm\w*",
    "an inexact function, whose last bit depends on the CPU": rf"(?:__)?(?:{MATH})[fl]?(?:_finite)?|_ZGV\w+",
}
FORBIDDEN = {what: re.compile(rf"(?:{pattern})\Z") for what, pattern in FORBIDDEN.items()}
INEXACT = "an inexact function, whose last bit depends on the CPU"
IN_PLANT = ("a file", INEXACT)  # nature is recorded, not replayed, and keeps its own record

FINGERPRINT = "runtime/result_fingerprint.cpp"
SAME_AS = {"sincos": ("sin",), "cabs": ("hypot",)}  # functions whose row stands for another

IN_NODES, APART = True, False
# sources (of a batch: each of them), what they may call, whether a node may be linked with them, why the same input gives the same bytes all the same
ALLOWED = (
    ("core/statistics/distributions.cpp", "a?(cos|sin)|sincos|(exp|log1p|pow)l?|expm1|log", APART, "tables of studies and reports"),
    ("core/control/smf_line/smf_line.cpp", "cabs", APART, "poles of gains, for firn tune"),
    ("core/grid/random_normal.cpp", "log", APART, "nature and tests draw normal numbers"),
    ("estimators/bead/*", "log|exp", APART, "firn identify"),
    ("estimators/lab/*", "log", APART, "firn tune"),
    ("estimators/calibration/*", "log|exp|sincos|hypot", APART, "firn calibrate"),
    ("estimators/registration/nozzle_offset.cpp", "hypot", APART, "firn calibrate"),
    ("python/host/load.cpp", r"dlopen|dlsym|_ZNSt10filesystem\w*", IN_NODES,
     "the interpreter of a controller in Python; its files are inputs of the run, and replay compares its answers"),
    ("plant/world/world.cpp", "write", APART, "world.rec, nature's record"),
)


GENERATED = re.compile(r"::getHash\(\)::hash$")  # lcm-gen's: a constant that is worked out once


class Object:
    """Symbols of one object file, and the target that it is compiled for."""

    def __init__(self, source, library, text):
        self.source, self.library, self.calls, self.strong, self.weak, self.state = source, library, set(), set(), set(), set()
        for line in text.splitlines():
            match = re.match(r"[0-9a-f]{8,} (.{7}) (\S+)\t[0-9a-f]+ +(?:0x[0-9a-f]+ |\.hidden )?(\S+)$", line)
            if not match:
                continue
            flags, section, name = match.groups()
            if section == "*UND*":
                self.calls.add(name)
            elif "d" not in flags and "f" not in flags:
                if flags[0] in "gu" and "w" not in flags:
                    self.strong.add(name)
                elif "w" in flags or flags[0] == "u":
                    self.weak.add(name)
                if re.match(r"\.(bss|data(?!\.rel\.ro))", section) and "O" in flags or re.match(r"\.t(bss|data)", section):
                    self.state.add(name)


def sources_of(file, root, build):
    """The sources, from the root on, that one command compiles: one, or those of a batch."""
    if not file.is_relative_to(build):
        found = [file]
    elif file.parent.name == "Unity" and file.is_file():
        found = [Path(name) for name in re.findall(r'^#include "(.*\.cpp)"$', file.read_text(encoding="utf-8"), re.M)]
    else:
        found = []
    return [s.relative_to(root).as_posix() for s in found if s.is_relative_to(root) and not s.is_relative_to(build)]


def parts(source):
    """The sources of an object: a batch's are joined by blanks."""
    return source.split(" ")


def objects_of(build, root):
    """sources -> Object of every object that is compiled for a program, and the sources whose object is not there."""
    commands = json.loads((Path(build) / "compile_commands.json").read_text(encoding="utf-8"))
    files = {}
    for entry in commands:
        words = shlex.split(entry["command"])
        found = sources_of(Path(entry["file"]), root, build)
        output = words[words.index("-o") + 1]
        if found and not found[0].startswith("tests/") and not output.startswith("tests/"):
            files[" ".join(found)] = Path(entry["directory"]) / output
    missing = sorted(source for source, file in files.items() if not file.is_file())
    there = [source for source in files if source not in missing]
    found, text = {}, ""
    if there:
        text = subprocess.run(["objdump", "-t", *[str(files[s]) for s in there]], check=True, stdout=subprocess.PIPE, text=True).stdout
    parts = re.split(r"^\S.*:\s+file format \S+$", text, flags=re.M)[1:]
    for source, part in zip(there, parts, strict=True):
        folder = re.search(r"/(\w+)\.dir/", str(files[source]))
        found[source] = Object(source, folder and folder.group(1), part)
    return found, missing


def build_and_root(usage):
    """The folders that the command line names: BUILD_FOLDER [ROOT]."""
    if len(sys.argv) < 2:
        sys.exit(usage)
    build = Path(sys.argv[1]).resolve()
    if not (build / "compile_commands.json").is_file():
        sys.exit(f"{build}: is no build folder of CMake: it has no compile_commands.json")
    root = sys.argv[2] if len(sys.argv) > 2 else Path(__file__).resolve().parent.parent
    return build, Path(root).resolve()


def is_main(source):
    return re.fullmatch(r"main\w*\.cpp", source.rsplit("/", 1)[-1]) is not None


def linked_into_nodes(objects):
    """object's sources -> the sources by which the linker comes to it; None for the nodes' own."""
    definers = {}
    for kind in ("weak", "strong"):
        for obj in objects.values():
            for name in getattr(obj, kind):
                if kind == "strong" or name not in definers:
                    definers.setdefault(name, set()).add(obj.source)
    came_from = {s: None for s in objects if s.startswith("procs/") and not s.startswith(OUTSIDE_REPLAY) and not is_main(s)}
    waiting = list(came_from)
    while waiting:
        source = waiting.pop(0)
        for name in sorted(objects[source].calls):
            for target in sorted(definers.get(name, ())):
                if target not in came_from:
                    came_from[target] = source
                    waiting.append(target)
    return came_from


def chain(source, came_from):
    steps = [source]
    while came_from.get(steps[-1]):
        steps.append(came_from[steps[-1]])
    return " <- ".join(steps)


def check_calls(objects, came_from):
    problems, used = [], set()
    for source, obj in sorted(objects.items()):
        pure = any(is_pure(part) for part in parts(source))
        if is_main(source) or not (pure or source in came_from):
            continue
        for name in sorted(obj.calls):
            what = next((what for what, pattern in FORBIDDEN.items() if pattern.match(name)), None)
            if what is None or (source.startswith("plant/") and what in IN_PLANT):
                continue
            rows = [row for row in ALLOWED if all(fnmatch(part, row[0]) for part in parts(source))
                    and re.fullmatch(row[1], name) and (row[2] == IN_NODES or source not in came_from)]
            used.update(rows)
            if not rows:
                where = f"; linked into a node: {chain(source, came_from)}" if came_from.get(source) else ""
                problems.append(f"{source}: calls {what} ({name}){where}")
    return problems, used


def check_fingerprint(objects, root):
    """Every inexact function that pure code or nature calls has a row in the fingerprint of results, which replay compares."""
    there = set(re.findall(r'\{"(\w+)", std::', read(root, FINGERPRINT)))
    problems = []
    for source, obj in sorted(objects.items()):
        if is_main(source) or not (source.startswith("plant/") or any(map(is_pure, parts(source)))):
            continue
        for name in sorted(obj.calls):
            if not FORBIDDEN[INEXACT].match(name):
                continue
            functions = SAME_AS.get(name, (name.removesuffix("f"), name.removesuffix("l")) if name not in there else (name,))
            if not there.intersection(functions):
                problems.append(f"{source}: calls {name}, which {FINGERPRINT} does not know")
    return problems


def demangled(names):
    names = sorted(names)
    text = subprocess.run(["c++filt"], input="\n".join(names), check=True, stdout=subprocess.PIPE, text=True).stdout
    return dict(zip(names, text.split("\n")))


def check_state(objects, came_from, root):
    """Variables that outlive a call and are not const: a node would carry them from one print, or test, into the next."""
    problems, texts = [], {}
    pure = [o for s, o in sorted(objects.items()) if not is_main(s) and (any(map(is_pure, parts(s))) or s in came_from)]
    headers = "".join(code(read(root, path)) for path in sources(root, suffixes={".h"}) if not path.startswith("tests/"))
    names = demangled({name for obj in pure for name in obj.state})
    for obj in pure:
        for mangled in sorted(obj.state):
            name = names[mangled]
            if not re.search(r"(^|[ (:])firn::", name) or GENERATED.search(name) or name.startswith(("guard variable", "vtable", "typeinfo")):
                continue
            last = re.sub(r"\[abi:\w+\]", "", name).rsplit("::", 1)[-1]
            if obj.source not in texts:
                texts[obj.source] = "".join(code(read(root, part)) for part in parts(obj.source))
            declared = [line for text in (texts[obj.source], headers) for line in re.findall(rf"^.*\b{re.escape(last)}\b.*$", text, re.M)
                        if re.search(rf"[\w>&*\]]\s+(?:&|\*)?{re.escape(last)}\b\s*(?:\[[^\]]*\]\s*)*(?:=|\{{|\(|;)", line)]
            if not declared or not all(re.search(r"\b(const|constexpr)\b", line) for line in declared if "static" in line or declared == [line]):
                problems.append(f"{obj.source}: state that outlives its call ({name})")
    return problems


def main():
    build, root = build_and_root(__doc__)
    objects, missing = objects_of(build, root)
    came_from = linked_into_nodes(objects)
    problems = [f"{source}: is not compiled yet: build first" for source in missing if any(map(is_pure, parts(source)))]
    calls, used = check_calls(objects, came_from)
    if not missing:
        problems += [f"scripts/check_symbols.py: allows {row[0]} to call {row[1]}, which it does not" for row in ALLOWED if row not in used]
    return finish("check_symbols", problems + calls + check_fingerprint(objects, root) + check_state(objects, came_from, root))


if __name__ == "__main__":
    sys.exit(main())
