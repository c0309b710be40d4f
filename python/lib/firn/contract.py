"""Classes of a controller in Python, and the loader that runs its files.

Inside a print this is the module `firn`: `from firn import Print, End, Stop`. Heights are in mm, arrays have the
shape (ny, nx), row j along x. python/README.md describes the contract.
"""
import ast
import builtins
import contextlib
import linecache
import pathlib
import sys
import threading
import traceback
import types

import numpy as np

__all__ = ["Print", "End", "Stop", "Measurement", "Setup"]


class Print:
    """Decision: print a layer. drops: droplets per cell, shape (ny, nx), integers or bool, 0 off the part."""

    def __init__(self, drops, reason=""):
        self.drops, self.reason = drops, reason


class End:
    """Decision: the part is finished."""

    def __init__(self, reason=""):
        self.reason = reason


class Stop:
    """Decision: stop for the operator."""

    def __init__(self, reason=""):
        self.reason = reason


class Measurement:
    """The surface after `layer` layers; the decision is for layer + 1.

    height_mm     (ny, nx) heights [mm], finite; 0 off the part where nothing was measured; read-only
    layer         layers deposited so far
    attempt       re-measurement number of this layer: a second call for a layer replaces the first
    noise_std_mm  of one cell [mm]; 0 = unknown
    """

    __slots__ = ("height_mm", "layer", "attempt", "noise_std_mm")

    def __init__(self, height_mm, layer, attempt=0, noise_std_mm=0.0):
        self.height_mm, self.layer, self.attempt, self.noise_std_mm = height_mm, layer, attempt, noise_std_mm


class Setup:
    """The values that a controller is built from.

    shape                  (ny, nx)
    pitch_x_mm, pitch_y_mm, origin_x_mm, origin_y_mm
    target_mm              (ny, nx) wanted heights [mm]; read-only
    mask                   (ny, nx) bool: the part; droplets fall here only; read-only
    h1_mm, h2_mm, h3_mm    rise by one droplet: its cell, each side neighbour, each corner neighbour [Lu 2015]
    layer_height_mm        h1 + 4 h2 + 4 h3
    seed                   of the run
    most_drops             largest count of a cell and layer
    """

    def __init__(self, values, predict, objective):
        self.__dict__.update(values)
        self._predict, self._objective = predict, objective
        for array in (self.target_mm, self.mask):
            array.flags.writeable = False

    def predict(self, height_mm, drops):
        """The surface after a layer of `drops` on `height_mm` by the height-change model: (ny, nx) [mm]."""
        return self._predict(self._heights(height_mm), _drops(self, drops))

    def objective_mm(self, height_mm):
        """Mean |height - target| over the part [mm]."""
        return self._objective(self._heights(height_mm))

    def random(self, layer, attempt=0):
        """A numpy.random.Generator that depends on the run's seed, layer and attempt only."""
        return np.random.Generator(np.random.Philox(np.random.SeedSequence([self.seed, layer, attempt])))

    def _heights(self, height_mm):
        heights = np.ascontiguousarray(height_mm, dtype=np.float64)
        if heights.shape != self.shape:
            raise ValueError(f"heights of shape {heights.shape}; the grid's is {self.shape}")
        if not np.isfinite(heights).all():
            raise ValueError("a height is not finite")
        return heights


def _drops(setup, drops):
    counts = np.asarray(drops)
    if counts.shape != setup.shape:
        raise ValueError(f"drops of shape {counts.shape}; the grid's is {setup.shape}")
    if counts.dtype != np.bool_ and not np.issubdtype(counts.dtype, np.integer):
        raise ValueError(f"drops of type {counts.dtype}; counts are integers or bool")
    if counts.size and (counts.min() < 0 or counts.max() > setup.most_drops):
        raise ValueError(f"drops from {counts.min()} to {counts.max()}; a cell takes 0 to {setup.most_drops} per layer")
    outside = (counts != 0) & ~setup.mask
    if outside.any():
        j, i = np.argwhere(outside)[0]
        raise ValueError(f"drops: cell ({i}, {j}) is off the part and has {counts[j, i]}")
    return np.ascontiguousarray(counts, dtype=np.uint8)


class ControllerError(Exception):
    """A fault of a controller's files, with the text for the operator."""


class SlowError(BaseException):
    """Raised inside code that took too long."""


_CLOCK = "reads a clock, and a replay would read another time"
_RANDOM = "draws numbers that no seed gives: use setup.random(layer, attempt)"
_THREADS = "starts threads or waits for them, and their order differs from run to run"
_WORLD = "reaches files, processes or the network, and a replay would find others; keep data in a module beside the file"
_HIDDEN = "goes around the record of what the controller's files are"
REFUSED = {
    **dict.fromkeys(("time", "datetime", "sched", "timeit", "zoneinfo"), _CLOCK),
    **dict.fromkeys(("random", "secrets", "uuid"), _RANDOM),
    **dict.fromkeys(("threading", "_thread", "concurrent", "multiprocessing", "asyncio", "queue", "signal"), _THREADS),
    **dict.fromkeys(("os", "posix", "io", "_io", "pathlib", "shutil", "tempfile", "glob", "subprocess", "socket", "socketserver",
                     "ssl", "select", "selectors", "mmap", "ctypes", "urllib", "http", "requests", "fileinput", "pickle",
                     "shelve", "sqlite3"), _WORLD),
    **dict.fromkeys(("importlib", "imp", "pkgutil", "runpy", "builtins", "gc"), _HIDDEN),
}
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
            raise ControllerError(f"{name}:{node.lineno}: datetime64: {_CLOCK}")
    return [top for _, top, _ in imports]


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
            text = file.read_bytes().decode("utf-8")
        except OSError as error:
            raise ControllerError(f"{file}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise ControllerError(f"{file}: byte {error.start} is not UTF-8") from None
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


_inside = threading.local()  # depth of calls into a controller, and of imports of packages therein
_packages = set()


@contextlib.contextmanager
def _in_controller():
    _inside.calls = getattr(_inside, "calls", 0) + 1
    try:
        yield
    finally:
        _inside.calls -= 1


def _guarded():
    return getattr(_inside, "calls", 0) > 0 and getattr(_inside, "imports", 0) == 0


_EVENTS = {
    "open": _WORLD, "socket.": _WORLD, "subprocess.": _WORLD, "os.": _WORLD, "shutil.": _WORLD, "ctypes.dlopen": _WORLD,
    "_thread.": _THREADS, "time.sleep": _CLOCK,
}


def _audit(event, arguments):
    """Every file, thread, process and socket of the interpreter passes here, also those of packages."""
    if not _guarded():
        return
    why = _EVENTS.get(event) or _EVENTS.get(event.split(".")[0] + ".")
    if why is None or event in ("os.listdir", "os.scandir"):  # the import of a package lists its folder
        return
    if event == "open" and str(arguments[0]).endswith((".py", ".pyc", ".so")):
        return
    raise ControllerError(f"{event} {arguments[0] if arguments else ''!s:.200}: {why}")


def _refuse_inside(function, why, allowed=lambda *a, **k: False):
    def checked(*arguments, **named):
        if _guarded() and not allowed(*arguments, **named):
            raise ControllerError(f"numpy.random.{function.__name__}: {why}")
        return function(*arguments, **named)

    checked.__name__, checked.__doc__ = function.__name__, function.__doc__
    return checked


def make_strict():
    """For an interpreter of Firn's own: what no import shows is refused where it happens."""
    sys.stdout = sys.stderr  # the standard output is the command's
    sys.addaudithook(_audit)
    for name in np.random.__all__:  # classes apart, these draw from one hidden state
        if name.islower() and name != "default_rng" and callable(getattr(np.random, name)):
            setattr(np.random, name, _refuse_inside(getattr(np.random, name), _RANDOM))
    np.random.default_rng = _refuse_inside(np.random.default_rng, _RANDOM, lambda seed=None: seed is not None)
    np.random.bit_generator.randbits = _refuse_inside(np.random.bit_generator.randbits, _RANDOM)  # of PCG64() and the like


def _no(what, why):
    def refuse(*_, **__):
        raise ControllerError(f"{what}: {why}")
    return refuse


class Loader:
    """Runs files from their recorded text, as modules that nothing else sees."""

    def __init__(self, files):
        self.files, self.modules = dict(files), {}
        self.builtins = dict(vars(builtins), __import__=self._import, open=_no("open", _WORLD), input=_no("input", _WORLD),
                             id=_no("id", "an address differs from run to run"), breakpoint=_no("breakpoint", _WORLD))
        for name, text in self.files.items():
            linecache.cache[name] = (len(text), None, text.splitlines(True), name)

    def module(self, stem):
        name = stem + ".py"
        if stem not in self.modules:
            module = types.ModuleType(stem)
            module.__file__, module.__builtins__ = name, self.builtins
            self.modules[stem] = module
            try:
                exec(compile(self.files[name], name, "exec", dont_inherit=True), vars(module))
            except BaseException:
                del self.modules[stem]
                raise
        return self.modules[stem]

    def _import(self, name, globals=None, locals=None, fromlist=(), level=0):
        top = name.split(".")[0]
        if level == 0 and top + ".py" in self.files:
            if "." in name:
                raise ImportError(f"{name}: {top} is a module, not a package")
            return self.module(top)
        if top in REFUSED:
            raise ControllerError(f"import {name}: {REFUSED[top]}")
        _inside.imports = getattr(_inside, "imports", 0) + 1
        try:
            return __import__(name, globals, locals, fromlist, level)
        finally:
            _inside.imports -= 1
            if top not in sys.stdlib_module_names and top != "firn":
                _packages.add(top)


def versions():
    """The interpreter and the packages that controllers have imported, a line each."""
    lines = ["Python " + ".".join(map(str, sys.version_info[:3]))]
    for name in sorted(_packages | {"numpy"}):
        lines.append(f"{name} {getattr(sys.modules.get(name), '__version__', 'of no version')}")
    return "\n".join(lines) + "\n"


class Run:
    """A controller's object with its files."""

    def __init__(self, files, class_name, arguments, setup):
        self.setup, self.names = setup, {name for name, _ in files}
        self.what = f"{files[0][0]}: {class_name}"
        loader = Loader(files)
        with _in_controller():
            module = loader.module(files[0][0][: -len(".py")])
            made = getattr(module, class_name, None)
            if not isinstance(made, type):
                known = [n for n, v in vars(module).items() if isinstance(v, type) and v.__module__ == module.__name__]
                raise ControllerError(f"{files[0][0]} has no class {class_name}; its classes: {', '.join(known) or 'none'}")
            if not callable(getattr(made, "decide", None)):
                raise ControllerError(f"{self.what} has no method decide(self, measurement)")
            self.controller = made(setup, **_arguments(arguments, self.what))

    def decide(self, height_mm, layer, attempt, noise_std_mm):
        """(kind, drops, reason): kind 0 print, 1 end, 2 stop."""
        height_mm.flags.writeable = False
        with _in_controller():
            answer = self.controller.decide(Measurement(height_mm, layer, attempt, noise_std_mm))
        if not isinstance(answer, (Print, End, Stop)):
            raise ControllerError(f"{self.what}.decide returned {type(answer).__name__}, not firn.Print, firn.End or firn.Stop")
        reason = _plain(str(answer.reason))[:1000]
        if not isinstance(answer, Print):
            return (1 if isinstance(answer, End) else 2), None, reason
        try:
            drops = _drops(self.setup, answer.drops)
        except ValueError as error:
            raise ControllerError(f"{self.what}.decide, layer {layer + 1}: {error}") from None
        if not drops.any():
            raise ControllerError(f"{self.what}.decide, layer {layer + 1}: Print of no droplet; End finishes the part")
        return 0, drops, reason

    def use_model(self, h1_mm, h2_mm, h3_mm):
        """The newest estimate of a droplet's rise; a class without the method keeps the first."""
        take = getattr(self.controller, "use_model", None)
        if callable(take):
            with _in_controller():
                take(h1_mm, h2_mm, h3_mm)

    def explain(self, error):
        return explain(error, self.names)


def _arguments(text, what):
    try:
        call = ast.parse(f"f({text})", mode="eval").body
        if call.args or any(k.arg is None for k in call.keywords):
            raise ValueError
        return {k.arg: ast.literal_eval(k.value) for k in call.keywords}
    except (SyntaxError, ValueError, AttributeError):
        raise ControllerError(f"{what}({text}): arguments are NAME=VALUE with numbers, texts or lists") from None


MOST_TEXT = 4000


def _plain(text):
    """Text that a message can hold: UTF-8 without the character 0."""
    return text.encode("utf-8", "replace").decode("utf-8").replace("\0", "?")


def explain(error, names=()):
    """The text of an exception: a fault's own, or the traceback with the frames of the controller's files."""
    return _plain(_explained(error, names))[:MOST_TEXT]


def _explained(error, names):
    if isinstance(error, SlowError):
        return str(error)
    told = traceback.TracebackException.from_exception(error, limit=None)
    frames = [f for f in told.stack if f.filename in names]
    own = "".join(traceback.StackSummary.from_list(frames[-10:]).format())
    last = "".join(told.format_exception_only()).strip()
    if isinstance(error, ControllerError):
        last = str(error)
        if not frames:
            return last
    return "Traceback of the controller:\n" + own + last if frames else last
