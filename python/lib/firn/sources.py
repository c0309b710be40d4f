"""Reads the files of a controller and the modules beside them, and refuses what no print allows: a clock, threads, randomness
without the seed, files, sockets, processes.
"""
import ast
import io
import pathlib
import tokenize


class ControllerError(Exception):
    """A fault of a controller's files, with the text for the operator."""


CLOCK = "reads a clock, and a replay would read another time"
RANDOM = "draws numbers that no seed gives: use setup.random(layer, attempt)"
THREADS = "starts threads or waits for them, and their order differs from run to run"
WORLD = "reaches files, processes or the network, and a replay would find others; keep data in a module beside the file"
HIDDEN = "goes around the record of what the controller's files are"
REFUSED = {
    **dict.fromkeys(("time", "datetime", "sched", "timeit", "zoneinfo"), CLOCK),
    **dict.fromkeys(("random", "secrets", "uuid"), RANDOM),
    **dict.fromkeys(("threading", "_thread", "concurrent", "multiprocessing", "asyncio", "queue", "signal"), THREADS),
    **dict.fromkeys(("os", "posix", "io", "_io", "pathlib", "shutil", "tempfile", "glob", "subprocess", "socket", "socketserver",
                     "ssl", "select", "selectors", "mmap", "ctypes", "urllib", "http", "requests", "fileinput", "pickle",
                     "shelve", "sqlite3"), WORLD),
    **dict.fromkeys(("importlib", "imp", "pkgutil", "runpy", "builtins", "gc"), HIDDEN),
}
LOCALE = "would change how numbers are written, and differs from machine to machine; format them in the file"
MOST_FILES, MOST_BYTES = 100, 4 << 20  # of a controller's files


def _imports(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for name in node.names:
                yield node.lineno, name.name.split(".")[0], name.name
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                raise ControllerError(f"line {node.lineno}: relative import; name a module beside the file: import helpers")
            yield node.lineno, node.module.split(".")[0], node.module


def _check(name, text):
    """The names of what a file imports. Raises ControllerError at what no controller may do."""
    try:
        tree = ast.parse(text, name)
    except (SyntaxError, ValueError) as error:
        line = getattr(error, "lineno", None)
        raise ControllerError(f"{name}{f':{line}' if line else ''}: {getattr(error, 'msg', error)}") from None
    except (RecursionError, MemoryError):
        raise ControllerError(f"{name}: nested too deeply") from None
    try:
        imports = list(_imports(tree))
    except ControllerError as error:
        raise ControllerError(f"{name}: {error}") from None
    for line, top, full in imports:
        if top in REFUSED:
            raise ControllerError(f"{name}:{line}: import {full}: {REFUSED[top]}")
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "datetime64" and \
                any(isinstance(a, ast.Constant) and a.value in ("now", "today") for a in node.args):
            raise ControllerError(f"{name}:{node.lineno}: datetime64: {CLOCK}")
    return [top for _, top, _ in imports]


def _decoded(file, data):
    """The text of a source file as Python reads it: UTF-8 with or without a byte order mark, or as its first lines say."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise ControllerError(f"{file}: is UTF-16; save it as UTF-8")
    try:
        encoding, _ = tokenize.detect_encoding(io.BytesIO(data).readline)
    except SyntaxError as error:
        if not str(error).startswith("invalid"):  # an encoding that is not known, or two that contradict each other
            raise ControllerError(f"{file}: {error}") from None
        encoding = "utf-8"
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        where = f"{file}:{data.count(10, 0, error.start) + 1}"
        raise ControllerError(f"{where}: byte {error.start} is not {encoding.upper()}") from None


def sources(path):
    """[(name, text)] of a file and of the modules beside it that it imports; the file comes first."""
    path = pathlib.Path(path)
    found, waiting, size = {}, [path.stem], 0
    while waiting:
        stem = waiting.pop()
        name = stem + ".py"
        if name in found:
            continue
        file = path.parent / name
        try:
            text = _decoded(file, file.read_bytes())
        except OSError as error:
            raise ControllerError(f"{file}: {error.strerror}") from None
        size += len(text)
        if len(found) == MOST_FILES or size > MOST_BYTES:
            raise ControllerError(f"{path}: imports more than {MOST_FILES} files or {MOST_BYTES} bytes beside it")
        found[name] = text
        for top in _check(str(file), text):
            if (path.parent / (top + ".py")).is_file():
                waiting.append(top)
            elif (path.parent / top).is_dir() and (path.parent / top / "__init__.py").is_file():
                raise ControllerError(f"{file}: import {top}: a package beside the file; only modules are recorded")
    return list(found.items())
