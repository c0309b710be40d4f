"""Recorded runs and logs."""
import csv
import io
import json
import pathlib
import shutil
import subprocess
import tempfile
import weakref
import zipfile

import numpy as np

from .program import FirnError, call, program


def scratch_folder(owner):
    """A temporary folder that goes when `owner` does, or at the end of the process."""
    folder = tempfile.mkdtemp(prefix="firn-")
    weakref.finalize(owner, shutil.rmtree, folder, ignore_errors=True)
    return pathlib.Path(folder)


class Table:
    """Messages of one channel: a column for each member, a row for each message in the order of the log.

    Columns are attributes and items: maps (rows, ny, nx), values (rows,), lists with NAME_first and NAME_count, which say
    where the values of a row lie among those of all.
    """

    def __init__(self, name, arrays, columns):
        self.name, self._arrays, self._columns = name, arrays, columns

    def keys(self):
        """Names of the columns."""
        return list(self._columns)

    def unit(self, column):
        """Unit of a column: "mm"; "1" of a pure number, "text"."""
        return self._column(column)["unit"]

    def about(self, column):
        """A sentence about a column."""
        return self._column(column)["description"]

    def _column(self, column):
        if column not in self._columns:
            raise KeyError(f"{self.name} has no column {column}; it has {', '.join(self._columns)}")
        return self._columns[column]

    def __getitem__(self, column):
        return self._arrays[self._column(column)["array"]]

    def __getattr__(self, column):
        if column.startswith("_"):
            raise AttributeError(column)
        try:
            return self[column]
        except KeyError as error:
            raise AttributeError(error.args[0]) from None

    def __len__(self):
        return len(self[next(iter(self._columns))])

    def __repr__(self):
        return f"<firn.Table {self.name}: {len(self)} rows of {', '.join(self._columns)}>"


class _Arrays:
    """Arrays of an .npz, each read when it is asked for first, with its numbers in the machine's order of bytes."""

    def __init__(self, file):
        self.file, self.read = file, {}

    def __getitem__(self, name):
        if name not in self.read:
            with np.load(self.file, allow_pickle=False) as arrays:
                values = arrays[name]
            self.read[name] = values.astype(values.dtype.newbyteorder("="), copy=False)
        return self.read[name]


class Run:
    """A recorded run, plain or packed.

    Its log is converted when the first array is asked for, and an array is read when it is asked for.

    >>> run = Run("runs/2026-11-24T10-00-00-cuboid")              # doctest: +SKIP
    >>> run.maps.height_mm.shape, run["LAYER_METRICS"].rms_mm     # doctest: +SKIP
    """

    def __init__(self, path):
        self.path = pathlib.Path(path)
        for name in ("experiment.toml", "provenance.json", "nodes"):
            if not (self.path / name).exists():
                raise FirnError(f"{path}: is no run folder: it has no {name}")
        self._tables = None

    def _load(self):
        if self._tables is not None:
            return self._tables
        file = scratch_folder(self) / "run.npz"
        call("export", self.path, "-o", file)
        with zipfile.ZipFile(file) as members:
            rows = list(csv.DictReader(io.StringIO(members.read("columns.csv").decode())))
        arrays, columns = _Arrays(file), {}
        for row in rows:
            table, _, column = row["array"].rpartition("/")
            columns.setdefault(table, {})[column] = row
        self._tables = {t.split("/")[-1]: Table(t, arrays, c) for t, c in columns.items() if t.split("/")[0] != "provenance"}
        return self._tables

    def keys(self):
        """Channels of the log, and `target` and `mask`."""
        return [name for name in self._load() if name != "configuration"]

    def __getitem__(self, channel):
        tables = self._load()
        if channel not in tables:
            raise KeyError(f"{self.path}: no {channel}; there are {', '.join(self.keys())}")
        return tables[channel]

    def __contains__(self, channel):
        return channel in self._load()

    @property
    def maps(self):
        """HEIGHT_MAP: height_mm (rows, ny, nx)."""
        return self["HEIGHT_MAP"]

    @property
    def metrics(self):
        """LAYER_METRICS: mean_error_mm, rms_mm, … of each layer."""
        return self["LAYER_METRICS"]

    @property
    def decisions(self):
        """LAYER_PLAN: drops (rows, ny, nx), objective_mm, reason."""
        return self["LAYER_PLAN"]

    @property
    def target_mm(self):
        """(ny, nx) wanted heights [mm]."""
        return self["target"].height_mm[0]

    @property
    def mask(self):
        """(ny, nx) bool: the part."""
        return self["mask"].inside[0] != 0

    @property
    def experiment_toml(self):
        """The experiment with every key resolved."""
        return (self.path / "experiment.toml").read_text()

    @property
    def provenance(self):
        """Program, platform, inputs: a dict."""
        return json.loads((self.path / "provenance.json").read_text())

    @property
    def meta(self):
        """[meta] of the experiment, operator, sample, ink, …: a dict."""
        return self.provenance.get("meta", {})

    @property
    def host(self):
        """Name of the computer that printed; None of an older run."""
        return self.provenance.get("host")

    def _entries(self):
        file = self.path / "notes.jsonl"
        lines = file.read_text().split("\n") if file.is_file() else []
        entries = []
        for line in filter(None, lines):
            try:
                entries.append(json.loads(line))
            except json.JSONDecodeError:  # torn by a kill
                continue
        return entries

    @property
    def notes(self):
        """What people wrote about the run, oldest first: dicts with text, author, time_utc and host."""
        return [{k: v for k, v in e.items() if k != "kind"} for e in self._entries() if e["kind"] == "note"]

    @property
    def tags(self):
        """Tags that are set, in the order in which they were."""
        tags = {}
        for entry in self._entries():
            if entry["kind"] != "note":
                tags.pop(entry["text"], None)
            if entry["kind"] == "tag":
                tags[entry["text"]] = True
        return list(tags)

    @property
    def result(self):
        """Outcome and reason: a dict; None while the run has not ended."""
        file = self.path / "result.json"
        return json.loads(file.read_text()) if file.is_file() else None

    def __repr__(self):
        return f"<firn.Run {self.path}>"


def read_log(file, channel=None, types=None):
    """Messages of an LCM log in its order, one at a time: (channel, time stamp [us], message as a dict).

    channel  only this one
    types    a folder of .lcm files, for a log of others
    """
    words = ["log", "cat", str(file), "--full", *(["-c", channel] if channel else []), *(["--types", str(types)] if types else [])]
    with tempfile.TemporaryFile("w+") as said, \
            subprocess.Popen([program(), *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=said, text=True) as process:
        try:
            for line in process.stdout:
                event = json.loads(line)
                yield event["channel"], event["utime_us"], event["message"]
        except GeneratorExit:
            process.kill()
            raise
        process.wait()
        if process.returncode:
            said.seek(0)
            raise FirnError(said.read().strip()[-4000:])
