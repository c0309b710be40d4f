"""A scratch copy of the house, in which a test adds what docs tell a reader to add."""
import filecmp
import shlex
import shutil
import subprocess
from pathlib import Path


def run(command, **more):
    """@returns the finished process; a command that fails is reported with what it said."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **more)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))}\n{done.stdout[-6000:]}{done.stderr[-6000:]}")
    return done


class ScratchCopy:
    def __init__(self, root, folder):
        """Copies every file that git knows, and those that it does not ignore."""
        self.root, self.folder = Path(root), Path(folder)
        listed = run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root).stdout
        self.files = [f for f in listed.split("\0") if f and (self.root / f).is_file()]
        for file in self.files:
            (self.folder / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.root / file, self.folder / file)

    def add(self, file, text):
        """A new file."""
        path = self.folder / file
        assert not path.exists(), f"{file} is there already"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def insert(self, file, after, text):
        """Adds lines to an existing file, behind the one line that holds `after`."""
        path = self.folder / file
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        places = [n for n, line in enumerate(lines) if after in line]
        assert len(places) == 1, f"{file}: {len(places)} lines hold '{after}'"
        lines.insert(places[0] + 1, text)
        path.write_text("".join(lines), encoding="utf-8")

    def replace(self, file, old, new):
        """Changes one place of an existing file."""
        path = self.folder / file
        text = path.read_text(encoding="utf-8")
        assert text.count(old) == 1, f"{file}: '{old}' occurs {text.count(old)} times"
        path.write_text(text.replace(old, new), encoding="utf-8")

    def touched(self):
        """Existing files that differ from the house."""
        return sorted(f for f in self.files if not filecmp.cmp(self.root / f, self.folder / f, shallow=False))

    def configure(self, build_type, *options):
        run(["cmake", "-G", "Ninja", "-S", self.folder, "-B", self.folder / "build",
             f"-DCMAKE_BUILD_TYPE={build_type}", "-DCMAKE_UNITY_BUILD=OFF", *options])

    def build(self, *targets):
        run(["ninja", "-C", self.folder / "build", *targets])

    def compile(self, *objects):
        """Compiles objects alone. ninja would first build every library of the program that embeds the page's files."""
        build = self.folder / "build"
        self.build("firn_version_generate", "lcmtypes/firn_lcm_headers_generate")
        for made in objects:
            (build / made).parent.mkdir(parents=True, exist_ok=True)
            command = run(["ninja", "-C", build, "-t", "commands", "-s", made]).stdout.strip().splitlines()[-1]
            run(["sh", "-c", command], cwd=build)

    def link(self, build, program, objects, made):
        """Links a program of another build as `made`, with these objects in the libraries that they belong to."""
        command = run(["ninja", "-C", build, "-t", "commands", "-s", program]).stdout.strip().splitlines()[-1]
        words = shlex.split(command)
        words = words[words.index("&&") + 1:] if words[0] == ":" else words
        words = words[:words.index("&&")] if "&&" in words else words
        words[words.index("-o") + 1] = str(made)
        for made_object in objects:
            folder, target = made_object.split("/CMakeFiles/")
            name = f"{folder}/lib{target.split('.dir/')[0]}.a"
            own = self.folder / "build" / Path(name).name
            if name in words:
                shutil.copyfile(Path(build) / name, own)
                words = [str(own) if word == name else word for word in words]
            run(["ar", "r", own, self.folder / "build" / made_object])
        run(words, cwd=build)
        return made
