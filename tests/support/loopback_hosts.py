"""A cluster of two virtual nodes by Slurm, and computers that are reached by ssh, all on 127.0.0.1 and gone with the test."""
import os
import shutil
import socket
import subprocess
import time
from pathlib import Path

PATIENCE_S = 300  # a loaded computer takes its time; whoever waits looks five times a second


def missing(*programs):
    """The first of these programs that is not installed; None: all are."""
    path = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return next((p for p in programs if not shutil.which(p, path=path)), None)


def sbin(program):
    return shutil.which(program, path="/usr/sbin:/sbin:/usr/bin:/bin:" + os.environ.get("PATH", ""))


def free_ports(count):
    taken = [socket.socket() for _ in range(count)]
    for s in taken:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in taken]
    for s in taken:
        s.close()
    return ports


class Daemons:
    """Programs that are ended together with all that they started."""

    def __init__(self, folder):
        self.folder, self.all = Path(folder), {}

    def start(self, name, words, **more):
        with open(self.folder / f"{name}.out", "wb") as out:
            self.all[name] = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=out, stderr=subprocess.STDOUT,
                                              start_new_session=True, **more)

    def kill(self, name):
        process = self.all.pop(name)
        process.kill()
        process.wait()

    def stop(self):
        for process in reversed(self.all.values()):
            process.terminate()
        for process in self.all.values():
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self.all.clear()

    def told(self):
        return "\n".join(f"{f.name}: {f.read_text(errors='replace')[-1500:]}" for f in sorted(self.folder.glob("*.out")))


SLURM_CONF = """ClusterName=firn
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmdUser=root
SlurmctldPort={ctld}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
TaskProlog={folder}/prolog.sh
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
MpiDefault=none
SlurmdTimeout=10
JobRequeue=1
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/ctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
SlurmctldLogFile={folder}/ctld.log
SlurmdLogFile={folder}/slurmd-%n.log
MaxArraySize={most}
SchedulerType=sched/backfill
SchedulerParameters=batch_sched_delay=0,bf_interval=1,sched_interval=1
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port={n1} CPUs=1 RealMemory=1000 State=UNKNOWN
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port={n2} CPUs=1 RealMemory=1000 State=UNKNOWN
PartitionName=local Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class Cluster:
    """Slurm's controller and two nodes of one processor each."""

    PROGRAMS = ("slurmctld", "slurmd", "sbatch", "munged", "mungekey")

    def __init__(self, folder, most_shards=1000):
        self.folder = Path(folder)
        self.daemons = Daemons(folder)
        self.env = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}
        (self.folder / "state").mkdir()
        ctld, n1, n2 = free_ports(3)
        self.folder.chmod(0o755)  # munge wants a folder that others cannot write into and may look into
        (self.folder / "slurm.conf").write_text(SLURM_CONF.format(folder=self.folder, host=socket.gethostname(), ctld=ctld, n1=n1, n2=n2,
                                                                  most=most_shards + 1))
        self.prolog("")
        key = self.folder / "munge.key"
        subprocess.run([sbin("mungekey"), "--create", "--keyfile", key], check=True)
        self.daemons.start("munged", [sbin("munged"), "--foreground", "--force", "--key-file", key, "--socket", self.folder / "munge.socket",
                                      "--pid-file", self.folder / "munge.pid", "--seed-file", self.folder / "munge.seed"])
        self.wait_for(lambda: (self.folder / "munge.socket").exists(), "munged")
        self.daemons.start("slurmctld", [sbin("slurmctld"), "-D", "-c"], env=self.env)
        for node in ("n1", "n2"):
            self.start_node(node)
        self.wait_for(lambda: self.slurm("sinfo", "--noheader", "-N", "-o", "%T").split() == ["idle", "idle"], "nodes")

    def start_node(self, node):
        self.daemons.start(node, [sbin("slurmd"), "-D", "-N", node], env=self.env)

    def prolog(self, lines):
        """What each task's environment gets: lines for a shell that print `export NAME=VALUE`."""
        file = self.folder / "prolog.sh"
        file.write_text("#!/bin/bash\n" + lines)
        file.chmod(0o755)

    def kill_node(self, node):
        """As if the computer lost its power: its daemon, the tasks' steps and what they run."""
        stepds, others = [], []
        own = f"SLURM_CONF={self.folder}/slurm.conf\0".encode()  # another cluster may be at work on this computer
        for process in Path("/proc").iterdir():
            try:
                environment = (process / "environ").read_bytes()
                command = (process / "cmdline").read_bytes()
            except OSError:
                continue
            if own not in environment:
                continue
            if b"slurmstepd" in command and (f"SLURMD_NODENAME={node}\0".encode() in environment or f"[{node}]".encode() in command or
                                             self.is_of(process, node)):
                stepds.append(process.name)
            elif f"SLURMD_NODENAME={node}\0".encode() in environment:
                others.append(process.name)
        self.daemons.kill(node)  # first those that would report an end
        for pids in (stepds, others):
            if pids:
                subprocess.run(["kill", "-9", *pids], check=False, stderr=subprocess.DEVNULL)

    def is_of(self, stepd, node):
        """Is a child of this step daemon a task on the node?"""
        children = subprocess.run(["pgrep", "-P", stepd.name], capture_output=True, text=True, check=False).stdout.split()
        try:
            return any(f"SLURMD_NODENAME={node}\0".encode() in Path(f"/proc/{c}/environ").read_bytes() for c in children)
        except OSError:
            return False

    def slurm(self, *words):
        return subprocess.run(words, env=self.env, capture_output=True, text=True, check=False).stdout

    def wait_for(self, holds, what):
        end = time.monotonic() + PATIENCE_S
        while not holds():
            if time.monotonic() > end:
                raise RuntimeError(f"{what}: not within {PATIENCE_S} s\n{self.daemons.told()}")
            time.sleep(0.2)

    def stop(self):
        self.slurm("scancel", "--user=root")
        self.daemons.stop()


class Hosts:
    """Computers that are reached by ssh under the names of `names`; what each hides is an empty folder there."""

    PROGRAMS = ("sshd", "ssh", "ssh-keygen", "rsync")

    def __init__(self, folder, names, hidden=None):
        self.folder = Path(folder)
        self.daemons = Daemons(folder)
        for key in ("host", "user"):
            subprocess.run([sbin("ssh-keygen"), "-q", "-t", "ed25519", "-N", "", "-f", self.folder / key], check=True)
        shutil.copy(self.folder / "user.pub", self.folder / "authorized")
        Path("/run/sshd").mkdir(exist_ok=True)
        config = ""
        for name, port in zip(names, free_ports(len(names))):
            config += (f"Host {name}\nHostName 127.0.0.1\nPort {port}\nIdentityFile {self.folder}/user\nUserKnownHostsFile /dev/null\n"
                       "StrictHostKeyChecking no\nLogLevel ERROR\n")
            words = [sbin("sshd"), "-D", "-e", "-f", "/dev/null", "-p", str(port), "-h", str(self.folder / "host"), "-o", "ListenAddress=127.0.0.1",
                     "-o", f"AuthorizedKeysFile={self.folder}/authorized", "-o", "StrictModes=no", "-o", "UsePAM=no", "-o", "PidFile=none",
                     "-o", "PermitRootLogin=yes"]
            if hidden:
                words = ["unshare", "--mount", "sh", "-c", 'mount -t tmpfs none "$1" && shift && exec "$@"', "sh", str(hidden), *words]
            self.daemons.start(name, words)
        (self.folder / "ssh_config").write_text(config)
        ssh = self.folder / "ssh"  # first on the path: parallel and rsync start it
        ssh.write_text(f"#!/bin/sh\nexec {sbin('ssh')} -F {self.folder}/ssh_config \"$@\"\n")
        ssh.chmod(0o755)
        self.env = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}", "HOME": str(self.folder)}
        end = time.monotonic() + PATIENCE_S
        for name in names:
            while subprocess.run(["ssh", name, "true"], env=self.env, stdin=subprocess.DEVNULL, capture_output=True, check=False).returncode != 0:
                if time.monotonic() > end:
                    raise RuntimeError(f"{name}: sshd does not answer\n{self.daemons.told()}")
                time.sleep(0.2)

    def stop(self):
        self.daemons.stop()
