#!/usr/bin/env python3
"""Studies on other computers: a cluster of two virtual nodes by Slurm, and computers reached by ssh, on loopback.

    tests/cli/engines_test.py FIRN ROOT [CASE...]

Whatever makes the prints, and whatever dies meanwhile, the results are those of the study in one piece, byte for byte.
"""
import os
import signal
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from loopback_hosts import Cluster, Hosts, missing  # noqa: E402
from studied import Studied  # noqa: E402

OTHER_ARITHMETIC = "export GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-AVX2,-FMA4"


class OnSlurm(Studied):
    def setUp(self):
        super().setUp()
        self.studied(30)
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.cluster = Cluster(place.name, most_shards=8)
        self.addCleanup(self.cluster.stop)
        self.env = self.cluster.env

    def test_a_study_in_shards_gives_the_bytes_of_the_study_in_one_piece(self):
        said = self.compare("out", "--on", "slurm", "--chunk", "0.2")
        self.assertIn("submitted to Slurm as job", said)
        self.compare("alone", env=self.cluster.env)
        self.assert_same_results("out", "alone")
        self.assertIn("over", self.compare("out", "--status"))

    def test_a_node_that_dies_costs_nothing_and_a_job_is_joined_again(self):
        self.compare("out", "--on", "slurm:local", "--chunk", "0.2", "--detach")
        self.eventually(lambda: self.on_record("out") >= 4, "the first prints")
        self.cluster.kill_node("n2")
        self.cluster.start_node("n2")

        def begin_at_once():  # Slurm holds back what it starts again for two minutes
            for task in self.cluster.slurm("squeue", "--noheader", "--array", "-o", "%i %r").splitlines():
                if "BeginTime" in task:
                    self.cluster.slurm("scontrol", "update", f"JobId={task.split()[0]}", "StartTime=now")
            return not self.cluster.slurm("squeue", "--noheader").strip()

        self.assertIn("job", self.compare("out", "--status"))
        waiting = subprocess.Popen(self.words("out", "--on", "slurm"), env=self.env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.eventually(begin_at_once, "all tasks")
        said = waiting.communicate(timeout=900)[0]
        self.assertEqual(waiting.returncode, 0, said)
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_results_of_a_node_with_other_arithmetic_count_only_where_any_is_asked_for(self):
        self.cluster.prolog(f'if [ "$SLURMD_NODENAME" = n2 ]; then echo "{OTHER_ARITHMETIC}"; fi\n')
        differs = has_fused_multiply_add()
        said = self.compare("out", "--on", "slurm", "--chunk", "0.2", code=1 if differs else 0)
        if not differs:
            return
        self.assertIn("give other results than this one's", said)
        said = self.compare("out", "--on", "slurm", "--platform", "any")
        summary = (self.folder / "out" / "summary.json").read_text(encoding="utf-8")
        self.assertIn("of a platform whose library functions give other results", summary)
        self.cluster.prolog("")
        self.compare("out", "--on", "slurm", "--chunk", "0.2")
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_results_of_a_node_that_runs_other_variants_and_gives_equal_results_count_as_one_platform(self):
        self.cluster.prolog('if [ "$SLURMD_NODENAME" = n2 ]; then echo "export GLIBC_TUNABLES=glibc.cpu.hwcaps=-ERMS"; fi\n')
        said = self.compare("out", "--on", "slurm", "--chunk", "0.2")
        self.assertNotIn("give other results", said)
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_a_cancelled_job_leaves_what_it_printed_and_the_next_one_goes_on(self):
        self.compare("out", "--on", "slurm", "--chunk", "0.2", "--detach")
        self.eventually(lambda: self.on_record("out") >= 4, "the first prints")
        self.assertIn("is cancelled", self.compare("out", "--on", "slurm", "--cancel"))
        self.eventually(lambda: not self.cluster.slurm("squeue", "--noheader").strip(), "the end of the job")
        before = self.on_record("out")
        self.assertGreaterEqual(before, 4)
        self.compare("out", "--on", "slurm", "--chunk", "0.2")
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_a_partition_that_is_none_is_told_in_slurm_s_words(self):
        self.assertIn("Invalid partition", self.compare("out", "--on", "slurm:night", code=2))


class OverSsh(Studied):
    def hosts(self, names, hidden=None):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        hosts = Hosts(place.name, names, hidden)
        self.addCleanup(hosts.stop)
        self.env = hosts.env
        return hosts

    def test_a_study_on_two_computers_with_one_folder_gives_the_bytes_of_the_study_in_one_piece(self):
        self.studied(30)
        self.hosts(["alpha", "beta"])
        self.assertIn("shards of about 0.2 s to alpha,beta", self.compare("out", "--on", "ssh:alpha,beta", "--chunk", "0.2"))
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_results_of_computers_without_the_folder_come_back(self):
        self.studied(30)
        (self.folder / "out").mkdir()
        self.hosts(["alpha", "beta"], hidden=self.folder / "out")
        self.compare("out", "--on", "ssh:alpha,beta", "--chunk", "0.2")
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_a_computer_that_dies_costs_nothing(self):
        self.studied(30)
        hosts = self.hosts(["alpha", "beta"])
        running = subprocess.Popen(self.words("out", "--on", "ssh:alpha,beta", "--chunk", "0.2"), env=self.env, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True)
        self.eventually(lambda: self.on_record("out") >= 4, "the first prints")
        hosts.daemons.kill("beta")
        for process in shards_of(self.folder / "out"):  # its prints die too, and alpha's
            os.kill(process, signal.SIGKILL)
        said = running.communicate(timeout=900)[0]
        if running.returncode == 1:
            self.assertIn("missing", said)
            self.compare("out")
        self.compare("alone")
        self.assert_same_results("out", "alone")

    def test_a_computer_that_does_not_answer_or_runs_another_build_is_named(self):
        self.studied(2)
        self.hosts(["alpha"])
        self.assertIn("nowhere", self.compare("out", "--on", "ssh:nowhere", code=2))
        self.assertIn("must be slurm", self.compare("out", "--on", "torque", code=2))
        self.assertIn("must be slurm", self.compare("out", "--on", "ssh:", code=2))
        self.assertIn("--detach", self.compare("out", "--on", "ssh:alpha", "--detach", code=2))


def shards_of(out):
    """Processes that print a shard of a study's folder."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if str(out) in words and "--shard" in words:
            found.append(int(process.name))
    return found


def has_fused_multiply_add():
    return " fma" in Path("/proc/cpuinfo").read_text(encoding="utf-8")


def main():
    Studied.firn, Studied.root = sys.argv[1:3]
    for programs in (Cluster.PROGRAMS, Hosts.PROGRAMS, ("parallel",)):
        if name := missing(*programs):
            print(f"skipped: cluster: {name} is not installed")
            return 77
    done = unittest.main(argv=[sys.argv[0], *sys.argv[3:]], exit=False)
    return 0 if done.result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
