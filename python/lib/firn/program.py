"""Calls of the program `firn`."""
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
