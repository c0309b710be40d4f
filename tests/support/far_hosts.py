"""Computers of a lab: a network namespace each, with an sshd and a line to this one that delays, loses and can be cut."""
import fcntl
import heapq
import os
import random
import selectors
import shutil
import socket
import struct
import subprocess
import tempfile
import threading
import time
from pathlib import Path

TUNSETIFF = 0x400454CA
IFF_TUN, IFF_NO_PI = 0x0001, 0x1000
PATIENCE_S = 30
os.environ["PATH"] = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"


def refused():
    """Why this machine gives no such computers; empty: it does. It makes one, and asks it something."""
    for program in ("ip", "sshd", "ssh", "ssh-keygen"):
        if not shutil.which(program):
            return f"{program} is not installed"
    if os.geteuid() != 0:
        return "network namespaces need root"
    try:
        with tempfile.TemporaryDirectory() as folder:
            hosts = FarHosts(folder, ["probe"])
            hosts.stop()
    except (OSError, RuntimeError) as error:
        return " ".join(str(error).split())[:300]
    return ""


def tun(name):
    fd = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        fcntl.ioctl(fd, TUNSETIFF, struct.pack("16sH22x", name.encode(), IFF_TUN | IFF_NO_PI))
    except OSError:
        os.close(fd)
        raise
    return fd


def run(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(" ".join(map(str, words)) + ": " + done.stderr)


class SlowLink(threading.Thread):
    """Carries packets between two TUN devices: each takes `delay_s` +- `jitter_s` one way, and `loss` of them are lost."""

    def __init__(self, a, b, seed=1):
        super().__init__(daemon=True)
        self.ends, self.random = (a, b), random.Random(seed)
        self.delay_s = self.jitter_s = self.loss = 0.0
        self.down = self.over = False
        self.packets = 0
        self.waking = socket.socketpair()
        self.start()

    def run(self):
        waiting, number = [], 0
        selector = selectors.DefaultSelector()
        for n, fd in enumerate(self.ends):
            selector.register(fd, selectors.EVENT_READ, n)
        selector.register(self.waking[0], selectors.EVENT_READ, None)
        while not self.over:
            timeout = max(0.0, waiting[0][0] - time.monotonic()) if waiting else None
            for key, _ in selector.select(timeout):
                if key.data is None:
                    return
                for _ in range(64):
                    try:
                        packet = os.read(key.fd, 65536)
                    except BlockingIOError:
                        break
                    self.packets += 1
                    if self.down or self.random.random() < self.loss:
                        continue
                    wait = max(0.0, self.delay_s + self.jitter_s * self.random.uniform(-1, 1))
                    number += 1
                    heapq.heappush(waiting, (time.monotonic() + wait, number, 1 - key.data, packet))
            while waiting and waiting[0][0] <= time.monotonic():
                _, _, to, packet = heapq.heappop(waiting)
                if not self.down:
                    try:
                        os.write(self.ends[to], packet)
                    except OSError:
                        pass  # as a full queue of a card: lost

    def stop(self):
        self.over = True
        self.waking[1].send(b"x")
        self.join()
        for end in self.waking:
            end.close()
        for fd in self.ends:
            os.close(fd)


class FarHosts:
    """The computers `names`; `env` has the ssh that knows them, and `link[NAME]` is the line to each."""

    def __init__(self, folder, names, seed=1):
        self.folder, self.names = Path(folder), list(names)
        self.link, self.daemon, self.spaces = {}, {}, {}
        try:
            self.make(seed)
        except BaseException:
            self.stop()
            raise

    def make(self, seed):
        for key in ("host", "user"):
            run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", self.folder / key)
        shutil.copy(self.folder / "user.pub", self.folder / "authorized")
        Path("/run/sshd").mkdir(exist_ok=True)
        known, config = "", ""
        host_key = (self.folder / "host.pub").read_text().split()
        for n, name in enumerate(self.names):
            net, space, tag = f"10.211.{os.getpid() % 200 + 20}.{8 * n}", f"firn{os.getpid()}-{name}", f"{os.getpid() % 100000}{n}"
            here, there = net.rsplit(".", 1)[0] + f".{8 * n + 1}", net.rsplit(".", 1)[0] + f".{8 * n + 2}"
            self.spaces[name] = space
            run("ip", "netns", "add", space)
            ends = tun(f"fh{tag}"), tun(f"ff{tag}")
            run("ip", "link", "set", f"ff{tag}", "netns", space)
            run("ip", "addr", "add", f"{here}/30", "dev", f"fh{tag}")
            run("ip", "link", "set", f"fh{tag}", "up")
            for words in ("link set lo up", "link set lo multicast on", "route add 224.0.0.0/4 dev lo", f"addr add {there}/30 dev ff{tag}",
                          f"link set ff{tag} up"):
                run("ip", "-n", space, *words.split())
            self.link[name] = SlowLink(*ends, seed=seed + n)
            known += f"{there} {host_key[0]} {host_key[1]}\n"
            config += f"Host {name}\nHostName {there}\nUser root\nIdentityFile {self.folder}/user\nUserKnownHostsFile {self.folder}/known\n"
            home = self.folder / name
            home.mkdir()
            self.serve(name)
        (self.folder / "known").write_text(known)
        (self.folder / "ssh_config").write_text(config)
        ssh = self.folder / "ssh"  # first on the path
        ssh.write_text(f"#!/bin/sh\nexec {shutil.which('ssh')} -F {self.folder}/ssh_config \"$@\"\n")
        ssh.chmod(0o755)
        self.env = {**os.environ, "PATH": f"{self.folder}:{os.environ['PATH']}"}
        for name in self.names:
            self.wait_for(name)

    def serve(self, name):
        sshd = shutil.which("sshd")
        words = ["ip", "netns", "exec", self.spaces[name], sshd, "-D", "-e", "-f", "/dev/null", "-h", self.folder / "host", "-o",
                 f"AuthorizedKeysFile={self.folder}/authorized", "-o", "StrictModes=no", "-o", "UsePAM=no", "-o", "PidFile=none", "-o",
                 "PermitRootLogin=yes", "-o", f"SetEnv=XDG_STATE_HOME={self.folder / name} XDG_DATA_HOME={self.folder / name}/data"]
        with open(self.folder / f"{name}.sshd", "ab") as out:
            self.daemon[name] = subprocess.Popen([str(w) for w in words], stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True)

    def wait_for(self, name):
        end = time.monotonic() + PATIENCE_S
        while subprocess.run(["ssh", name, "true"], env=self.env, stdin=subprocess.DEVNULL, capture_output=True, check=False).returncode != 0:
            if time.monotonic() > end:
                raise RuntimeError(f"{name}: sshd does not answer\n" + (self.folder / f"{name}.sshd").read_text())
            time.sleep(0.1)

    def pids(self, name):
        """Of every process on the computer but its sshd."""
        out = subprocess.run(["ip", "netns", "pids", self.spaces[name]], capture_output=True, text=True, check=False).stdout.split()
        return [int(p) for p in out if int(p) != self.daemon[name].pid]

    def on(self, name, *words, **more):
        """Runs a command there."""
        return subprocess.run(["ip", "netns", "exec", self.spaces[name], *words], capture_output=True, text=True, check=False, **more)

    def stop(self):
        for name in self.spaces:
            for pid in self.pids(name):
                try:
                    os.kill(pid, 9)
                except ProcessLookupError:
                    pass
            if name in self.daemon:
                self.daemon[name].kill()
                self.daemon[name].wait()
            if name in self.link:
                self.link[name].stop()
            subprocess.run(["ip", "netns", "del", self.spaces[name]], capture_output=True, check=False)


def serve(folder, names):
    """For a test in another language: orders on standard input, an answer of one line each."""
    import sys
    hosts = FarHosts(folder, names)
    try:
        print("ready " + str(hosts.folder), flush=True)
        for line in sys.stdin:
            verb, name, *numbers = line.split()
            if verb == "line":  # delay [s], jitter [s], loss
                link = hosts.link[name]
                link.delay_s, link.jitter_s, link.loss = map(float, numbers)
            elif verb in ("cut", "mend"):
                hosts.link[name].down = verb == "cut"
            elif verb in ("freeze", "thaw", "kill"):
                for pid in hosts.pids(name):
                    try:
                        os.kill(pid, {"freeze": 19, "thaw": 18, "kill": 9}[verb])
                    except ProcessLookupError:
                        pass
            elif verb == "pids":
                print(" ".join(map(str, hosts.pids(name))), flush=True)
                continue
            else:
                print("unknown", flush=True)
                continue
            print("ok", flush=True)
    finally:
        hosts.stop()


if __name__ == "__main__":
    import sys
    if sys.argv[1] == "refused":
        print(refused())
    else:
        serve(sys.argv[1], sys.argv[2:])
