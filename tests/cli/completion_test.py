#!/usr/bin/env python3
"""Completion as the shells do it, and pages of the manual as groff reads them: tests/cli/completion_test.py FIRN"""
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

FIRN = None
BASH = """source {script}
COMP_WORDS=(firn {words} "$1") COMP_CWORD={count}
_firn
printf '%s\\n' "${{COMPREPLY[@]}}"
"""
# What zsh's own functions would be handed.
ZSH = """compdef() {{ :; }}
_describe() {{ print -l -- "${{(@P)2}}"; }}
compadd() {{ print -l -- "${{(@P)2}}"; }}
_files() {{ print files; }}
source {script}
words=(firn {words} '') CURRENT={count}
_firn
"""


def run(*words, **more):
    done = subprocess.run(words, capture_output=True, text=True, check=False, **more)
    if done.returncode != 0 or done.stderr:
        raise AssertionError(f"{words}: {done.returncode}: {done.stderr}")
    return done.stdout


class Completion(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def script(self, shell):
        file = self.folder / shell
        file.write_text(run(FIRN, "completion", shell), encoding="utf-8")
        return file

    def in_bash(self, words, start=""):
        text = BASH.format(script=self.script("bash"), words=words, count=len(words.split()) + 1)
        return run("bash", "--norc", "-uc", text, "bash", start).split()

    def in_zsh(self, words):
        text = ZSH.format(script=self.script("zsh"), words=words, count=len(words.split()) + 2)
        return [line.split(":")[0] for line in run("zsh", "-fc", text).splitlines()]

    def in_fish(self, words):
        lines = run("fish", "--no-config", "-c", f"source {self.script('fish')}; complete -C 'firn {words}'").splitlines()
        return [line.split("\t")[0] for line in lines]

    def read(self, page):
        return re.sub(".\b", "", run("groff", "-Kutf8", "-man", "-ww", "-Tutf8", "-P-c", page))  # without overstriking

    def test_commands_subcommands_options_and_choices_are_offered_in_each_shell(self):
        for name, complete in (("bash", self.in_bash), ("zsh", self.in_zsh)):
            with self.subTest(name):
                self.assertLessEqual({"print", "compare", "runs"}, set(complete("")))
                self.assertLessEqual({"check", "dump"}, set(complete("config")))
                self.assertLessEqual({"--seeds", "--shard", "-o", "--output"}, set(complete("compare")))
                self.assertNotIn("--shard", complete("print"))
                self.assertLessEqual({"any", "this"}, set(complete("compare --platform")))
                self.assertLessEqual({"bash", "man"}, set(complete("completion")))
        self.assertLessEqual({"print", "compare", "runs"}, set(self.in_fish("")))
        self.assertLessEqual({"check", "dump"}, set(self.in_fish("config ")))
        self.assertLessEqual({"--seeds", "--shard", "--output"}, set(self.in_fish("compare --")))
        self.assertNotIn("--shard", self.in_fish("print --"))
        self.assertEqual({"any", "this"}, set(self.in_fish("compare --platform ")))

    def test_a_script_is_written_where_it_is_wanted_with_the_folders_above(self):
        file = self.folder / "a" / "b" / "firn"
        self.assertEqual(run(FIRN, "completion", "bash", "-o", file), "")
        self.assertEqual(file.read_text(encoding="utf-8"), run(FIRN, "completion", "bash"))

    def test_a_word_that_was_begun_is_completed_and_an_option_s_file_is_left_to_the_shell(self):
        self.assertEqual(self.in_bash("compare", "--shar"), ["--shard"])
        self.assertEqual(self.in_bash("compare -o", "x"), [])  # complete -o default
        self.assertEqual(self.in_zsh("compare -o"), ["files"])

    def test_every_option_that_help_lists_is_offered(self):
        for command in self.in_bash(""):
            if command.startswith("-"):
                continue
            offered = set(self.in_bash(command))
            listed = {word.strip(",") for line in run(FIRN, command, "--help").splitlines() if line.startswith("  -")
                      for word in line.split("  ")[1].replace(",", " ").split()[:2] if word.startswith("-")}
            self.assertLessEqual(listed, offered, command)

    def test_pages_of_the_manual_have_no_warning_and_every_command_has_one(self):
        run(FIRN, "completion", "man", "-o", self.folder / "man")
        pages = {page.stem: page for page in (self.folder / "man").iterdir()}
        for command in self.in_bash(""):
            if not command.startswith("-"):
                self.assertIn(f"firn-{command}", pages)
        for page in pages.values():
            self.assertIn("EXIT STATUS", self.read(page), page)
        self.assertIn("--platform this|any", self.read(pages["firn-compare"]))

    def test_what_is_no_shell_is_refused_with_those_there_are(self):
        done = subprocess.run([FIRN, "completion", "csh"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("fish", done.stderr)
        done = subprocess.run([FIRN, "completion", "man"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("-o FOLDER", done.stderr)


if __name__ == "__main__":
    FIRN = sys.argv.pop(1)
    unittest.main()
