#!/usr/bin/env python3
"""The user's own configuration and FIRN_RUNS, and codes that commands end with: tests/cli/user_config_test.py FIRN ROOT"""
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path

FIRN, ROOT = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
SMALL = [ROOT / "experiments/cuboid.toml", "--bus", "in-process", "--set", "part.height_mm=0.02"]
CODE = re.compile(r"^\|(\d+)\|(.*)\|$", re.M)


class Case(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.place = Path(scratch.name)
        self.environment = {k: v for k, v in os.environ.items() if k not in ("FIRN_RUNS", "XDG_CONFIG_HOME")} | {"HOME": str(self.place)}

    def say(self, *words, **variables):
        return subprocess.run([str(w) for w in (FIRN, *words)], cwd=self.place, env=self.environment | variables,
                              stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=300, check=False)

    def user(self, **variables):
        done = self.say("config", "user", "--json", **variables)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(done.stdout)

    def write(self, text, folder=".config"):
        file = self.place / folder / "firn" / "config.toml"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        return file


class UserConfiguration(Case):
    def test_the_command_line_wins_over_the_variable_the_variable_over_the_file_the_file_over_the_rest(self):
        told = self.user()
        self.assertEqual((told["runs"], told["runs_named_by"], told["name"]), ("runs", "built in", ""))
        file = self.write('[user]\nruns = "~/mine"\nname = "Ada"\n')
        told = self.user()
        self.assertEqual((told["runs"], told["runs_named_by"], told["name"]), (f"{self.place}/mine", str(file), "Ada"))
        told = self.user(FIRN_RUNS="/elsewhere")
        self.assertEqual((told["runs"], told["runs_named_by"]), ("/elsewhere", "FIRN_RUNS"))

        for name, words, variables in (("mine", [], {}), ("env", [], {"FIRN_RUNS": "env"}),
                                       ("given", ["--runs", "given"], {"FIRN_RUNS": "env"})):
            done = self.say("print", *SMALL, *words, **variables)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(len(list((self.place / name).iterdir())), 1, name)
        for name, variables in (("mine", {}), ("env", {"FIRN_RUNS": "env"})):
            listed = json.loads(self.say("runs", "--json", **variables).stdout)
            self.assertEqual([Path(run["run"]).parent.name for run in listed], [name])
        self.assertFalse((self.place / "runs").exists())

    def test_the_page_is_there_before_the_first_print_and_a_folder_that_is_named_must_be(self):
        page = subprocess.Popen([FIRN, "view", "--json"], cwd=self.place, env=self.environment | {"FIRN_RUNS": str(self.place / "a/b")},
                                stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True)
        self.addCleanup(page.stdout.close)
        self.addCleanup(page.wait)
        self.addCleanup(page.kill)
        self.assertIn("http://", page.stdout.readline())
        self.assertEqual(list((self.place / "a/b").iterdir()), [])
        done = self.say("view", self.place / "none")
        self.assertEqual((done.returncode, "none: no such folder" in done.stderr), (2, True), done.stderr)

    def test_the_user_s_name_is_the_operator_of_prints_that_name_none_and_the_author_of_notes(self):
        self.write('[user]\nname = "Ada Lovelace"\n')
        labelled = [ROOT / "experiments/labelled.toml", "--bus", "in-process", "--json"]
        for words, operator in (([], "Ada Lovelace"), (["--meta", "operator=Kim"], "Kim")):
            done = self.say("print", *labelled, *words)
            self.assertEqual(done.returncode, 0, done.stderr)
            run = Path(json.loads(done.stdout)["run"])
            self.assertEqual(json.loads((self.place / run / "provenance.json").read_text())["meta"]["operator"], operator)
        self.assertEqual(self.say("preview", ROOT / "experiments/labelled.toml").returncode, 0)
        for words, author in (([], "Ada Lovelace"), (["--author", "Kim"], "Kim")):
            self.assertEqual(self.say("runs", "note", run, f"by {author}", *words).returncode, 0)
            self.assertIn(f"{author}: by {author}", self.say("runs", "note", run).stdout)

    def test_people_have_tokens_that_the_table_does_not_hold_and_the_table_lies_beside_the_configuration(self):
        def told(*words, code=0):
            done = self.say("people", *words)
            self.assertEqual(done.returncode, code, done.stderr)
            return done.stdout if code == 0 else done.stderr
        added = json.loads(told("add", "Ada Lovelace", "--role", "operator", "--json"))
        table = self.place / ".config/firn/people"
        self.assertEqual((added["file"], table.stat().st_mode & 0o777), (str(table), 0o600))
        self.assertNotIn(added["token"], table.read_text())
        self.assertRegex(table.read_text(), rf"Ada Lovelace:operator:{hashlib.sha256(added['token'].encode()).hexdigest()}\n")
        told("add", "Olga")
        self.assertIn("is there already", told("add", "Olga", code=2))
        self.assertIn("a role is observer, operator or proxy", told("add", "Kim", "--role", "admin", code=2))
        self.assertIsNone(json.loads(told("add", "Petra", "--role", "operator", "--through-proxy", "--json"))["token"])
        self.assertIn("needs a token", told("add", "nginx", "--role", "proxy", "--through-proxy", code=2))
        told("remove", "Olga")
        self.assertIn("has no Olga", told("remove", "Olga", code=2))
        self.assertEqual(json.loads(told("list", "--json"))["people"], [{"name": "Ada Lovelace", "role": "operator", "token": True},
                                                                        {"name": "Petra", "role": "operator", "token": False}])

    def test_a_study_goes_there_too(self):
        study = self.place / "study.toml"
        study.write_text(f'name = "two"\nexperiment = "{SMALL[0]}"\nseeds = 1\n'
                         '[[scheme]]\nname = "a"\nset = ["control.scheme=smf", "part.height_mm=0.02"]\n'
                         '[[scheme]]\nname = "b"\nset = ["control.scheme=mpc", "part.height_mm=0.02"]\n')
        done = self.say("compare", study, FIRN_RUNS="env")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.place / "env/study-two/report.html").is_file())

    def test_the_variable_of_the_specification_names_the_folder_and_one_that_is_no_full_path_is_passed_over(self):
        self.write('[user]\nruns = "/of-home"\n')
        self.write('[user]\nruns = "/of-xdg"\n', "xdg")
        self.assertEqual(self.user(XDG_CONFIG_HOME=str(self.place / "xdg"))["runs"], "/of-xdg")
        self.assertEqual(self.user(XDG_CONFIG_HOME="xdg")["runs"], "/of-home")
        self.assertEqual(self.user(XDG_CONFIG_HOME=str(self.place / "none"))["runs"], "runs")
        self.assertEqual(self.user(HOME="", XDG_CONFIG_HOME="")["runs"], "runs")

    def test_a_mistake_is_told_with_file_line_and_key_and_help_still_comes(self):
        for text, wanted in (('[user]\nrun = "/x"\n', ":2: user.run"), ('[user]\n\nruns = "prints"\n', ":3: user.runs"),
                             ("[user\n", "config.toml:1"), ("[user]\nruns = 3\n", ":2: user.runs")):
            file = self.write(text)
            done = self.say("runs")
            self.assertEqual(done.returncode, 2, text)
            self.assertIn(str(file), done.stderr)
            self.assertIn(wanted, done.stderr)
            self.assertEqual(done.stdout, "")
            self.assertEqual(self.say("runs", "--help").returncode, 0)
            self.assertEqual(self.say("--version").returncode, 0)
            self.assertEqual(self.say("runs", "--runs", self.place).returncode, 0)
        self.assertFalse((self.place / "prints").exists())


class ExitCodes(Case):
    def test_the_page_and_the_manual_have_the_same_table(self):
        page = [(code, text) for code, text in CODE.findall((ROOT / "docs/exit-codes.md").read_text(encoding="utf-8"))]
        self.assertEqual([code for code, _ in page], ["0", "1", "2", "3", "4", "130"])
        self.assertEqual(self.say("completion", "man", "-o", "man").returncode, 0)
        for file in sorted((self.place / "man").iterdir()):
            status = file.read_text(encoding="utf-8").split(".SH EXIT STATUS\n")[1].split(".SH ")[0]
            found = re.findall(r"^\.TP\n(\d+)\n(.*)$", status.replace("\\-", "-"), re.M)
            self.assertEqual(found, page, file.name)

    def test_a_file_or_folder_that_is_not_there_is_code_2_for_every_command_that_takes_one(self):
        none = self.place / "none.toml"
        for words in (["print", none], ["preview", none], ["config", "check", none], ["compare", none], ["slice", none, "-o", "x.paths"],
                      ["plan", none, "--machine", none, "-o", "x.traj"], ["replay", none], ["audit", none], ["report", none],
                      ["export", none, "-o", "x.h5"], ["import", none], ["identify", none], ["tune", none], ["calibrate", none],
                      ["device", none, "lamp", "identify"], ["bringup", none], ["cassette", none], ["log", "info", none],
                      ["log", "verify", none], ["decide", "--height", none, "--target", none], ["ctl", none, "stop"], ["attach", none],
                      ["view", none], ["doctor", none], ["droplets", none], ["print", "--resume", none]):
            with self.subTest(words[0]):
                done = self.say(*words)
                self.assertEqual(done.returncode, 2, f"{words}: {done.stdout}{done.stderr}")
                self.assertEqual(done.stdout, "")
                self.assertIn("none.toml", done.stderr)

    def test_an_interrupted_print_ends_with_130_and_can_be_resumed(self):
        print_ = subprocess.Popen([FIRN, "print", ROOT / "experiments/cylinder.toml", "--bus", "in-process"], cwd=self.place,
                                  env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        while not list(self.place.glob("runs/*/nodes/controller.wal")) and print_.poll() is None:
            time.sleep(0.02)
        print_.send_signal(signal.SIGINT)
        said = print_.communicate(timeout=60)[0]
        self.assertEqual(print_.returncode, 130, said)
        run, = (self.place / "runs").iterdir()
        resumed = subprocess.Popen([FIRN, "print", "--resume", run, "--bus", "in-process"], cwd=self.place, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertIn(resumed.wait(timeout=300), (0, 4), resumed.communicate()[0])


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
