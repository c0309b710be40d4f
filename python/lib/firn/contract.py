"""Classes of a controller, an estimator and a plant in Python, and the loader that runs their files (sources.py reads them).

Inside a print this is the module `firn`: `from firn import Print, End, Stop`. Heights are in mm, arrays have the
shape (ny, nx), row j along x. python/README.md describes the contract.
"""
import ast
import builtins
import contextlib
import linecache
import locale
import sys
import threading
import traceback
import types

import numpy as np

from firn.sources import CLOCK, LOCALE, RANDOM, REFUSED, THREADS, WORLD, ControllerError, sources

__all__ = ["Print", "End", "Stop", "Action", "Model", "Surface", "Measurement", "Setup", "Layer", "Landed", "Interval", "Values"]


class Print:
    """Decision: print a layer.

    drops   droplets per cell, shape (ny, nx), integers or bool, 0 off the part
    places  where in its cell each cell's droplets land, rows of setup.places, shape (ny, nx), integers; None: in the middle
    """

    def __init__(self, drops, reason="", places=None):
        self.drops, self.reason, self.places = drops, reason, places


class End:
    """Decision: the part is finished."""

    def __init__(self, reason=""):
        self.reason = reason


class Stop:
    """Decision: stop for the operator."""

    def __init__(self, reason=""):
        self.reason = reason


class Action:
    """Decision of a print along paths: deposit (1 + u) of nominal. u: (ny, nx), not counted beyond the footprint."""

    def __init__(self, u, reason=""):
        self.u, self.reason = u, reason


class Model:
    """What a droplet adds: h1 to its cell, h2 to each side neighbour, h3 to each corner neighbour [mm].

    covariance_mm2   (3, 3) of h1, h2, h3; None: not known
    droplet_scatter  relative standard deviation of a droplet; 0: not known
    """

    def __init__(self, h1_mm, h2_mm, h3_mm, covariance_mm2=None, droplet_scatter=0.0):
        self.h1_mm, self.h2_mm, self.h3_mm = h1_mm, h2_mm, h3_mm
        self.covariance_mm2, self.droplet_scatter = covariance_mm2, droplet_scatter


class Surface:
    """Answer of a plant: heights (ny, nx) [mm] after a pass, and what it remembers, which the world keeps: numbers (n,)."""

    def __init__(self, height_mm, memory=()):
        self.height_mm, self.memory = height_mm, memory


class _Members:
    def __init__(self, **members):
        self.__dict__.update(members)


class Values(_Members):
    """The values that an estimator, a plant or a controller of paths is built from.

    seed                                               of the run, or of the world
    shape, pitch_x_mm, pitch_y_mm, origin_x_mm, origin_y_mm   estimator, plant: (ny, nx) and the grid
    mask                                               estimator: (ny, nx) bool, the part
    h1_mm, h2_mm, h3_mm                                estimator: the model that the print began with
    droplet_mm3                                        plant: nominal volume of a droplet
    interval_mm, low, high, last_layer                 paths: nominal height between maps, bounds of u, the part's last layer
    """

    def random(self, *numbers):
        """A numpy.random.Generator that depends on the seed and these integers only."""
        return np.random.Generator(np.random.Philox(np.random.SeedSequence([int(self.seed), *numbers])))


class Layer(_Members):
    """A printed layer, for an estimator.

    drops         (passes, ny, nx) droplets that were fired; shares where the jet counted fewer than were commanded
    height_mm     (ny, nx) measured after it [mm], NaN where nothing was measured
    learn         (ny, nx) bool: cells that may enter a fit: on the part, measured, with no droplet in doubt
    layer         layers deposited so far; 0: the bare substrate, with no pass
    attempt       above 0: the layer was measured again, and this map replaces the earlier one
    noise_std_mm  of one cell
    """


class Landed(_Members):
    """The droplets of a pass, for a plant.

    height_mm           (ny, nx) before them
    drops               (ny, nx) their count in the nearest cell
    x_mm, y_mm, t_s     (n,) place and time of each in the order of firing, on the grid or beside it
    vx_mm_s, vy_mm_s    (n,) of the stage
    layer               layers that are finished
    memory              as the last answer left it
    """


class Interval(_Members):
    """The surface at a measurement plane, for a controller of paths.

    height_mm     (ny, nx) [mm], finite on the footprint
    material      (ny, nx) 0 beyond the footprint, 1 the part, 2 the scaffold
    nominal_mm    required height
    error         (ny, nx) (nominal - height) / interval, NaN beyond the footprint
    layer, attempt, noise_std_mm    as in Measurement
    """


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
    places                 (n, 2) x and y in shares of the pitch from a cell's middle, where its droplets may land;
                           row 0 is the middle, and the only one without actuation.offsets; read-only
    """

    def __init__(self, values, predict, objective):
        self.__dict__.update(values)
        self._predict, self._objective = predict, objective
        for array in (self.target_mm, self.mask, self.places):
            array.flags.writeable = False

    def predict(self, height_mm, drops, places=None):
        """The surface after a layer of `drops` on `height_mm` by the height-change model: (ny, nx) [mm]. places as in Print."""
        counts = _drops(self, drops)
        return self._predict(self._heights(height_mm), counts, _places(self, places, counts))

    def nearest_place(self, x, y):
        """The rows of `places` nearest to x and y, shares of the pitch from a cell's middle: integers of their shape.

        Of two that are equally near, the one of lower number."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        away = (x[..., None] - self.places[:, 0]) ** 2 + (y[..., None] - self.places[:, 1]) ** 2
        return np.argmin(away, axis=-1)

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


def _places(setup, places, counts):
    """Of no cell: all in the middle. A cell without a droplet counts as one of the middle."""
    if places is None:
        return np.zeros((0,), dtype=np.uint8)
    chosen = np.asarray(places)
    if chosen.shape != setup.shape:
        raise ValueError(f"places of shape {chosen.shape}; the grid's is {setup.shape}")
    if not np.issubdtype(chosen.dtype, np.integer):
        raise ValueError(f"places of type {chosen.dtype}; rows of setup.places are integers")
    chosen = np.where(counts != 0, chosen, 0)
    wrong = (chosen < 0) | (chosen >= len(setup.places))
    if wrong.any():
        j, i = np.argwhere(wrong)[0]
        none = "; without actuation.offsets there is the middle alone" if len(setup.places) == 1 else ""
        raise ValueError(f"places: cell ({i}, {j}) has {chosen[j, i]}; setup.places has rows 0 to {len(setup.places) - 1}{none}")
    return np.ascontiguousarray(chosen, dtype=np.uint8) if chosen.any() else np.zeros((0,), dtype=np.uint8)


class SlowError(BaseException):
    """Raised inside code that took too long."""


MOST_DEPTH = 3000  # of calls: at 5000 calls through C, as by sorted(key=...), overflow a stack of 8 MB

_inside = threading.local()  # depth of calls into a controller, of imports of packages therein, and its loader
_packages = set()


@contextlib.contextmanager
def _in_controller(loader):
    _inside.calls, before = getattr(_inside, "calls", 0) + 1, getattr(_inside, "loader", None)
    _inside.loader = loader
    _show(loader.names.values())
    try:
        yield
    finally:
        _hide(loader.names.values())
        _inside.calls -= 1
        _inside.loader = before


class _Shown(types.ModuleType):
    """Stands in sys.modules for a module of files while their code runs: dataclasses and typing look annotations up there.
    Each thread sees the module of its own loader."""

    def __getattribute__(self, name):
        look = types.ModuleType.__getattribute__
        loader = getattr(_inside, "loader", None)
        return look(loader and loader.shown.get(look(self, "__name__")) or self, name)


_shown, _shown_lock = {}, threading.Lock()  # how many calls need a name


def _show(names):
    with _shown_lock:
        for name in names:
            if name in _shown:
                _shown[name] += 1
            elif name not in sys.modules:
                sys.modules[name], _shown[name] = _Shown(name), 1


def _hide(names):
    with _shown_lock:
        for name in names:
            if name in _shown:
                _shown[name] -= 1
                if _shown[name] == 0:
                    del _shown[name], sys.modules[name]


def _guarded():
    return getattr(_inside, "calls", 0) > 0 and getattr(_inside, "imports", 0) == 0


_EVENTS = {
    "open": WORLD, "socket.": WORLD, "subprocess.": WORLD, "os.": WORLD, "shutil.": WORLD, "ctypes.dlopen": WORLD,
    "_thread.": THREADS, "time.sleep": CLOCK,
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


def _bounded(set_limit):
    def setrecursionlimit(limit):
        if limit > MOST_DEPTH and _guarded():
            raise ControllerError(f"sys.setrecursionlimit({limit}): calls may be {MOST_DEPTH} deep: beyond, the stack ends")
        set_limit(min(limit, MOST_DEPTH))

    return setrecursionlimit


def _setlocale(category, name=None):
    if name not in (None, "", "C", "POSIX") and _guarded():
        raise ControllerError(f"locale.setlocale: {LOCALE}")
    return "C"


def make_strict():
    """For an interpreter of Firn's own: what no import shows is refused where it happens."""
    sys.stdout = sys.stderr  # the standard output is the command's
    sys.setrecursionlimit = _bounded(sys.setrecursionlimit)
    locale.setlocale = locale._setlocale = sys.modules["_locale"].setlocale = _setlocale
    sys.addaudithook(_audit)
    for name in np.random.__all__:  # classes apart, these draw from one hidden state
        if name.islower() and name != "default_rng" and callable(getattr(np.random, name)):
            setattr(np.random, name, _refuse_inside(getattr(np.random, name), RANDOM))
    np.random.default_rng = _refuse_inside(np.random.default_rng, RANDOM, lambda seed=None: seed is not None)
    np.random.bit_generator.randbits = _refuse_inside(np.random.bit_generator.randbits, RANDOM)  # of PCG64() and the like


def _no(what, why):
    def refuse(*_, **__):
        raise ControllerError(f"{what}: {why}")
    return refuse


class Loader:
    """Runs files from their recorded text, as modules that nothing else sees."""

    def __init__(self, files):
        self.files, self.modules = dict(files), {}
        # A file may have a name of the library's, whose packages must find the library's.
        stems = [name[: -len(".py")] for name in self.files]
        self.names = {stem: stem + "_py" if stem in sys.stdlib_module_names else stem for stem in stems}
        self.shown = {}  # by those names
        self.builtins = dict(vars(builtins), __import__=self._import, open=_no("open", WORLD), input=_no("input", WORLD),
                             id=_no("id", "an address differs from run to run"), breakpoint=_no("breakpoint", WORLD))
        for name, text in self.files.items():
            linecache.cache[name] = (len(text), None, text.splitlines(True), name)

    def module(self, stem):
        name = stem + ".py"
        if stem not in self.modules:
            module = types.ModuleType(self.names[stem])
            module.__file__, module.__builtins__ = name, self.builtins
            self.modules[stem] = self.shown[module.__name__] = module
            try:
                exec(compile(self.files[name], name, "exec", dont_inherit=True), vars(module))
            except BaseException:
                del self.modules[stem], self.shown[module.__name__]
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


class _Made:
    """An object of a class in files."""

    method = "decide"

    def __init__(self, files, class_name, arguments, setup):
        self.setup, self.names = setup, {name for name, _ in files}
        self.what = f"{files[0][0]}: {class_name}"
        self.loader = loader = Loader(files)
        with _in_controller(loader):
            module = loader.module(files[0][0][: -len(".py")])
            made = getattr(module, class_name, None)
            if not isinstance(made, type):
                known = [n for n, v in vars(module).items() if isinstance(v, type) and v.__module__ == module.__name__]
                raise ControllerError(f"{files[0][0]} has no class {class_name}; its classes: {', '.join(known) or 'none'}")
            if not callable(getattr(made, self.method, None)):
                raise ControllerError(f"{self.what} has no method {self.method}(self, {self.argument})")
            self.controller = made(setup, **_arguments(arguments, self.what))

    argument = "measurement"

    def explain(self, error):
        return explain(error, self.names)


class Run(_Made):
    """A controller's object with its files."""

    def decide(self, height_mm, layer, attempt, noise_std_mm):
        """(kind, drops, places, reason): kind 0 print, 1 end, 2 stop."""
        height_mm.flags.writeable = False
        with _in_controller(self.loader):
            answer = self.controller.decide(Measurement(height_mm, layer, attempt, noise_std_mm))
        if not isinstance(answer, (Print, End, Stop)):
            raise ControllerError(f"{self.what}.decide returned {type(answer).__name__}, not firn.Print, firn.End or firn.Stop")
        reason = _plain(str(answer.reason))[:1000]
        if not isinstance(answer, Print):
            return (1 if isinstance(answer, End) else 2), None, None, reason
        try:
            drops = _drops(self.setup, answer.drops)
            places = _places(self.setup, answer.places, drops)
        except ValueError as error:
            raise ControllerError(f"{self.what}.decide, layer {layer + 1}: {error}") from None
        if not drops.any():
            raise ControllerError(f"{self.what}.decide, layer {layer + 1}: Print of no droplet; End finishes the part")
        return 0, drops, places, reason

    def use_model(self, h1_mm, h2_mm, h3_mm):
        """The newest estimate of a droplet's rise; a class without the method keeps the first."""
        take = getattr(self.controller, "use_model", None)
        if callable(take):
            with _in_controller(self.loader):
                take(h1_mm, h2_mm, h3_mm)


class _ObjectRun(_Made):
    """An object that is called with named arrays, and answers with some and a text."""

    def __init__(self, files, class_name, arguments, setup):
        super().__init__(files, class_name, arguments, Values(**_frozen(setup)))

    def call(self, arrays):
        given = _frozen(arrays)
        with _in_controller(self.loader):
            answer = getattr(self.controller, self.method)(self.given(**given))
        try:
            return self.told(answer, given)
        except ControllerError:
            raise
        except (TypeError, ValueError, AttributeError) as error:
            raise ControllerError(f"{self.what}.{self.method}, layer {given['layer']}: {error}") from None


_WHOLE, _FLAGS = ("layer", "attempt", "last_layer"), ("mask", "learn")


def _frozen(arrays):
    """Whole numbers as int, flags as bool, and arrays that cannot be written to."""
    given = {}
    for name, value in arrays.items():
        if isinstance(value, np.ndarray):
            value = value.astype(bool) if name in _FLAGS else value
            value.flags.writeable = False
        elif name in _WHOLE:
            value = int(value)
        given[name] = value
    if "ny" in given:
        given["shape"] = (int(given.pop("ny")), int(given.pop("nx")))
    if "seed_low" in given:  # a double holds 53 bits
        given["seed"] = int(given.pop("seed_high")) << 32 | int(given.pop("seed_low"))
    return given


def _numbers(name, values, shape, what="(ny, nx)"):
    array = np.array(values, dtype=np.float64, order="C")
    if shape is not None and array.shape != shape:
        raise ValueError(f"{name} of shape {array.shape}; {what} is {shape}")
    return array


def _finite(name, array):
    if not np.isfinite(array).all():
        raise ValueError(f"{name}: a value is not finite")
    return array


class EstimatorRun(_ObjectRun):
    """An estimator's object."""

    method, argument, given = "learn", "layer", Layer

    def told(self, answer, given):
        if answer is None:
            return {}, ""
        if not isinstance(answer, Model):
            raise ValueError(f"returned {type(answer).__name__}, not firn.Model or None")
        told = {name: _finite(name, _numbers(name, getattr(answer, name), (), "a number"))
                for name in ("h1_mm", "h2_mm", "h3_mm", "droplet_scatter")}
        for name, value in told.items():
            if not 0 <= value <= 10 or name == "h1_mm" and value == 0:
                raise ValueError(f"{name} = {value} must lie in {'(' if name == 'h1_mm' else '['}0, 10]")
        covariance = np.zeros((3, 3)) if answer.covariance_mm2 is None else answer.covariance_mm2
        told["covariance_mm2"] = _finite("covariance_mm2", _numbers("covariance_mm2", covariance, (3, 3), "that of h1, h2, h3"))
        if np.abs(covariance).max() > 1e4 or np.diag(covariance).min() < 0:
            raise ValueError("covariance_mm2 must lie within +-1e4, its diagonal not below 0")
        return told, ""


MOST_MEMORY = 1 << 20


class PlantRun(_ObjectRun):
    """A plant's object."""

    method, argument, given = "deposit", "landed", Landed

    def told(self, answer, given):
        if not isinstance(answer, Surface):
            answer = Surface(answer)
        height = _finite("height_mm", _numbers("height_mm", answer.height_mm, given["height_mm"].shape))
        memory = _numbers("memory", answer.memory, None)
        if memory.ndim != 1 or memory.size > MOST_MEMORY:
            raise ValueError(f"memory of shape {memory.shape}; numbers (n,), at most {MOST_MEMORY}, are kept")
        return {"height_mm": height, "memory": memory}, ""


class SurfaceRun(_ObjectRun):
    """The object of a controller of paths."""

    method, argument, given = "decide", "interval", Interval

    def told(self, answer, given):
        if not isinstance(answer, (Action, End, Stop)):
            raise ControllerError(f"{self.what}.decide returned {type(answer).__name__}, not firn.Action, firn.End or firn.Stop")
        reason = _plain(str(answer.reason))[:1000]
        if not isinstance(answer, Action):
            return {"kind": 1.0 if isinstance(answer, End) else 2.0}, reason
        u = _numbers("u", answer.u, given["material"].shape)
        inside = given["material"] > 0
        _finite("u", u[inside])
        return {"kind": 0.0, "u": u}, reason


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
    elif isinstance(error, MemoryError):
        last += ": a call may take half of the machine's memory"
    return "Traceback of the controller:\n" + own + last if frames else last
