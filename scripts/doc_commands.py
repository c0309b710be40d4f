"""The commands of README.md and docs/ as a reader would give them one after the other; scripts/try_docs.py runs them.

A page's commands are the lines `./firn ...` and `firn ...` of its blocks without a language, with the lines cp, echo, python3 and
scripts/ between them, and spans `./firn COMMAND ...` of its text. Blocks of TOML that begin with `# FILE.toml` are files that the
reader writes. `# exits with N` follows a command that does not exit with 0. Of a synopsis the shortest command is taken:
without what stands in [brackets], with the first of several alternatives.
"""
import re
from dataclasses import dataclass, field
from pathlib import Path

from check_docs import SPAN, documents, line_of
from firn_tree import read

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$|((?:^    [^\n]*\n)+)", re.M | re.S)
FIRN = re.compile(r"(?:\./)?firn [a-z]")
BESIDE = re.compile(r"(?:cp|echo|python3|scripts/\S+) ")  # lines that a reader gives between calls of firn
EXITS = re.compile(r"# exits with (\d+)")
COMMENT = re.compile(r"\s+#\s.*$")
TOML_FILE = re.compile(r"# (\S+\.toml)\b")
CAPITALS = re.compile(r"(?<![\w./=-])[A-Z]{2,}(?:\.\w+)?(?![\w.])")
# What stands for a reader's own files and words; a page's own come first.
PLACEHOLDERS = {
    "": {"EXPERIMENT.toml": "experiments/demo.toml", "EXPERIMENT": "experiments/demo.toml", "LAB": "labs/inkjet-lu2015.toml", "LOG": "RUN/log.lcm",
         "MM": "0.05"},
    "docs/commands/calibrate.md": {"--spacing RUN…": "--spacing runs/*-spacing*"},
    "docs/commands/export.md": {"FILE.h5": "run.h5", "RECORD": "record.csv"},
    "docs/commands/plan.md": {"PATHS.csv": "experiments/barnett-fig42.csv", "FILE": "labs/cobra600.toml --origin 354,-46",
                              "TRAJECTORIES": "mine.traj"},
    "python/README.md": {"SCRIPT": "-c 'import firn; print(firn.__file__)'"},
    "docs/commands/print.md": {"PART.png": "part.png", "MM": "0.1"},
    "docs/commands/runs.md": {"DAYS": "30"},
    "docs/page.md": {"NAME": "Kim"},
    "docs/commands/slice.md": {"MESH": "experiments/gear.stl", "PATHS": "mine.paths"},
    "docs/devices/robot.md": {"LAB": "labs/ice-cobra600.toml"},
    "docs/commands/device.md": {"NAME": "lamp", "VERB": "identify"},
}
A_RUN = "./firn print experiments/demo.toml --bus in-process"
A_LIVE_PRINT = "./firn print experiments/cuboid.toml --set part.height_mm=0.05 --detach"
# (page, command, what its reader has done before); a command that names RUN has a run without this.
BEFORE = [
    ("docs/commands/compare.md", r"compare RUN", [A_RUN, A_RUN + " --set control.scheme=smf"]),
    ("docs/commands/calibrate.md", r"identify --spacing", [  # as the experiment's file says
        f"./firn print experiments/spacing.toml --bus in-process --set grid.pitch_x_mm={p} --set grid.pitch_y_mm={p}"
        for p in (0.105, 0.147, 0.189)]),
    ("docs/commands/calibrate.md", r"tune RUN --keys control\.smf\.kp,", [A_RUN + " --set control.scheme=smf"]),
    ("docs/commands/ctl.md", r"ctl RUN pause", [A_LIVE_PRINT]),
    ("docs/commands/ctl.md", r"attach RUN", ["./firn ctl RUN continue"]),
    ("docs/commands/decide.md", r"decide --height", ["cp tests/bench/instances/ramp.npy H.npy", "cp tests/bench/instances/target.npy T.npy"]),
    ("docs/commands/export.md", r"import record.csv", ["printf 'layer,x_mm,y_mm,height_mm\\n1,0,0,0.1\\n1,1,0,0.1\\n1,0,1,0.1\\n1,1,1,0.1\\n' > record.csv"]),
    ("docs/commands/print.md", r"print part\.png", ["cp experiments/height_map.png part.png"]),
    ("docs/commands/print.md", r"print --resume", [
        "./firn print experiments/cuboid.toml --bus in-process --set part.height_mm=0.05 --fault '10 jet close' || true"]),
    ("python/README.md", r"my_study\.py", ["sed -n '/^import firn$/,/^print/p' python/README.md > my_study.py"]),
    ("docs/commands/spy.md", r"spy RUN", [A_LIVE_PRINT]),
    ("docs/notify.md", r"config notify", [
        "mkdir -p ~/.config/firn && printf '[notify]\\ncommand = \"cat > told.json\"\\n' > ~/.config/firn/config.toml"]),
]
# (page, command, exit code, why) where the text around the command says it.
EXPECTED = [
    ("", r"replay RUN --set", 1, "the page says that it differs"),
    ("docs/commands/print.md", r"--fault", 3, "stopped by the fault"),
]
# (page, command, why it is not run)
LEFT_OUT = [
    ("", r"firn bench\b", "measures for minutes to hours; the figure stands beside it"),
    ("", r"firn test\b", ".ci/run runs it"),
    ("docs/ARTIFACT.md", r"replay RUN$", "of a run with a controller in Python from another host"),
    ("docs/packages.md", r"", "tests/release gives them on a machine without a compiler"),
    ("docs/commands/compare.md", r"--on (slurm|ssh)", "a cluster, other computers: tests/cli/engines_test.py brings its own"),
    ("docs/commands/reproduce.md", r"--on ssh", "other computers: tests/cli/engines_test.py brings its own"),
    ("docs/commands/runs.md", r"sync archive@nas", "another computer: tests/cli/find_test.py brings its own"),
    ("docs/commands/runs.md", r"sync /archive", "a disk of the reader's"),
    ("docs/page.md", r"people remove", "of a person who was added before"),
    ("docs/commands/droplets.md", r"", "the reader's own pictures"),
    ("docs/devices/camera.md", r"droplets$", "the reader's own pictures"),
    ("docs/commands/spy.md", r"spy$", "needs a display"),
    ("docs/commands/device.md", r"cassette|record", "a real lamp"),
    ("docs/tutorials/your-lab.md", r"--row 47|--device NAME", "a person at the gauge block; real instruments"),
    ("docs/write-a-controller.md", r"scheme=(level|learning)|learning_rate", "the reader's own C++: tests/docs builds it"),
    ("docs/measurements.md", r"", "measures; the figure stands beside it"),
]


@dataclass
class Command:
    """One line that a reader gives to the shell, or a file that it writes."""
    page: str
    line: int
    given: str                   # as the page has it
    shell: str                   # as it is run; RUN still stands for the newest run
    exits: tuple = (0,)
    before: list = field(default_factory=list)
    left_out: str = ""
    text: str = ""               # of a file that the reader writes: given is its name

    @property
    def wants_run(self):
        return bool(re.search(r"\bRUN\b", self.shell))


def without_brackets(text):
    """[--seed N [--quick]] and the … behind it are left out."""
    while (shorter := re.sub(r" ?\[[^\[\]]*\]…?", "", text)) != text:
        text = shorter
    return text


def shortest(line):
    """The shortest command of a synopsis."""
    line = COMMENT.sub("", line)
    if "…" not in line and "[" not in line and "|" not in line:
        return line
    line = without_brackets(line).split(" | ")[0]
    words = [word.split("|")[0] if "|" in word and "'" not in word else word for word in line.split(" ")]
    return " ".join(words).replace("…", "").replace("...", "").rstrip()


def resolved(page, line):
    """With the reader's own names for placeholders, and ./firn for an installed firn."""
    own = {**PLACEHOLDERS[""], **PLACEHOLDERS.get(page, {})}
    for words, instead in own.items():
        line = line.replace(words, instead) if "…" in words else line
    line = CAPITALS.sub(lambda word: own.get(word.group(0), word.group(0)), shortest(line).replace("RUN...", "RUN"))
    return re.sub(r"^firn ", "./firn ", line)


def first_of(table, page, shell):
    return next((row for row in table if row[0] in ("", page) and re.search(row[1], shell)), None)


def command(page, line, given):
    shell = resolved(page, given)
    exits, said = EXITS.search(given), first_of(EXPECTED, page, shell)
    before, left_out = first_of(BEFORE, page, shell), first_of(LEFT_OUT, page, shell)
    code = int(exits.group(1)) if exits else said[2] if said else 0
    # A print that ends out of tolerance exits with 4, and has done what was asked.
    exits = (0, 4) if code == 0 and re.match(r"\./firn (print|demo|attach)\b", shell) else (code,)
    return Command(page, line, given.strip(), shell, exits, before[2] if before else [], left_out[2] if left_out else "")


def joined(block):
    """(line, text) of a block's commands; a line that ends in a backslash and the rest of a synopsis go on in the next."""
    lines = []
    for number, line in enumerate(block.split("\n")):
        text = line.strip()
        if lines and lines[-1][1].endswith("\\"):
            lines[-1] = (lines[-1][0], lines[-1][1][:-1].rstrip() + " " + text)
        elif lines and text.startswith("[") and FIRN.match(lines[-1][1]):
            lines[-1] = (lines[-1][0], lines[-1][1] + " " + text)
        else:
            lines.append((number, text))
    return lines


def page_commands(root, page):
    """@returns every Command of a page, in the order of the page."""
    text, found = read(root, page), []
    prose = BLOCK.sub(lambda match: re.sub(r"[^\n]", " ", match.group(0)), text)
    for match in SPAN.finditer(prose):
        span = " ".join(match.group(1).split())
        if re.match(r"\./firn [a-z]+", span):
            found.append(command(page, line_of(text, match.start()), span))
    for match in BLOCK.finditer(text):
        language, fenced, indented = match.groups()
        at = line_of(text, match.start()) + (0 if indented else 1)
        if language == "toml" and (name := TOML_FILE.match(fenced)):
            found.append(Command(page, at, name.group(1), "", text=fenced))
        if language or not FIRN.search(fenced or indented) and not BESIDE.match(fenced or ""):
            continue
        found += [command(page, at + number, line) for number, line in joined(fenced or indented)
                  if FIRN.match(line) and not re.match(r"firn \w+:", line) or BESIDE.match(line)]
    return sorted(found, key=lambda one: one.line)


def all_commands(root):
    """@returns {page: [Command]} of README.md and docs/, without the decisions, which tell what was."""
    pages = [page for page in documents(root) if page != "CONTRIBUTING.md" and not page.startswith("docs/decisions/")]
    pages.insert(1, "python/README.md")
    return {page: found for page in pages if (found := page_commands(root, page))}


def commands_of(root: Path, pages):
    """@returns the commands of the named pages, of all without names. Throws KeyError for a page without commands."""
    found = all_commands(root)
    return {page: found[page] for page in pages} if pages else found
