"""Attacks on live prints: see attack.sh."""
import json
import os
import random
import re
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
# A small part, node time ten times faster than the wall clock.
TINY = ["grid.nx=9", "grid.ny=9", "part.shape=cuboid", "part.width_mm=1.5", "part.depth_mm=1.5", "part.height_mm=0.03",
        "process.scan_speed_mm_s=3.0", "process.max_rescans=4"]
# Experiment and settings of each lab, and its instruments.
LABS = {
    "inkjet": ("demo.toml", TINY, ("stage", "jet", "laser_profiler", "lamp")),
    "aerosol": ("aerosol-meander.toml", ["aerosol.layers=3"], ("stage", "laser_profiler", "heater", "gas")),
    "ice": ("ice-small-paths.toml", [], ("robot", "valve_a", "valve_b", "laser_point", "heater")),
}
MOST_RSS = 100e6  # bytes of a process of a print whose instrument babbles
LAST_ORDER_S = 0.3 + 0.05  # run.lease_s, and the time of a turn
YEAR_S = 31_556_952
LCM_SHORT, LCM_FRAGMENT = 0x4C433032, 0x4C433033
PATIENCE_S = 60


def settings(values):
    return [word for value in values for word in ("--set", value)]


def answers(run):
    """Does the desk of a print answer? It does once all processes have begun."""
    folder = os.open(run, os.O_PATH)
    try:
        with socket.socket(socket.AF_UNIX) as desk:
            desk.settimeout(1.0)
            desk.connect(f"/proc/self/fd/{folder}/operator")  # a socket's path is short
            desk.sendall(b"state\n")
            return desk.recv(100).startswith(b"state ")
    except OSError:
        return False
    finally:
        os.close(folder)


def await_print(place, pattern, process):
    """Waits until a print has begun. Returns its run folder; None: it ended before."""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until and process.poll() is None:
        for desk in place.glob(pattern + "/operator"):
            if answers(desk.parent):
                return desk.parent
        time.sleep(0.01)
    return None


class Instrument(threading.Thread):
    """Stands between a driver and a simulated instrument, and babbles to the driver once it is told to."""

    def __init__(self, at, behind, seed):
        super().__init__(daemon=True)
        self.behind, self.random = str(behind), random.Random(seed)
        self.babbles, self.over, self.ordered_s, self.last_reply, self.stopped_s = False, False, [], b"\0", None
        self.greeting = b""  # what the driver sends first on every connection: a question, or how it wants to be answered
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(at))
        self.listener.listen(4)
        self.start()

    def run(self):
        while not self.over:
            try:
                host, _ = self.listener.accept()
            except OSError:
                return
            try:
                self.serve(host)
            except OSError:
                pass
            host.close()

    def serve(self, host):
        device = socket.socket(socket.AF_UNIX)
        device.connect(self.behind)
        host.setblocking(False)
        device.setblocking(False)
        try:
            while not self.over and not self.babbles:
                moved = False
                for source, sink in ((host, device), (device, host)):
                    try:
                        data = source.recv(65536)
                    except BlockingIOError:
                        continue
                    if not data:
                        return
                    moved = True
                    if source is host and not self.greeting:
                        self.greeting = data
                    if source is device:
                        self.last_reply = data
                    sink.setblocking(True)
                    sink.sendall(data)
                    sink.setblocking(False)
                if not moved:
                    time.sleep(0.0005)
            babble = self.babble()
            while not self.over:
                try:
                    host.send(babble)
                except BlockingIOError:
                    time.sleep(0.0005)
                try:
                    heard = host.recv(65536)
                    if not heard:
                        return
                    if heard != self.greeting:
                        self.ordered_s.append(time.monotonic())
                except BlockingIOError:
                    pass
        finally:
            device.close()

    def babble(self):
        kind = self.random.randrange(4)
        if kind == 0:
            return self.random.randbytes(65536)
        if kind == 1:
            return b"\r\n" * 32768
        if kind == 2:
            return bytes(65536)
        return (self.last_reply * (65536 // len(self.last_reply) + 1))[:65536]

    def stop(self):
        self.over = True
        self.listener.close()


class LiveAttack:
    """Attacks on live prints; of Attack, which has the commands and the invariants."""

    def live_print(self, place, *words, env=None):
        experiment, sets, _ = LABS["inkjet"]
        return self.start(["print", str(ROOT / "experiments" / experiment), *settings(sets), "--runs", str(place), *words],
                          env=None if env is None else {**os.environ, **env})

    def begun(self, *words, env=None):
        """(place, process, run) of a live print that has begun; run None: it did not."""
        place = Path(tempfile.mkdtemp(dir=self.folder))
        process = self.live_print(place, *words, env=env)
        return place, process, await_print(place, "*", process)

    def runs_in(self, place):
        return [r for r in place.iterdir() if (r / "provenance.json").exists() and (r / "nodes").exists()]

    def judged(self, row, what, place, process, begun=True):
        """Waits for a print, and counts the try."""
        code, output = self.end_of(process)
        problems = self.crashed("print", code, output)
        if not begun:
            problems.append(f"the print did not begin, exit {code}: {output[-300:]}")
        for run in self.runs_in(place):
            problems += self.lost(run)
        self.tried(row, what, problems)
        shutil.rmtree(place)

    # ------------------------------------------------------------------------------------------------------------ pairs
    def live(self):
        return [(self.live_pair, other, first) for other in self.commands for first in (True, False)]

    def live_pair(self, other, print_first):
        if self.stopped is None:
            place, process, run = self.begun()
            self.done_words(["ctl", str(run), "stop"])
            self.end_of(process)
            self.stopped = run
        run = self.copy(self.stopped)
        resume, words = ["print", "--resume", str(run)], self.command(other, run)
        first, second = (resume, words) if print_first else (words, resume)
        delay = self.random.uniform(0, 3.0) if print_first else self.random.uniform(0, 1.1) * self.seconds(other, self.stopped)
        a = self.start(first)
        time.sleep(delay)
        b = self.start(second)
        ends = [("first", *self.end_of(a)), ("second", *self.end_of(b))]
        problems = [p for end in ends for p in self.crashed(*end)]
        if not run.exists() and other != "clean":
            problems.append("the run is gone")
        what = f"live print, {delay:.3f} s later {other}" if print_first else f"{other}, {delay:.3f} s later live print"
        self.tried("live", what, problems + self.lost(run))
        shutil.rmtree(run.parent)

    # ------------------------------------------------------------------------------------------------- stalls and clocks
    def stalls(self):
        return [(self.stall,)]

    def stall(self):
        place, process, run = self.begun()
        what = []
        for _ in range(self.random.randint(1, 4) if run else 0):
            try:
                pids = dict(line.split() for line in (run / "pids").read_text().splitlines())
            except OSError:
                break
            name = self.random.choice(sorted(pids))
            seconds = self.random.uniform(0.01, 2.0)
            what.append(f"{name} stands still for {seconds:.2f} s")
            try:
                os.kill(int(pids[name]), signal.SIGSTOP)
                time.sleep(seconds)
                os.kill(int(pids[name]), signal.SIGCONT)
            except ProcessLookupError:
                break
            time.sleep(self.random.uniform(0, 0.5))
        self.judged("stalls", ", ".join(what), place, process, run is not None)

    def clocks(self):
        return [(self.clock, kind) for kind in ("steps", "leap", "drift")]

    def clock(self, kind):
        library = next(self.build.glob("tests/**/libother_clock.so"), None)
        if library is None:
            return self.left_out("clocks", "tests/live/other_clock is not built")
        clocks = self.folder / "clocks"

        def set_error(wall_s=0, leap_s=0.0, ppm=0):
            with open(clocks, "r+b" if clocks.exists() else "wb") as file:
                file.write(struct.pack("=qqq", int(wall_s * 1e9), int(leap_s * 1e9), ppm))

        set_error(ppm=self.random.randint(-1000, 1000) if kind == "drift" else 0)
        place, process, run = self.begun(env={"LD_PRELOAD": str(library), "FIRN_CLOCK_FILE": str(clocks)})
        problems, what = [] if run else ["the print did not begin"], kind
        if kind == "leap":
            seconds = self.random.uniform(2.0, 3600.0)
            what = f"a leap of {seconds:.1f} s"
            set_error(leap_s=seconds)
            code, output = self.end_of(process)
            if code != 3 or "this computer stood still for" not in output:
                problems.append(f"not stopped by name, exit {code}: {output[-300:]}")
        while kind == "steps" and process.poll() is None:
            set_error(wall_s=self.random.choice((-1, 1)) * self.random.choice((30, 3600, 86_400, YEAR_S, 30 * YEAR_S)))
            time.sleep(0.05)
        if kind != "leap":
            code, output = self.end_of(process)
            if code != 0:
                problems.append(f"exit {code}: {output[-300:]}")
        for found in self.runs_in(place):
            problems += self.lost(found)
        self.tried("clocks", what, problems)
        shutil.rmtree(place)

    # -------------------------------------------------------------------------------------------------------- full disks
    def disks(self):
        return [(self.full_disk, live) for live in (True, False)]

    def full_disk(self, live):
        """Prints on a disk of few kB in a mount namespace of its own, and takes what is left to a large one."""
        if subprocess.run(["unshare", "--map-root-user", "--mount", "true"], capture_output=True).returncode != 0:
            return self.left_out("disks", "no mount namespace can be had")
        place, disk = Path(tempfile.mkdtemp(dir=self.folder)), Path(tempfile.mkdtemp(dir=self.folder))
        kilobytes = self.random.randint(200, 6000)
        script = 'mount -t tmpfs -o size="$2k" none "$0" || exit 99; "${@:3}"; code=$?; cp -a "$0"/. "$1"; exit $code'
        experiment, sets, _ = LABS["inkjet"]
        words = [self.firn, "print", str(ROOT / "experiments" / experiment), *settings(sets), "--runs", str(disk),
                 *([] if live else ["--bus", "in-process"])]
        process = subprocess.Popen(["unshare", "--map-root-user", "--mount", "bash", "-c", script, str(disk), str(place), str(kilobytes),
                                    *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                   errors="replace", start_new_session=True)
        self.judged("disks", f"{kilobytes} kB, {'live' if live else 'in one process'}", place, process)
        shutil.rmtree(disk)

    # ---------------------------------------------------------------------------------------------------------- datagrams
    def forged(self):
        return [(self.forge,)]

    def forge(self):
        place, process, run = self.begun()
        problems = [] if run else ["the print did not begin"]
        if run:
            port = int(re.search(r"udpm://[\d.]+:(\d+)", (run / "clocks").read_text()).group(1))
            problems += [] if self.send_forged(process, port) else ["nothing was sent"]
        code, output = self.end_of(process)
        if code != 0:
            problems.append(f"exit {code}: {output[-300:]}")
        if "foreign datagrams dropped" not in output:
            problems.append("the print says nothing of foreign datagrams")
        for found in self.runs_in(place):
            problems += self.lost(found)
        self.tried("forged", "datagrams of another program", problems)
        shutil.rmtree(place)

    def send_forged(self, process, port):
        """Repeats and alters what it hears, and sends nonsense, until the print is over. Returns how many datagrams."""
        group = "239.255.76.67"
        ear = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        ear.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        ear.bind((group, port))
        ear.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(group) + socket.inet_aton("127.0.0.1"))
        ear.setblocking(False)
        mouth = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        mouth.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        heard, sent = [], 0
        while process.poll() is None:
            try:
                heard.append(ear.recv(65536))
            except BlockingIOError:
                pass
            heard = [datagram for datagram in heard[-200:] if datagram]
            datagrams = [self.nonsense()]
            if heard:
                datagram = bytearray(self.random.choice(heard))
                datagrams.append(bytes(datagram))
                datagram[self.random.randrange(len(datagram))] ^= 1 << self.random.randrange(8)
                datagrams.append(bytes(datagram))
            for datagram in datagrams:
                mouth.sendto(datagram, (group, port))
                sent += 1
            time.sleep(0.002)  # a flood is another matter: it takes processor time from the lease
        ear.close()
        mouth.close()
        return sent

    def nonsense(self):
        channel = self.random.choice((b"ENABLE", b"SAFE_STOP", b"STAGE_COMMAND", b"JET_COMMAND", b"", b"x" * 80))
        body = self.random.randbytes(self.random.choice((0, 1, 7, 100, 1400)))
        return self.random.choice((
            struct.pack(">II", LCM_SHORT, self.random.getrandbits(32)) + channel + b"\0" + body,
            struct.pack(">IIIIHH", LCM_FRAGMENT, 1, self.random.getrandbits(32), self.random.getrandbits(32),
                        self.random.getrandbits(16), self.random.getrandbits(16)) + channel + b"\0" + body,
            body))

    # -------------------------------------------------------------------------------------------------------------- floods
    def floods(self):
        return [(self.flood, lab, port) for lab, (_, _, ports) in LABS.items() for port in ports]

    def lab_of_world(self, lab):
        """A run folder whose experiment and inputs a world serves: of a print that ends before its first layer."""
        if lab not in self.worlds:
            experiment, sets, _ = LABS[lab]
            place = Path(tempfile.mkdtemp(dir=self.folder))
            process = self.start(["print", str(ROOT / "experiments" / experiment), *settings([*sets, "run.time_scale=1"]), "--bus",
                                  "in-process", "--runs", str(place)])
            self.worlds[lab] = await_print(place, "*", process)
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
        return self.worlds[lab]

    def flood(self, lab, port):
        """One instrument of a live print on sockets begins to babble; then the operator stops the print."""
        base, place = self.lab_of_world(lab), Path(tempfile.mkdtemp(dir=self.folder))
        hardware = place / "w"
        for name in ("experiment.toml", "provenance.json", "inputs"):
            source = base / name
            hardware.mkdir(exist_ok=True)
            (shutil.copytree if source.is_dir() else shutil.copy)(source, hardware / name)
        blobs = [word for b in json.loads((base / "provenance.json").read_text())["inputs"]
                 for word in ("--blob", f"{b['role']}={b['sha256']}")]
        world = subprocess.Popen([str(Path(self.firn).parent / "world"), "--run", str(hardware), "--epoch-ns",
                                  str(time.clock_gettime_ns(time.CLOCK_BOOTTIME)), *blobs], stdin=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        problems, instruments = [], {}
        ports = LABS[lab][2]
        until = time.monotonic() + PATIENCE_S
        while not all((hardware / "io" / p).exists() for p in ports) and time.monotonic() < until and world.poll() is None:
            time.sleep(0.01)
        for p in ports:
            instruments[p] = Instrument(place / p, hardware / "io" / p, self.random.getrandbits(32))
        experiment, sets, _ = LABS[lab]
        process = self.start(["print", str(ROOT / "experiments" / experiment),
                              *settings([*sets, "run.time_scale=1", *[f"devices.{p}.port=unix:{place / p}" for p in ports]]),
                              "--runs", str(place / "runs"), "--plain", "--accept-bringup", "all"])
        found, figures = await_print(place, "runs/*", process), {}
        if found:
            time.sleep(self.random.uniform(0.5, 3.0))
            problems += self.stop_in_flood(found, instruments[port], figures)
        code, output = self.end_of(process)
        if not found:
            problems.append(f"the print did not begin, exit {code}: {output[-300:]}")
        problems += self.crashed("print", code, output)
        if (stopped_s := instruments[port].stopped_s) is not None:
            last_s = max((s - stopped_s for s in instruments[port].ordered_s if s >= stopped_s), default=0.0)
            figures["last order, ms"] = 1e3 * last_s
            problems += [f"an order {1e3 * last_s:.0f} ms after the stop"] * (last_s > LAST_ORDER_S)
        if "and was killed" in output:
            problems.append(f"a process did not end by itself: {output[-300:]}")
        for run in self.runs_in(place / "runs") if (place / "runs").exists() else []:
            for name, wanted in (("audit", "clean"), ("replay", "identical")):
                code, said = self.done(name, run)
                if code != 0 or wanted not in said:
                    problems.append(f"{name} says, exit {code}: {said[-300:]}")
        for instrument in instruments.values():
            instrument.stop()
        world.terminate()
        world.communicate()
        self.tried("floods", f"{lab}: {port}", problems, figures)
        shutil.rmtree(place)

    def stop_in_flood(self, run, instrument, figures):
        """Babbles, and stops the print. Fills in the figures: most memory of a process, time to the answer."""
        pids = [int(line.split()[1]) for line in (run / "pids").read_text().splitlines()]
        instrument.babbles = True
        time.sleep(self.random.uniform(0.5, 2.0))
        figures["memory, MB"] = max(map(self.most_memory, pids), default=0) / 1e6
        stopped_s = time.monotonic()
        code, output = self.done_words(["ctl", "--json", str(run), "stop"])
        if "is not running" in output:
            return []  # the lost instrument has stopped the print
        if code != 0:
            return [f"the stop was not obeyed, exit {code}: {output[-300:]}"]
        figures["stop answered, ms"] = json.loads(output[output.index("{"):])["ms"]
        instrument.stopped_s = stopped_s
        return [f"{figures['memory, MB']:.0f} MB of memory"] * (figures["memory, MB"] * 1e6 > MOST_RSS)

    @staticmethod
    def most_memory(pid):
        """The most bytes that a process held in memory so far; 0: it has ended."""
        try:
            found = re.search(r"VmHWM:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
        except OSError:
            return 0
        return int(found.group(1)) * 1024 if found else 0
