#!/usr/bin/env python3
"""`firn export`: each recorded run of tests/replay/golden is exported and read back with h5py, h5dump, xarray (by h5netcdf and by
the netCDF library), numpy and csv. Every number must be the one that `firn log cat` prints.

    tests/cli/export_test.py FIRN ROOT [Case.test]
"""
import base64
import csv
import json
import math
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zipfile
import zlib
from pathlib import Path

import h5py
import numpy as np
import xarray

FIRN = ROOT = None
RUNS = ("v1-mpc", "v2-two-inks", "v5-ice")


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    if code is not None and done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done


def messages(run):
    """{(channel): [event]} of a run's log."""
    found = {}
    for line in firn("log", "cat", run / "log.lcm", "--full").stdout.splitlines():
        event = json.loads(line)
        found.setdefault(event["channel"], []).append(event)
    return found


def members(message, prefix=""):
    """{column: value} as the export names them."""
    found = {}
    for name, value in message.items():
        if isinstance(value, dict):
            found.update(members(value, "" if name == "header" else name + "_"))
        else:
            found[prefix + name] = value
    return found


def same(expected, value):
    if isinstance(expected, str):
        if expected in ("Infinity", "-Infinity"):
            return float(expected) == value
        return expected == (value.decode() if isinstance(value, bytes) else str(value))
    if expected is None:
        return math.isnan(value)
    if isinstance(value, (np.float32,)):
        return np.float32(expected) == value
    return expected == value


def read_csv(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


class Hdf5:
    def __init__(self, path):
        self.file = h5py.File(path)

    def tables(self):
        found = {}
        self.file.visititems(lambda name, node: found.update({name: node}) if isinstance(node, h5py.Group)
                             and "log_event" in node else None)
        return found

    def close(self):
        self.file.close()


class Npz:
    def __init__(self, path):
        self.file = np.load(path)

    def tables(self):
        found = {}
        for name in self.file.files:
            if name.endswith("/log_event"):
                table = name[:-len("/log_event")]
                found[table] = {n[len(table) + 1:]: self.file[n] for n in self.file.files
                                if n.startswith(table + "/")}
        return found

    def close(self):
        self.file.close()


def records(data, at=0, end=None):
    """(place, opcode, content) of the records of an .mcap file or chunk."""
    while at < (len(data) if end is None else end):
        code, length = struct.unpack_from("<BQ", data, at)
        yield at, code, data[at + 9:at + 9 + length]
        at += 9 + length


def texts(content, at, count):
    found = []
    for _ in range(count):
        n = struct.unpack_from("<I", content, at)[0]
        found.append(content[at + 4:at + 4 + n].decode())
        at += 4 + n
    return found, at


class Mcap:
    """An .mcap file by its specification (https://mcap.dev/spec), with every checksum and index looked at."""

    def __init__(self, data):
        assert data[:8] == data[-8:] == b"\x89MCAP0\r\n"
        self.schemas, self.channels, self.messages, self.attachments = {}, {}, [], {}
        whole = {at: (code, content) for at, code, content in records(data, 8, len(data) - 8)}
        for at, (code, content) in whole.items():
            if code == 0x06:
                self.chunk(content)
            elif code == 0x09:
                (name, _), end = texts(content, 16, 2)
                size = struct.unpack_from("<Q", content, end)[0]
                self.attachments[name] = content[end + 8:end + 8 + size]
                assert struct.unpack_from("<I", content, end + 8 + size)[0] == zlib.crc32(content[:end + 8 + size])
            elif code == 0x08:
                first, last, place, length, n = struct.unpack_from("<QQQQI", content)
                assert whole[place][0] == 0x06 and len(whole[place][1]) + 9 == length
                for k in range(n // 10):
                    channel, index = struct.unpack_from("<HQ", content, 36 + 10 * k)
                    assert whole[index][0] == 0x07 and struct.unpack_from("<H", whole[index][1])[0] == channel
            elif code == 0x0b:
                self.counted = struct.unpack_from("<Q", content)[0]
            elif code == 0x02:
                summary, offsets, _ = struct.unpack("<QQI", content)
                assert whole[summary][0] == 0x03 and whole[offsets][0] == 0x0e

    def chunk(self, content):
        _, _, size, crc = struct.unpack_from("<QQQI", content)
        (how,), at = texts(content, 28, 1)
        assert how == "zstd"
        plain = subprocess.run(["zstd", "-d", "-c"], input=content[at + 8:], capture_output=True, check=True).stdout
        assert len(plain) == size and zlib.crc32(plain) == crc
        for _, code, inner in records(plain):
            if code == 0x03:
                (name, encoding, data), _ = texts(inner, 2, 3)
                self.schemas[struct.unpack_from("<H", inner)[0]] = (name, encoding, data)
            elif code == 0x04:
                number, schema = struct.unpack_from("<HH", inner)
                (topic, encoding), _ = texts(inner, 4, 2)
                self.channels[number] = (topic, encoding, schema)
            elif code == 0x05:
                channel, sequence, time_ns, _ = struct.unpack_from("<HIQQ", inner)
                self.messages.append((*self.channels[channel], sequence, time_ns, inner[22:]))


class Export(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def compare(self, tables, run):
        """Every row of every table against the log; every message of the log in one row."""
        logged = messages(run)
        seen = {}
        for path, table in tables.items():
            channel = path.split("/")[1]
            while channel not in logged:  # HEIGHT_MAP_2: another grid
                channel = channel.rsplit("_", 1)[0]
            by_number = {e["event"]: e for e in logged[channel]}
            columns = {name: table[name][()] for name in table}
            for row, number in enumerate(columns["log_event"]):
                event = by_number[int(number)]
                seen.setdefault(channel, set()).add(int(number))
                self.assertEqual(int(columns["log_utime_us"][row]), event["utime_us"])
                for name, expected in members(event["message"]).items():
                    where = f"{path}/{name} event {number}"
                    values = columns[name]
                    if isinstance(expected, list):
                        if values.ndim == 3:
                            values = values[row].ravel()
                        else:
                            first, count = int(columns[name + "_first"][row]), int(columns[name + "_count"][row])
                            values = values[first:first + count]
                        self.assertEqual(len(values), len(expected), where)
                        for e, v in zip(expected, values):
                            self.assertTrue(same(e, v), f"{where}: {e} {v}")
                    else:
                        self.assertTrue(same(expected, values[row]), f"{where}: {expected} {values[row]}")
        self.assertEqual(seen, {channel: {e["event"] for e in events} for channel, events in logged.items()})

    def compare_all_runs(self, ending, reader):
        for name in RUNS:
            with self.subTest(run=name):
                run = ROOT / "tests/replay/golden" / name
                firn("export", run, "-o", self.folder / f"{name}.{ending}")
                opened = reader(self.folder / f"{name}.{ending}")
                self.compare(opened.tables(), run)
                opened.close()

    def test_hdf5_holds_every_number_of_the_log(self):
        self.compare_all_runs("h5", Hdf5)

    def test_npz_holds_every_number_of_the_log(self):
        self.compare_all_runs("npz", Npz)

    def test_csv_holds_every_number_of_the_log(self):
        run = ROOT / "tests/replay/golden/v1-mpc"
        out = self.folder / "run.csv"
        firn("export", run, "-o", out)
        logged = messages(run)
        rows = read_csv(out / "metrics/LAYER_METRICS.csv")
        self.assertEqual(len(rows), len(logged["LAYER_METRICS"]))
        for row, event in zip(rows, logged["LAYER_METRICS"]):
            for name, expected in members(event["message"]).items():
                self.assertEqual(float(row[name]), float(expected), name)
        cells = read_csv(out / "maps/HEIGHT_MAP.height_mm.csv")
        expected = [h for e in logged["HEIGHT_MAP"] for h in e["message"]["height_mm"]]
        self.assertEqual(len(cells), len(expected))
        for cell, e in zip(cells, expected):
            self.assertTrue(same(e, np.float32(cell["height_mm"])), cell)
        grid = logged["HEIGHT_MAP"][0]["message"]["grid"]
        last = cells[-1]
        self.assertEqual(float(last["x_mm"]), grid["origin_x_mm"] + (grid["nx"] - 1) * grid["pitch_x_mm"])
        self.assertEqual((int(last["j"]), int(last["i"])), (grid["ny"] - 1, grid["nx"] - 1))
        listed = {(r["file"], r["column"]) for r in read_csv(out / "columns.csv")}
        for file in out.rglob("*.csv"):
            name = file.relative_to(out).as_posix()
            if name != "columns.csv":
                self.assertTrue(any(f == name for f, _ in listed), name)

    def test_mcap_holds_every_message_as_json_and_as_lcm(self):
        for name in RUNS:
            run = ROOT / "tests/replay/golden" / name
            firn("export", run, "-o", self.folder / f"{name}.mcap")
            file = Mcap((self.folder / f"{name}.mcap").read_bytes())
            logged = {e["event"]: e for events in messages(run).values() for e in events}
            log, raw, at = (run / "log.lcm").read_bytes(), {}, 0
            while at < len(log):
                _, number, _, channel, size = struct.unpack_from(">IqqII", log, at)
                raw[number] = log[at + 28 + channel:at + 28 + channel + size]
                at += 28 + channel + size
            self.assertEqual(file.counted, len(file.messages))
            own = [m for m in file.messages if not m[0].startswith("/foxglove/")]
            self.assertEqual(len(own), 2 * len(logged))
            for topic, encoding, schema, number, time_ns, data in own:
                event = logged[number]
                self.assertEqual(topic, ("/" if encoding == "json" else "/lcm/") + event["channel"])
                self.assertEqual(time_ns, 1000 * event["utime_us"])
                self.assertEqual(file.schemas[schema][0], "firn." + event["type"])
                if encoding == "json":
                    self.assertEqual(json.loads(data), event["message"])
                    self.assertEqual(set(json.loads(file.schemas[schema][2])["properties"]), set(event["message"]))
                else:
                    self.assertEqual(data, raw[number])
            self.assertEqual(file.attachments["experiment.toml"], (run / "experiment.toml").read_bytes())
            types = self.folder / f"types-{name}"  # the .lcm texts explain the log
            types.mkdir()
            for number, (type_name, encoding, text) in file.schemas.items():
                if encoding == "lcm":
                    (types / f"{number}.lcm").write_text(text)
            info = json.loads(firn("log", "info", run / "log.lcm", "--types", types, "--json").stdout)
            self.assertEqual(info["problems"], [])

    def test_every_dataset_has_a_unit_and_a_sentence_and_types_that_all_readers_have(self):
        for name in RUNS:
            run = ROOT / "tests/replay/golden" / name
            firn("export", run, "-o", self.folder / f"{name}.h5")
            with h5py.File(self.folder / f"{name}.h5") as file:
                def look(path, node):
                    self.assertTrue(isinstance(node, h5py.Group) or len(node.attrs["units"]) > 0, path)
                    if isinstance(node, h5py.Group) and "log_event" not in node:
                        return
                    self.assertGreater(len(node.attrs["description"]), 10, path)
                    if isinstance(node, h5py.Dataset):
                        self.assertTrue(h5py.check_string_dtype(node.dtype) or node.dtype.kind in "iuf", path)
                        if node.ndim == 3:
                            self.assertEqual(node.chunks, (1, *node.shape[1:]), path)
                            self.assertEqual(node.compression, "gzip", path)
                            self.assertIn("pitch_x_mm", node.attrs)
                file.visititems(look)
                if name == "v1-mpc":
                    height = file["maps/HEIGHT_MAP/height_mm"]
                    self.assertEqual(height.attrs["units"], "mm")
                    self.assertEqual(len(file["maps/HEIGHT_MAP/grid_x_mm"]), height.shape[2])
                    self.assertIn("kMeasured = 0", file["maps/HEIGHT_MAP/quality"].attrs["values"])
                    self.assertEqual(file["configuration/experiment_toml"][()].decode(),
                                     (run / "experiment.toml").read_text())
                    self.assertEqual(json.loads(file["provenance/provenance_json"][()]),
                                     json.loads((run / "provenance.json").read_text()))
                    self.assertEqual(file["configuration/target/height_mm"].shape[1:], height.shape[1:])
                    for group in ("maps", "droplets", "decisions", "metrics", "devices", "events", "truth",
                                  "configuration", "provenance"):
                        self.assertIn(group, file)

    def test_h5dump_reads_the_file_and_its_checks(self):
        firn("export", ROOT / "tests/replay/golden/v1-mpc", "-o", self.folder / "x.h5")
        dump = subprocess.run(["h5dump", "-d", "/metrics/LAYER_METRICS/rms_mm", self.folder / "x.h5"],
                              capture_output=True, text=True, check=True).stdout
        self.assertIn("H5T_IEEE_F64LE", dump)
        self.assertIn('ATTRIBUTE "units"', dump)
        whole = subprocess.run(["h5dump", "-H", self.folder / "x.h5"], capture_output=True, text=True, check=True)
        self.assertEqual(whole.stderr, "")
        for type_name in ("H5T_OPAQUE", "H5T_ENUM", "H5T_BITFIELD"):
            self.assertNotIn(type_name, whole.stdout)

    def exported(self, name):
        run, file = ROOT / "tests/replay/golden" / name, self.folder / f"{name}.h5"
        firn("export", run, "-o", file)
        return run, file

    def test_texts_of_hdf5_are_utf8_of_variable_length_in_attributes_too(self):
        _, path = self.exported("v1-mpc")
        with h5py.File(path) as file:
            def look(_, node):
                for name in node.attrs:
                    kind = node.attrs.get_id(name).dtype
                    if name in ("CLASS", "NAME"):  # of dimension scales, whose library writes them
                        continue
                    if text := h5py.check_string_dtype(kind):
                        self.assertEqual((text.encoding, text.length), ("utf-8", None), f"{node.name} {name}")
            file.visititems(look)
            look("", file)

    def test_xarray_opens_every_table_with_named_axes_by_both_of_its_readers(self):
        for name in RUNS:
            run, path = self.exported(name)
            started = np.datetime64(json.loads((run / "provenance.json").read_text())["started_utc"].rstrip("Z"))
            logged = messages(run)
            with h5py.File(path) as file:
                tables = []
                file.visititems(lambda at, node: tables.append(at) if isinstance(node, h5py.Group) and any(
                    isinstance(node[k], h5py.Dataset) and node[k].ndim for k in node) else None)
            self.assertIn("maps/HEIGHT_MAP", tables)
            for engine in ("h5netcdf", "netcdf4"):
                for table in tables:
                    with xarray.open_dataset(path, group=table, engine=engine) as data:
                        self.assertNotIn("phony", " ".join(map(str, data.sizes)), table)
                        rows = "time" if "log_event" in data else "row"
                        for column in data.variables.values():
                            self.assertTrue(column.dims[0] == rows or column.dims[0].endswith("_value")
                                            or column.dims[0].startswith("grid_"), f"{table} {column.dims}")
                with xarray.open_dataset(path, group="maps/HEIGHT_MAP", engine=engine) as data:
                    self.assertEqual(data.height_mm.dims, ("time", "grid_y_mm", "grid_x_mm"))
                    self.assertIn("layer", data.height_mm.coords)
                    for k, event in enumerate(logged["HEIGHT_MAP"]):
                        message, grid = event["message"], event["message"]["grid"]
                        self.assertEqual(data.time.values[k], started + np.timedelta64(event["utime_us"], "us"))
                        self.assertEqual(int(data.layer[k]), message["layer"])
                        j, i = grid["ny"] - 1, grid["nx"] // 2
                        cell = data.height_mm.isel(time=k).sel(grid_x_mm=grid["origin_x_mm"] + i * grid["pitch_x_mm"],
                                                               grid_y_mm=grid["origin_y_mm"] + j * grid["pitch_y_mm"],
                                                               method="nearest")
                        expected = message["height_mm"][j * grid["nx"] + i]
                        self.assertTrue(same(expected, np.float32(cell)), f"{expected} {float(cell)}")

    def test_the_count_of_a_list_names_its_dimension_as_cf_wants_it(self):
        _, path = self.exported("v5-ice")
        seen = 0
        with h5py.File(path) as file:
            def look(at, node):
                nonlocal seen
                if at.endswith("_count") and "sample_dimension" in node.attrs:
                    scale = node.parent[node.attrs["sample_dimension"]]
                    values = node.parent[at.split("/")[-1][:-len("_count")]]
                    self.assertTrue(h5py.h5ds.is_scale(scale.id))
                    self.assertEqual((len(scale), len(values)), (int(node[()].sum()),) * 2)
                    self.assertTrue(h5py.h5ds.is_attached(values.id, scale.id, 0))
                    seen += 1
            file.visititems(look)
        self.assertGreater(seen, 5)

    def test_a_nexus_viewer_finds_the_maps_over_layer_y_and_x_and_when_the_print_was(self):
        for name in RUNS:
            run, path = self.exported(name)
            with h5py.File(path) as file:
                self.assertEqual(file.attrs["NX_class"], "NXroot")
                self.assertEqual(f'firn {file.attrs["creator_version"]}', firn("--version").stdout.split(" (")[0])
                entry = file[file.attrs["default"]]
                self.assertEqual(entry.attrs["NX_class"], "NXentry")
                provenance = json.loads((run / "provenance.json").read_text())
                self.assertEqual(entry["title"][()].decode(), provenance["name"])
                self.assertEqual(entry["start_time"][()].decode(), provenance["started_utc"])
                self.assertGreaterEqual(entry["end_time"][()], entry["start_time"][()])
                data = entry[entry.attrs["default"]]
                self.assertEqual(data.attrs["NX_class"], "NXdata")
                signal, axes = data[data.attrs["signal"]], [data[a] for a in data.attrs["axes"]]
                self.assertEqual(data.attrs["signal"], "height_mm")
                self.assertEqual([a.name.split("/")[-1] for a in axes], ["layer", "grid_y_mm", "grid_x_mm"])
                self.assertEqual(signal.shape, tuple(len(a) for a in axes))

    def test_foxglove_draws_the_maps_and_lists_the_events(self):
        numpy_type = {1: "<u1", 2: "<i1", 4: "<i2", 6: "<i4", 7: "<f4", 8: "<f8"}
        for name in RUNS:
            run = ROOT / "tests/replay/golden" / name
            firn("export", run, "-o", self.folder / f"{name}.mcap")
            file = Mcap((self.folder / f"{name}.mcap").read_bytes())
            logged = {e["event"]: e for events in messages(run).values() for e in events}
            grids, lines = set(), set()
            for topic, _, schema, number, time_ns, data in file.messages:
                if not topic.startswith("/foxglove/"):
                    continue
                said, event = json.loads(data), logged[number]
                self.assertEqual((said["timestamp"]["sec"] * 10**9 + said["timestamp"]["nsec"], time_ns),
                                 (1000 * event["utime_us"],) * 2)
                if topic == "/foxglove/LOG":
                    self.assertEqual(file.schemas[schema][0], "foxglove.Log")
                    lines.add(number)
                    continue
                self.assertEqual(file.schemas[schema][0], "foxglove.Grid")
                grids.add(number)
                message, grid = event["message"], event["message"]["grid"]
                cells = np.frombuffer(base64.b64decode(said["data"]), np.dtype(
                    {"names": [f["name"] for f in said["fields"]], "formats": [numpy_type[f["type"]] for f in said["fields"]],
                     "offsets": [f["offset"] for f in said["fields"]], "itemsize": said["cell_stride"]}))
                self.assertEqual((said["column_count"], len(cells)), (grid["nx"], grid["nx"] * grid["ny"]))
                self.assertEqual(said["row_stride"], said["cell_stride"] * grid["nx"])
                for field in said["fields"]:
                    for expected, v in zip(message[field["name"]], cells[field["name"]]):
                        self.assertTrue(same(expected, v), f"{topic} {field}: {expected} {v}")
                # of a cell's four corners the pose is the lowest
                self.assertAlmostEqual(said["pose"]["position"]["x"] + said["cell_size"]["x"] / 2, grid["origin_x_mm"], 12)
                self.assertAlmostEqual(said["pose"]["position"]["y"] + said["cell_size"]["y"] / 2, grid["origin_y_mm"], 12)
            self.assertGreaterEqual(grids, {n for n, e in logged.items() if e["type"] == "height_map_t"})
            self.assertGreaterEqual(lines, {n for n, e in logged.items() if e["type"] in ("fault_t", "run_end_t")})

    def test_several_runs_are_groups_of_one_file_and_the_same_bytes_each_time(self):
        runs = [ROOT / "tests/replay/golden" / name for name in RUNS]
        said = json.loads(firn("export", *runs, "-o", self.folder / "all.h5", "--json").stdout)
        self.assertEqual(len(said["runs"]), len(RUNS))
        with h5py.File(self.folder / "all.h5") as file:
            self.assertEqual(sorted(file), sorted(RUNS))
            self.assertEqual({file[name].attrs["NX_class"] for name in RUNS}, {"NXentry"})
            self.assertEqual(file.attrs["default"], RUNS[0])
            self.assertEqual(file[f"{RUNS[2]}/plot"].attrs["signal"], "height_mm")
            self.assertIn("LAYER_METRICS", file["v5-ice/metrics"])
        for ending in ("h5", "npz", "mcap"):
            for name in ("a", "b"):
                firn("export", runs[0], "-o", self.folder / f"{name}.{ending}")
            self.assertEqual((self.folder / f"a.{ending}").read_bytes(), (self.folder / f"b.{ending}").read_bytes())
        with zipfile.ZipFile(self.folder / "a.npz") as file:
            self.assertIsNone(file.testzip())
            self.assertEqual({entry.date_time for entry in file.infolist()}, {(1980, 1, 1, 0, 0, 0)})
        self.assertIn("v1-mpc", firn("export", runs[0], runs[0], "-o", self.folder / "x.h5", code=2).stderr)

    def test_a_packed_run_gives_the_same_file(self):
        run = self.folder / "runs" / "v1-mpc"
        shutil.copytree(ROOT / "tests/replay/golden/v1-mpc", run)
        firn("export", run, "-o", self.folder / "plain.h5")
        firn("runs", "pack", run)
        firn("export", run, "-o", self.folder / "packed.h5")
        self.assertEqual((self.folder / "plain.h5").read_bytes(), (self.folder / "packed.h5").read_bytes())

    def test_damaged_empty_and_truncated_runs_are_named_and_leave_nothing(self):
        run = self.folder / "run"
        shutil.copytree(ROOT / "tests/replay/golden/v1-mpc", run)
        log = (run / "log.lcm").read_bytes()

        def refused(*parts, code, output="x.h5"):
            for ending in (".h5", ".npz", ".mcap", ".csv"):
                out = self.folder / "out" / Path(output).with_suffix(ending)
                out.parent.mkdir(exist_ok=True)
                said = firn("export", run, "-o", out, code=code).stderr
                for part in parts:
                    self.assertIn(part, said)
                self.assertEqual(list(out.parent.iterdir()), [])
        flipped = bytearray(log)
        flipped[len(log) // 2] ^= 4
        (run / "log.lcm").write_bytes(flipped)
        refused("log.lcm: byte ", code=1)
        (run / "log.lcm").write_bytes(log[:len(log) // 3])
        refused("log.lcm: byte ", code=1)
        (run / "log.lcm").write_bytes(b"")
        refused("log.lcm", code=1)
        (run / "log.lcm").unlink()
        refused("log.lcm: is missing", "firn log repair", code=2)
        (run / "provenance.json").unlink()
        refused("is no run folder", "provenance.json", code=2)
        self.assertIn("no format with this ending",
                      firn("export", ROOT / "tests/replay/golden/v1-mpc", "-o", self.folder / "x.mat", code=2).stderr)


if __name__ == "__main__":
    FIRN, ROOT = sys.argv.pop(1), Path(sys.argv.pop(1))
    unittest.main()
