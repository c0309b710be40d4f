"""Runs one driver class in Python: the program behind [devices.NODE] kind = "python:FILE.py:CLASS".

    python3 -c TEXT NAME=PATH ...        its modules; the conversation is on file descriptor 3

drivers/script/script_talk.h describes the lines. Inside, the module `firn` holds Refused, Stopped and note;
docs/write-a-driver.md describes the class.
"""
import builtins
import importlib.util
import linecache
import os
import queue
import re
import signal
import sys
import threading
import time
import traceback
import types

CHANNEL = 3
STOP_GRACE_S = 0.5  # beyond a method's own time, until the kernel ends a program whose interpreter hangs
PLAIN = re.compile(rb"[^A-Za-z0-9_./-]")


class Refused(Exception):
    """Raise it for an order that the instrument does not take: nothing has happened."""


class Stopped(BaseException):
    """Raised inside a method that a stop breaks off; safe() is called next."""


def encoded(text):
    return PLAIN.sub(lambda byte: b"%%%02x" % byte.group()[0], str(text).encode()).decode()


def decoded(text):
    return re.sub(rb"%(..)", lambda byte: bytes([int(byte.group(1), 16)]), text.encode()).decode()


def number(text):
    return int(text) if re.fullmatch(r"-?\d+", text) else float(text)


def flat(value):
    """The numbers of a value, row by row; bool counts as 0 or 1, None as no number."""
    if hasattr(value, "tolist"):  # numpy
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [one for part in value for one in flat(part)]
    if value is None:
        return [float("nan")]
    if not isinstance(value, (bool, int, float)):
        raise TypeError(f"{value!r} is no number")
    return [float(value)]


def number_text(one):
    if one != one:
        return "nan"
    if one in (float("inf"), float("-inf")):
        raise ValueError("an infinite number")
    return "%d" % one if one == int(one) and abs(one) < 1e15 else repr(one)


def value_text(value):
    return ",".join(number_text(one) for one in flat(value))


def named_text(name, value):
    """name=numbers; of a table, with the number of its rows."""
    return f"{name}={value_text(value)}" + (f" {name}_rows={len(value)}" if is_table(value) else "")


def is_table(value):
    if hasattr(value, "shape"):
        return len(value.shape) == 2
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(row, (list, tuple)) for row in value)


def answer_text(value):
    """Text and values of what a method returned: None, a text, numbers, or a dict of these."""
    if value is None:
        return ":"
    if isinstance(value, str):
        return ":" + encoded(value)
    values = value if isinstance(value, dict) else {"value": value}
    return " ".join([":" + encoded(values.get("text", "")),
                     *(named_text(name, one) for name, one in values.items() if name != "text")])


class Port:
    """The instrument's port, which Firn holds: bytes go through it, and are recorded there.

    end        of a line, both ways
    timeout_s  longest wait of read, read_line and ask, unless they name another
    """

    def __init__(self, program):
        self._program, self._condition = program, threading.Condition()
        self._heard, self._open = bytearray(), True
        self.end, self.timeout_s = "\n", 1.0

    def write(self, data):
        data = data.encode("latin-1") if isinstance(data, str) else bytes(data)
        if data:
            self._program.say(f"write {self._program.call} {data.hex()}")

    def drop(self):
        """Forgets what has come."""
        with self._condition:
            self._heard.clear()

    def read(self, count=1, timeout_s=None):
        """Returns the next `count` bytes. Raises TimeoutError."""
        return self._take(lambda heard: count if len(heard) >= count else 0, timeout_s, f"{count} bytes")

    def read_line(self, timeout_s=None):
        """Returns the next line as text, without its end. Raises TimeoutError."""
        end = self.end.encode("latin-1")
        line = self._take(lambda heard: heard.find(end) + len(end) if end in heard else 0, timeout_s, "a line")
        return line[:len(line) - len(end)].decode("latin-1")

    def ask(self, text, timeout_s=None):
        """Forgets what has come, sends the line and returns the next one."""
        self.drop()
        self.write(text + self.end)
        return self.read_line(timeout_s)

    def _take(self, size, timeout_s, wanted):
        limit_s = self.timeout_s if timeout_s is None else timeout_s
        until = time.monotonic() + limit_s
        with self._condition:
            while True:
                if not self._open:
                    raise ConnectionError("the instrument's port is closed")
                if count := size(self._heard):
                    taken = bytes(self._heard[:count])
                    del self._heard[:count]
                    return taken
                left = until - time.monotonic()
                if left <= 0:
                    heard = f"; {bytes(self._heard[:40])!r} came" if self._heard else ""
                    raise TimeoutError(f"no {wanted.removeprefix('a ')} within {limit_s:g} s{heard}")
                self._condition.wait(min(left, 0.05))  # a signal's handler runs between two waits

    def _take_in(self, data):
        with self._condition:
            self._heard += data
            self._condition.notify_all()

    def _is(self, is_open):
        with self._condition:
            self._open = is_open
            if is_open:
                self._heard.clear()
            self._condition.notify_all()


class Files:
    """Finds the modules of the class in the files that Firn names, ahead of all others."""

    def __init__(self, files):
        self.files = files

    def find_spec(self, name, path=None, target=None):
        file = self.files.get(name + ".py")
        return file and importlib.util.spec_from_loader(name, self, origin=name + ".py")

    def create_module(self, spec):
        return None

    def exec_module(self, module):
        name = module.__spec__.origin
        with open(self.files[name], encoding="utf-8-sig") as file:
            text = file.read()
        module.__file__ = name
        linecache.cache[name] = (len(text), None, text.splitlines(True), name)
        exec(compile(text, name, "exec"), module.__dict__)


class Program:
    def __init__(self, names):
        self.files = dict(word.split("=", 1) for word in names)
        self.lines, self.lock = queue.SimpleQueue(), threading.Lock()
        self.call, self.inside, self.stop_asked, self.limit_s = 0, False, False, 1.0
        self.port, self.type, self.object, self.arguments, self.has_line = None, None, None, "", False

    def say(self, line):
        """Sends a line whole: a stop does not break it off."""
        main = threading.current_thread() is threading.main_thread()
        inside = main and self.inside
        if main:
            self.inside = False
        data = memoryview((line + "\n").encode())
        try:
            with self.lock:
                while data:
                    data = data[os.write(CHANNEL, data):]
        except OSError:
            pass  # Firn has closed it: the reader's thread sees that
        if inside:
            self.inside = True
            if self.stop_asked:
                self.inside = False
                raise Stopped()

    # The reader's thread.
    def listen(self):
        rest = b""
        while True:
            try:
                data = os.read(CHANNEL, 1 << 16)
            except OSError:
                data = b""
            if not data:
                break
            *whole, rest = (rest + data).split(b"\n")
            for line in whole:
                self.hear(line.decode())
        self.break_off()
        self.lines.put("end")

    def hear(self, line):
        word, _, rest = line.partition(" ")
        if word == "bytes":
            self.port._take_in(bytes.fromhex(rest))
        elif word == "line":
            self.port._is(rest == "1")
        else:
            if word == "stop":
                self.break_off()
            self.lines.put(line)

    def break_off(self):
        self.stop_asked = True
        if self.inside:
            signal.pthread_kill(threading.main_thread().ident, signal.SIGUSR1)

    # The main thread.
    def on_stop(self, *_):
        if self.inside and self.stop_asked:
            self.inside = False
            raise Stopped()

    def limited(self, limit_s, run):
        """Runs a method; the kernel ends the program if not even the interpreter comes back."""
        signal.setitimer(signal.ITIMER_REAL, limit_s + STOP_GRACE_S)
        try:
            return run()
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)

    def attempt(self, call, run):
        """Answers one request with what `run` returns or raises."""
        self.call = call
        try:
            try:
                self.inside = True
                if self.stop_asked:
                    raise Stopped()
                value = run()
            finally:
                self.inside = False
            self.say(f"done {call} {answer_text(value)}")
        except Stopped:
            self.say(f"fail {call} stopped :")
        except Refused as error:
            self.say(f"fail {call} refused :{encoded(error)}")
        except TimeoutError as error:
            self.say(f"fail {call} late :{encoded(self.told(error))}")
        except BaseException as error:  # SystemExit too: an answer is owed
            self.say(f"fail {call} error :{encoded(self.told(error))}")

    def told(self, error):
        """psu.py, line 12: ValueError: could not convert string to float: 'x'"""
        said = "".join(traceback.format_exception_only(type(error), error)).strip().splitlines()[-1]
        at = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename in self.files]
        if isinstance(error, SyntaxError):
            return f"{error.filename}, line {error.lineno}: {said}"
        return f"{at[-1].filename}, line {at[-1].lineno}: {said}" if at else said

    def begin(self, file, class_name, arguments, line, methods):
        self.arguments, self.has_line = decoded(arguments[1:]), line == "1"
        self.port = Port(self)
        module = importlib.import_module(file.removesuffix(".py"))
        self.type = getattr(module, class_name, None)
        if not isinstance(self.type, type):
            raise TypeError(f"{file} has no class {class_name}")
        missing = [name for name in methods if not callable(getattr(self.type, name, None))]
        if missing:
            raise TypeError(f"class {class_name} has no method " + ", ".join(name + "()" for name in missing))
        told = {"text": "Python " + sys.version.split()[0]} | {"has_" + name: 1 for name in dir(self.type)
                if not name.startswith("_") and callable(getattr(self.type, name))}
        told["timeout_s"] = float(getattr(self.type, "timeout_s", 1.0))
        told |= {"time_" + name: float(limit) for name, limit in getattr(self.type, "times_s", {}).items()}
        safe = getattr(self.type, "safe_bytes", None)
        if safe is not None:
            told["safe_bytes"] = list(safe.encode("latin-1") if isinstance(safe, str) else bytes(safe))
        if "has_poll" in told:
            told["poll_s"] = float(getattr(self.type, "poll_s", 1.0))
        return told

    def connect(self):
        self.object = eval(f"make({'port, ' if self.has_line else ''}{self.arguments})",
                           {"make": self.type, "port": self.port, "__builtins__": builtins})

    def run(self, line):
        word, call, *rest = line.split(" ")
        call = int(call)
        if word == "begin":
            return self.attempt(call, lambda: self.begin(*rest[:4], rest[4:]))
        limit_s, *rest = rest
        limit_s = self.limit_s = float(limit_s)
        if word == "stop":
            self.stop_asked = False
            return self.attempt(call, lambda: self.limited(limit_s, self.object.safe))
        method, *words = rest
        if method == "connect":
            return self.attempt(call, lambda: self.limited(limit_s, self.connect))
        values = {}
        for pair in words:
            name, _, text = pair.partition("=")
            numbers = [number(one) for one in text.split(",")] if text else []
            values[name.lstrip("*")] = numbers[0] if len(numbers) == 1 and not name.startswith("*") else numbers
        return self.attempt(call, lambda: self.limited(limit_s, lambda: getattr(self.object, method)(**values)))

    def serve(self):
        signal.signal(signal.SIGUSR1, self.on_stop)
        threading.Thread(target=self.listen, daemon=True).start()
        while (line := self.lines.get()) != "end":
            self.run(line)
        # Firn is gone, or gives this program up. Where bytes pass through Firn it has made the instrument safe.
        if self.object is not None and not self.has_line:
            self.limited(self.limit_s, self.object.safe)


def main():
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    os.dup2(2, 1)  # what the class prints belongs to the messages
    sys.path[:] = [folder for folder in sys.path if folder]  # a module beside the run is no input of it
    program = Program(sys.argv[1:])
    firn = types.ModuleType("firn")
    firn.Refused, firn.Stopped = Refused, Stopped
    firn.note = lambda text: program.say(f"note :{encoded(text)}")
    sys.modules["firn"] = firn
    sys.meta_path.insert(0, Files(program.files))
    program.serve()
    os._exit(0)  # a thread of the class may hang


main()
