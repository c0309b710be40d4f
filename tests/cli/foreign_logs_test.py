#!/usr/bin/env python3
"""`firn log info` and `firn log cat --types` on logs of others, against lcm-gen: random types, nested and recursive, are
generated as Python by lcm-gen, whose fingerprints and encoded messages firn must read.

    tests/cli/foreign_logs_test.py FIRN [Case.test]
"""
import importlib
import json
import random
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN = None

NUMBERS = {"int8_t": (-128, 127), "int16_t": (-2 ** 15, 2 ** 15 - 1), "int32_t": (-2 ** 31, 2 ** 31 - 1),
           "int64_t": (-2 ** 63, 2 ** 63 - 1), "byte": (0, 255), "boolean": (0, 1)}
PLAIN = list(NUMBERS) + ["float", "double", "string"]


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    if code is not None and done.returncode != code:
        raise AssertionError(f"firn {words}: exit {done.returncode}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done


def event(number, utime_us, channel, data):
    name = channel.encode()
    return struct.pack(">IqqII", 0xEDA1DA01, number, utime_us, len(name), len(data)) + name + data


def lines(*words, code=0):
    return [json.loads(line) for line in firn("log", "cat", *words, code=code).stdout.splitlines()]


CONSTANTS = {"ROWS": "2", "COLS": "0x3", "ONE": "1"}


def random_types(rng, package):
    """Structs of numbered names; a later one may hold earlier ones, or a counted array of any. Returns also the text
    in which each constant that is an array's size is its value: what lcm-gen hashes, and what lcm-gen before 1.5
    needs."""
    names = [f"t{i}_t" for i in range(rng.randint(2, 6))]
    structs = {}
    for i, name in enumerate(names):
        members = [("int32_t", "n", []), ("int8_t", "m", [])]
        for k in range(rng.randint(1, 5)):
            dims = [rng.choice(["n", "m", "2", "0x3", "1", *CONSTANTS]) for _ in range(rng.choice([0, 0, 1, 2, 3]))]
            kind = rng.choice(PLAIN + ["mode_t"])
            if rng.random() < 0.4:
                kind = rng.choice(names[:i] if i and rng.random() < 0.6 else names)
                if names.index(kind) >= i and not {"n", "m"} & set(dims):
                    dims = ["n"]
            members.append((kind, f"v{k}", dims))
        structs[name] = members
    constants = ", ".join(f"{name} = {value}" for name, value in CONSTANTS.items())
    text = f"// types of a test\npackage {package};\nenum mode_t {{ kOff = 0, kOn, kSafe = 0x10 }}\n"
    for name, members in structs.items():
        text += f"struct {name} {{ const int32_t LIMIT = -3, {constants}; const double SCALE = -1.5e3;\n"
        for kind, member, dims in members:
            full = kind if kind in PLAIN or rng.random() < 0.5 else f"{package}.{kind}"
            text += f"  {full} {member}{''.join(f'[{d}]' for d in dims)}; /* a comment */\n"
        text += "}\n"
    plain = text
    for name, value in CONSTANTS.items():
        plain = plain.replace(f"[{name}]", f"[{value}]")
    return structs, text, plain


def random_value(rng, kind, module, structs, depth):
    if kind in structs:
        return random_message(rng, kind, module, structs, depth + 1)
    if kind == "mode_t":
        return module.mode_t(rng.choice([0, 1, 16]))
    if kind == "string":
        return "".join(rng.choice("abc \"\\é") for _ in range(rng.randint(0, 5)))
    if kind in ("float", "double"):
        return struct.unpack(">f", struct.pack(">f", rng.uniform(-1e3, 1e3)))[0]
    if kind == "boolean":
        return rng.random() < 0.5
    return rng.randint(*NUMBERS[kind])


def random_message(rng, name, module, structs, depth=0):
    message = getattr(module, name)()
    counts = {name: int(value, 0) for name, value in CONSTANTS.items()}
    counts |= {"n": rng.randint(0, 2 if depth < 2 else 0), "m": rng.randint(0, 2 if depth < 2 else 0)}
    for kind, member, dims in structs[name]:
        if member in counts and not dims:
            setattr(message, member, counts[member])
            continue

        def fill(sizes):
            if not sizes:
                return random_value(rng, kind, module, structs, depth)
            values = [fill(sizes[1:]) for _ in range(sizes[0])]
            return bytes(values) if kind == "byte" and len(sizes) == 1 else values
        setattr(message, member, fill([counts.get(d) if d in counts else int(d, 0) for d in dims]))
    return message


def flat(value):
    return [x for v in value for x in flat(v)] if isinstance(value, (list, tuple, bytes)) else [value]


def same(test, name, structs, message, found, path):
    for kind, member, dims in structs[name]:
        expected, value = getattr(message, member), found[member]
        for i, (e, v) in enumerate(zip(flat(expected) if dims else [expected], value if dims else [value], strict=True)):
            where = f"{path}.{member}[{i}]"
            if kind in structs:
                same(test, kind, structs, e, v, where)
            elif kind == "mode_t":
                test.assertEqual(e.value, v, where)
            elif kind == "float":
                test.assertEqual(struct.pack(">f", e), struct.pack(">f", v), where)
            else:
                test.assertEqual(e, v, where)


class ForeignLogs(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = Path(self.scratch.name)
        self.types = self.folder / "types"
        self.types.mkdir()

    def tearDown(self):
        self.scratch.cleanup()

    def write(self, name, *events):
        (self.folder / name).write_bytes(b"".join(events))
        return self.folder / name

    def info(self, file, *more, code=0):
        return json.loads(firn("log", "info", file, "--json", *more, code=code).stdout)

    def test_messages_of_any_type_decode_as_lcm_gen_encoded_them(self):
        for seed in range(25):
            rng = random.Random(seed)
            package = f"p{seed}"
            structs, text, plain = random_types(rng, package)
            folder = self.types / package
            folder.mkdir()
            (folder / "types.lcm").write_text(text)
            python = self.folder / "python"
            (self.folder / "plain.lcm").write_text(plain)
            subprocess.run(["lcm-gen", "--python", "--ppath", python, self.folder / "plain.lcm"], check=True)
            sys.path.insert(0, str(python))
            module = importlib.import_module(package)
            module.mode_t.__init__.__defaults__ = (0,)  # lcm-gen 1.3 makes members of an enum without a value
            events, messages = [], []
            for k in range(12):
                name = rng.choice(list(structs))
                messages.append((name, random_message(rng, name, module, structs)))
                events.append(event(k, 1000 * k, f"CH_{name}", messages[-1][1].encode()))
            log = self.write(f"{package}.lcm", *events)
            found = lines(log, "--types", folder, "--full")
            self.assertEqual(len(found), len(messages))
            for k, ((name, message), line) in enumerate(zip(messages, found)):
                with self.subTest(seed=seed, event=k, name=name):
                    names = [line["type"]] + line.get("same_fingerprint", [])
                    self.assertIn(f"{package}.{name}", names)
                    if line["type"] == f"{package}.{name}":
                        same(self, name, structs, message, line["message"], name)
            sys.path.pop(0)

    def test_types_with_one_fingerprint_are_both_named(self):
        (self.types / "a.lcm").write_text("package a; struct point_t { double x, y; }")
        (self.types / "b.lcm").write_text("package b; struct vector_t { double x, y; }")
        self.assertEqual(self.point_names(), ["a.point_t", "b.vector_t"])
        (self.types / "copy.lcm").write_text("package a; struct point_t { double x, y; }")
        self.assertEqual(self.point_names(), ["a.point_t", "b.vector_t"])

    def point_names(self):
        log = self.write("points.lcm", event(0, 0, "PLACE", struct.pack(">Qdd", self.point_fingerprint(), 1, 2)))
        row = self.info(log, "--types", self.types)["channels"]["PLACE"]["types"][0]
        line = lines(log, "--types", self.types)[0]
        self.assertEqual(line["message"], {"x": 1, "y": 2})
        self.assertEqual([line["type"]] + line["same_fingerprint"], row["types"])
        return row["types"]

    def point_fingerprint(self):
        said = subprocess.run(["lcm-gen", "--debug", self.types / "a.lcm"], capture_output=True, text=True).stdout
        number = int(said.split("hash=0x")[1].split("]")[0], 0) & (2 ** 64 - 1)
        return ((number << 1) | (number >> 63)) & (2 ** 64 - 1)

    def test_an_unknown_type_is_named_with_the_nearest_by_name(self):
        (self.types / "a.lcm").write_text("package a; struct pose_t { double x, y; } struct image_t { int8_t v; }")
        log = self.write("x.lcm", event(0, 0, "POSE", struct.pack(">Qdd", 77, 1, 2)),
                         event(1, 1, "POSE_BODY", struct.pack(">Qd", 78, 1)))
        channels = self.info(log, "--types", self.types)["channels"]
        self.assertEqual(channels["POSE"]["types"][0] | {}, {"messages": 1, "fingerprint": f"{77:016x}", "types": [],
                                                             "nearest": "a.pose_t", "fits": True})
        self.assertEqual(channels["POSE_BODY"]["types"][0]["nearest"], "a.pose_t")
        self.assertFalse(channels["POSE_BODY"]["types"][0]["fits"])
        text = firn("log", "info", log, "--types", self.types).stdout
        self.assertIn("the nearest by name is a.pose_t, whose members take as many bytes", text)
        self.assertEqual(lines(log, "--types", self.types)[0]["nearest"], "a.pose_t")

    def test_other_payloads_are_said_to_be_none_of_lcm(self):
        log = self.write("x.lcm", event(0, 0, "LCM_SELF_TEST", b"lcm self test"), event(1, 1, "SHORT", b"abc"),
                         event(2, 2, "NMEA", b"$GPGGA,1,2,3*47\r\n"), event(3, 3, "EMPTY", b""))
        channels = self.info(log)["channels"]
        self.assertEqual(channels["LCM_SELF_TEST"]["types"][0]["not_lcm"], "LCM's self test")
        self.assertEqual(channels["SHORT"]["types"][0]["not_lcm"], "3 bytes, no fingerprint")
        self.assertEqual(channels["NMEA"]["types"][0]["not_lcm"], "text")
        self.assertEqual(channels["EMPTY"]["types"][0]["not_lcm"], "0 bytes, no fingerprint")
        self.assertEqual([line["text"] for line in lines(log)], ["lcm self test", "abc", "$GPGGA,1,2,3*47\r\n", ""])

    def test_a_log_of_java_whose_numbers_are_all_zero_is_read_whole(self):
        events = [event(0, 1000 * i, "ABC"[i % 3], bytes([i % 256]) * 20) for i in range(300)]
        log = self.write("java.lcm", *events)
        found = self.info(log)
        self.assertEqual((found["events"], found["numbered"], found["damage_count"]), (300, False, 0))
        self.assertEqual(len(lines(log)), 300)
        broken = self.write("broken.lcm", *events[:100], events[100][:30], *events[101:])
        found = self.info(broken, code=1)
        self.assertEqual((found["events"], found["damage_count"]), (299, 1))

    def test_rates_gaps_and_steps_back_in_time_are_found(self):
        times = [1000 * i for i in range(100)] + [200_000 + 1000 * i for i in range(100)] + [250_000]
        log = self.write("x.lcm", *(event(i, t, "A", bytes(8)) for i, t in enumerate(times)))
        c = self.info(log)["channels"]["A"]
        self.assertEqual((c["messages"], c["gaps"], c["longest_interval_s"], c["longest_begins_s"]),
                         (201, 1, 0.101, 0.099))
        self.assertAlmostEqual(c["median_interval_s"], 0.001, delta=0.00006)
        self.assertAlmostEqual(c["rate_hz"], 200 / 0.299, delta=0.01)
        self.assertEqual((c["time_order"]["back"], c["time_order"]["largest_s"], c["time_order"]["event"]),
                         (1, 0.049, 200))

    def test_logs_joined_by_cat_are_counted_and_read_whole(self):
        joined = b""
        for k in range(40):
            part = b"".join(event(i, 10 ** 15 + 10 ** 7 * k + i, "A", struct.pack(">QI", k, i)) for i in range(25))
            joined += part[:-9] if k % 5 == 4 else part  # a logger that was killed
        log = self.write("joined.lcm", joined)
        found = self.info(log, code=1)
        self.assertEqual((found["events"], found["logs"], found["damage_count"]), (40 * 25 - 8, 40, 8))
        self.assertEqual(len(lines(log, code=1)), 40 * 25 - 8)

    def test_type_files_that_cannot_be_read_are_named_and_the_others_used(self):
        (self.types / "a.lcm").write_text("package a; struct point_t { double x, y; }")
        (self.types / "b.lcm").write_text("package a;\nstruct point_t { double z; }\nstruct odd_t { what_t w; }\n"
                                          "struct holds_t { int32_t n; odd_t odd[n]; }\nstruct broken {")
        log = self.write("x.lcm", event(0, 0, "A", struct.pack(">Qdd", self.point_fingerprint(), 1, 2)))
        found = self.info(log, "--types", self.types)
        text = "\n".join(found["problems"])
        for part in ("b.lcm:2: a.point_t differs from the one of ", "unknown type 'what_t'",
                     "b.lcm:4: ", "b.lcm: line 5: "):
            self.assertIn(part, text)
        self.assertEqual(found["channels"]["A"]["types"][0]["types"], ["a.point_t"])
        for folder in (self.types / "none", self.folder / "empty"):
            if folder.name == "empty":
                folder.mkdir()
            self.assertIn(str(folder), firn("log", "cat", log, "--types", folder, code=2).stderr)

    def test_a_message_nested_without_end_is_refused(self):
        (self.types / "a.lcm").write_text("package a; struct node_t { int32_t n; node_t children[n]; }")
        subprocess.run(["lcm-gen", "--python", "--ppath", self.folder, self.types / "a.lcm"], check=True)
        hashed = subprocess.run([sys.executable, "-c", "import a; print(a.node_t._get_hash_recursive([]))"],
                                cwd=self.folder, capture_output=True, text=True, check=True).stdout
        data = struct.pack(">Q", int(hashed))
        deep, fit = data + struct.pack(">I", 1) * 100_000, data + struct.pack(">I", 1) * 400 + bytes(4)
        log = self.write("x.lcm", event(0, 0, "A", deep), event(1, 1, "A", fit))
        first, second = (line["message"] for line in lines(log, "--types", self.types))
        self.assertIn("nested in itself more than 500 deep", first["_error"])
        depth = 0
        while second["children"]:
            second, depth = second["children"][0], depth + 1
        self.assertEqual(depth, 400)

    def test_files_that_are_no_logs_are_named(self):
        self.assertIn("no LCM event in its 4000 bytes",
                      firn("log", "info", self.write("x.lcm", b"abcd" * 1000), code=2).stderr)
        self.assertIn("a record file", firn("log", "info", self.write("y.wal", b"FIRNREC1" + struct.pack("<II", 1, 0)),
                                            code=2).stderr)
        self.assertEqual(self.info(self.write("z.lcm"))["events"], 0)


if __name__ == "__main__":
    sys.setrecursionlimit(5000)
    FIRN = sys.argv.pop(1)
    unittest.main()
