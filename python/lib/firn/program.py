"""The program `firn`, and its cores as a module of this interpreter."""
import functools
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import shutil
import subprocess


class FirnError(ValueError):
    """A command of firn failed; the text is the program's own message."""


def program():
    """Path of the program: $FIRN_PROGRAM, that of this checkout, or that in $PATH."""
    built = pathlib.Path(__file__).resolve().parents[3] / "build" / "bin" / "firn"
    found = os.environ.get("FIRN_PROGRAM") or (str(built) if built.is_file() else shutil.which("firn"))
    if not found:
        raise FirnError(f"the program firn is neither {built} nor in PATH; ./firn python builds it")
    return found


@functools.cache
def core():
    """The module firn_core beside the program; None: it is not built, or for another Python. FIRN_CORE=off leaves it alone."""
    if os.environ.get("FIRN_CORE") == "off":
        return None
    home = pathlib.Path(program()).resolve().parent.parent
    name = "firn_core" + importlib.machinery.EXTENSION_SUFFIXES[0]
    for file in (home / "python" / name, home / "lib" / "firn" / name):
        if file.is_file():
            spec = importlib.util.spec_from_file_location("firn_core", file)
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            module.raise_errors_as(FirnError)
            return module
    return None


def in_core(name, *arguments):
    """The answer of a core; None: the program has to be called, for want of the module or for files in Python."""
    module = core()
    if module is None:
        return None
    try:
        return getattr(module, name)(*arguments)
    except module.NeedsProgram:
        return None


def assignments(given):
    """KEY=VALUE of each setting: numbers and texts."""
    return settings(given)[1::2]


def call(*words, fine=(0,)):
    """Standard output of a command. fine: exit codes that are no failure."""
    done = subprocess.run([program(), *map(str, words)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False)
    if done.returncode not in fine:
        raise FirnError(done.stderr.strip()[-4000:] or f"firn {words[0]}: exit code {done.returncode}")
    return done.stdout


def call_json(*words, fine=(0,)):
    return json.loads(call(*words, "--json", fine=fine))


def settings(given):
    """--set of each setting: numbers and texts."""
    words = []
    for key, value in (given or {}).items():
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise FirnError(f"{key} = {value!r}: a setting is a number or a text")
        words += ["--set", f"{key}={value}"]
    return words


def scheme(controller):
    """control.scheme of a name, of "python:FILE.py:CLASS" with the file's full path, or of a class by its file."""
    if isinstance(controller, type):
        import inspect
        return f"python:{pathlib.Path(inspect.getfile(controller)).resolve()}:{controller.__name__}"
    if not isinstance(controller, str):
        raise FirnError(f"{controller!r}: a controller is a scheme's name, python:FILE.py:CLASS, or a class of a file")
    if not controller.startswith("python:"):
        return controller
    head, bracket, arguments = controller[len("python:"):].partition("(")
    file, _, name = head.rpartition(":")
    return f"python:{pathlib.Path(file).resolve()}:{name}{bracket}{arguments}"
