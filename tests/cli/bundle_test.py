#!/usr/bin/env python3
"""firn bundle and firn repro as a user meets them; the bundle is read with Python's zipfile and json alone.

    tests/cli/bundle_test.py FIRN ROOT [Case.test]
"""
import hashlib
import json
import shutil
import stat
import subprocess
import sys
import tempfile
import unittest
import zipfile
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

FIRN = ROOT = None


def firn(*words, code=0):
    done = subprocess.run([FIRN, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done.stdout if code == 0 else done.stdout + done.stderr


class Bundle(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.place = Path(cls.folder.name)
        cls.first = cls.print("--meta", "sample=PCB-7")
        cls.second = cls.print("--meta", "sample=PCB-8", "--set", "plant.seed=2")
        firn("runs", "note", cls.first, "the rim <falls>", "--author", "Ada")
        firn("runs", "tag", cls.first, "good")
        firn("runs", "seal", cls.first)
        cls.eln = cls.place / "two prints.eln"
        firn("bundle", cls.first, cls.second, "-o", cls.eln, "--license", "CC-BY-4.0")

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    @classmethod
    def print(cls, *words):
        return Path(json.loads(firn("print", ROOT / "experiments/labelled.toml", "--bus", "in-process", "--runs", cls.place / "runs", "--json",
                                    "--meta", "operator=Kim", *words))["run"])

    def graph(self):
        with zipfile.ZipFile(self.eln) as archive:
            crate = json.loads(archive.read("two prints/ro-crate-metadata.json"))
        self.assertEqual(crate["@context"], "https://w3id.org/ro/crate/1.1/context")
        return {entity["@id"]: entity for entity in crate["@graph"]}, crate["@graph"]

    def test_the_metadata_follows_the_rules_of_ro_crate_and_of_the_eln_format(self):
        by_id, graph = self.graph()
        self.assertEqual(len(by_id), len(graph), "each @id once")
        about = by_id["ro-crate-metadata.json"]
        self.assertEqual((about["@type"], about["about"], about["conformsTo"]),
                         ("CreativeWork", {"@id": "./"}, {"@id": "https://w3id.org/ro/crate/1.1"}))
        root = by_id["./"]
        self.assertEqual(root["@type"], "Dataset")
        for key in ("name", "description", "datePublished", "license", "hasPart"):
            self.assertIn(key, root)
        self.assertEqual(root["license"], "CC-BY-4.0")
        # Flattened: an object in an entity is a reference, and leads to an entity or to the context.
        for entity in graph:
            for key, value in entity.items():
                for one in value if isinstance(value, list) else [value]:
                    self.assertFalse(isinstance(one, list), key)
                    if isinstance(one, dict):
                        self.assertEqual(list(one), ["@id"], key)
                        self.assertTrue(one["@id"] in by_id or key == "conformsTo", one)
        with zipfile.ZipFile(self.eln) as archive:
            self.assertIsNone(archive.testzip())
            names = [n for n in archive.namelist() if not n.endswith("/")]
            self.assertEqual({PurePosixPath(n).parts[0] for n in names}, {"two prints"})
            files = {e["@id"]: e for e in graph if e["@type"] == "File"}
            reached = {part["@id"] for run in root["hasPart"] for part in by_id[run["@id"]]["hasPart"]}
            self.assertEqual(reached, set(files))
            inside = {unquote(i)[2:] for i in files}
            self.assertEqual(inside | {"ro-crate-metadata.json"}, {n.split("/", 1)[1] for n in names})
            for i, entity in files.items():
                data = archive.read("two prints/" + unquote(i)[2:])
                self.assertEqual((entity["contentSize"], entity["sha256"]), (str(len(data)), hashlib.sha256(data).hexdigest()), i)
                self.assertIn("/", entity["encodingFormat"])
                self.assertEqual(entity["name"], PurePosixPath(unquote(i)).name)

    def test_a_notebook_finds_who_printed_what_by_which_program(self):
        by_id, graph = self.graph()
        run = by_id[f"./{self.first.name}/"]
        self.assertEqual(by_id[run["author"]["@id"]]["name"], "Kim")
        self.assertEqual(run["keywords"], "good")
        comment = by_id[run["comment"][0]["@id"]]
        self.assertEqual((comment["text"], by_id[comment["author"]["@id"]]["name"]), ("the rim <falls>", "Ada"))
        values = {by_id[v["@id"]]["propertyID"]: by_id[v["@id"]]["value"] for v in run["variableMeasured"]}
        self.assertEqual((values["meta.sample"], values["scheme"], values["outcome"]), ("PCB-7", "smf", "finished"))
        self.assertGreater(values["rms_um"], 0)
        action = next(e for e in graph if e["@type"] == "CreateAction" and e["result"]["@id"] == run["@id"])
        program = by_id[action["instrument"]["@id"]]
        provenance = json.loads((self.first / "provenance.json").read_text())
        self.assertEqual((program["@type"], program["identifier"]), ("SoftwareApplication", provenance["commit"]))
        about = {by_id[v["@id"]]["propertyID"]: by_id[v["@id"]]["value"] for v in program["additionalProperty"]}
        self.assertEqual((about["sources"], json.loads(about["results"])), (provenance["sources"], provenance["results"]))

    def test_a_bundle_is_checked_replayed_and_printed_again_to_the_same_bytes(self):
        keep = self.place / "kept"
        said = json.loads(firn("repro", self.eln, "--json", "--keep", keep))
        self.assertTrue(said["good"])
        for run in said["runs"]:
            self.assertEqual(run["replay"], "identical")
            self.assertRegex(run["print"], r"^same bytes, [0-9]{2,} messages$")
            self.assertRegex(run["seal"], r"^sealed: [23] seals")
        self.assertTrue((keep / "again" / self.first.name / "log.lcm").is_file())
        self.assertIn("an empty folder is wanted", firn("repro", self.eln, "--keep", keep, code=2))

    def test_a_run_that_is_not_as_it_was_sealed_is_not_bundled(self):
        run = self.place / "forged"
        shutil.copytree(self.second, run)
        text = (run / "experiment.toml").read_text()
        self.assertIn("seed = 2", text)
        (run / "experiment.toml").write_text(text.replace("seed = 2", "seed = 3", 1))
        self.assertIn("is not as it was sealed: experiment.toml", firn("bundle", run, "-o", self.place / "forged.eln", code=2))
        self.assertFalse((self.place / "forged.eln").exists())

    def repacked(self, name, change):
        """The bundle with its members changed: a list of (ZipInfo or name, bytes)."""
        with zipfile.ZipFile(self.eln) as archive:
            members = [(n, archive.read(n)) for n in archive.namelist()]
        file = self.place / name
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for member, data in change(members):
                archive.writestr(member, data)
        return file

    def refused(self, name, change, words):
        before = sorted(self.place.iterdir())
        file = self.repacked(name, change)
        said = firn("repro", file, code=2)
        self.assertIn(words, said)
        file.unlink()
        self.assertEqual(sorted(self.place.iterdir()), before)

    def test_an_unchanged_bundle_of_another_program_is_read(self):
        self.assertIn("identical", firn("repro", self.repacked("again.eln", lambda m: m), "--no-print"))

    def test_a_bundle_that_would_do_harm_is_refused_by_name(self):
        link = zipfile.ZipInfo("two prints/link")
        link.create_system = 3
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        self.refused("link.eln", lambda m: m + [(link, "/etc/passwd")], "two prints/link: is a link or a device")
        for path, why in (("two prints/../../x", "leads out of the folder: it has the part .."), ("/etc/x", "absolute path"),
                          ("C:/x", "absolute path"), ("two prints\\x", "backslash"), ("two prints//x", "empty part"), ("other/x", "a second one beside two prints"),
                          ("x", "stands beside the one folder")):
            info = zipfile.ZipInfo("n")
            info.filename = path
            self.refused("path.eln", lambda m: m + [(info, "x")], why)
        self.refused("bomb.eln", lambda m: m[:1] + [("two prints/bomb", b"\0" * (100 << 20))], "two prints/bomb: the archive unpacks to more than")
        self.refused("extra.eln", lambda m: m + [("two prints/extra", "x")], "extra: is not in the metadata")
        self.refused("less.eln", lambda m: [x for x in m if not x[0].endswith("result.json")], "result.json: is in the metadata and not in the archive")
        self.refused("other.eln", lambda m: [(n, d.replace(b"finished", b"finisHed") if n.endswith("result.json") else d) for n, d in m],
                     "result.json: is not what the metadata says: another SHA-256")
        self.refused("none.eln", lambda m: [x for x in m if not x[0].endswith("ro-crate-metadata.json")], "it is no bundle")
        self.refused("json.eln", lambda m: [(n, b"[]" if n.endswith("ro-crate-metadata.json") else d) for n, d in m], "is no RO-Crate metadata")

    def test_a_cut_or_foreign_file_is_refused(self):
        file = self.place / "cut.eln"
        file.write_bytes(self.eln.read_bytes()[:-1000])
        self.assertIn("is no ZIP archive, as a bundle is, or is damaged", firn("repro", file, code=2))
        file.write_text("text")
        self.assertIn("is no ZIP archive", firn("repro", file, code=2))
        self.assertIn("no such file", firn("repro", self.place / "none.eln", code=2))
        self.assertIn("name ends in .eln", firn("bundle", self.first, "-o", self.place / "x.tar", code=2))
        self.assertIn("two runs have the name", firn("bundle", self.first, self.first, "-o", self.place / "x.eln", code=2))

    def test_damage_anywhere_is_found_or_is_where_nothing_is_read(self):
        whole = self.eln.read_bytes()
        random = __import__("random").Random(57)
        found = 0
        for _ in range(25):
            data = bytearray(whole)
            for _ in range(3):
                data[random.randrange(len(data))] ^= 1 << random.randrange(8)
            file = self.place / "damaged.eln"
            file.write_bytes(data)
            done = subprocess.run([FIRN, "repro", file, "--no-print"], capture_output=True, text=True)
            self.assertIn(done.returncode, (0, 1, 2), done.stderr)
            found += done.returncode != 0
            if done.returncode == 0:  # bytes of the archive itself that no reader takes, as dates
                self.assertEqual(done.stdout.count("identical"), 2)
        self.assertGreater(found, 20)

    def test_python_code_of_a_bundle_runs_with_trust_alone(self):
        run = Path(json.loads(firn("print", ROOT / "experiments/cuboid.toml", "--bus", "in-process", "--runs", self.place / "python", "--json",
                                   "--set", f"control.scheme=python:{ROOT}/experiments/python/level.py:Level", "--set", "part.height_mm=0.02",
                                   "--set", "part.width_mm=2", "--set", "part.depth_mm=2"))["run"])
        file = self.place / "python.eln"
        firn("bundle", run, "-o", file)
        said = json.loads(firn("repro", file, "--json", code=0))["runs"][0]
        self.assertIn("which --trust runs", said["print"])
        trusted = json.loads(firn("repro", file, "--json", "--trust"))["runs"][0]
        self.assertEqual(trusted["replay"], "identical")
        self.assertRegex(trusted["print"], "^same bytes")


if __name__ == "__main__":
    FIRN, ROOT = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
