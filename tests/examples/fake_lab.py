#!/usr/bin/env python3
"""Plays the four instruments of the ink-jet lab: stage and laser profiler on TCP ports, jet and lamp on serial lines
(pseudo terminals). Each speaks its maker's protocol as docs/devices/ tells it; what the jet fires lies on a surface
that the profiler measures. docs/tutorials/your-lab.md walks through a lab on it.

    tests/examples/fake_lab.py [--folder DIR] [--stage PORT] [--profiler PORT] [--fault "SECONDS NAME KIND"]... [--json]

It prints the `[devices]` lines of a lab file. Lines that are written into DIR/keys, and --fault, hurt an instrument:
`lamp silent` (it hears and says nothing), `lamp nonsense` (random bytes), `lamp drop` (its port is gone), `lamp ok`.
`substrate bare` lays a new one, `substrate gauge` a gauge block under the profiler.
"""
import argparse
import errno
import json
import os
import random
import select
import signal
import socket
import sys
import time
import tty
from pathlib import Path

from fake_instruments import Jet, Lamp, Profiler, Stage, Surface

LOOK_S = 0.02  # between two looks at a serial line that nobody has opened
KINDS = ("ok", "silent", "nonsense", "drop")


class Port:
    """The line to one instrument, which one program at a time can hold; and what is wrong with it."""

    def __init__(self, instrument, rng):
        self.instrument, self.rng, self.kind, self.fds = instrument, rng, "ok", []
        self.look_again = 0.0  # not before

    def hurt(self, kind, now):
        if kind not in KINDS:
            raise ValueError(f"'{kind}' is none of {', '.join(KINDS)}")
        if "drop" in (self.kind, kind) and kind != self.kind:
            self.unplug() if kind == "drop" else self.plug()
            self.instrument.closed(now)
        self.kind = kind

    def said(self, data, now):
        """What goes back for what has come."""
        reply = self.instrument.take(data, now)
        if self.kind == "silent":
            return b""
        if self.kind == "nonsense" and reply:
            return self.rng.randbytes(len(reply) - 1) + reply[-1:]
        return reply


class TcpPort(Port):
    def __init__(self, instrument, rng, number):
        super().__init__(instrument, rng)
        self.number, self.host = number, None
        self.plug()

    def plug(self):
        self.listener = socket.create_server(("127.0.0.1", self.number), backlog=1)
        self.number = self.listener.getsockname()[1]
        self.fds = [self.listener]

    def unplug(self):
        for one in (self.listener, self.host):
            if one:
                one.close()
        self.host, self.fds = None, []

    def address(self):
        return f"tcp:127.0.0.1:{self.number}"

    def serve(self, now):
        if not self.host:
            self.host, _ = self.listener.accept()
            self.host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self.fds = [self.host]
            return
        try:
            data = self.host.recv(65536)
            if data:
                self.host.sendall(self.said(data, now))
        except ConnectionError:
            data = b""
        if not data:
            self.host.close()
            self.host, self.fds = None, [self.listener]
            self.instrument.closed(now)


class SerialPort(Port):
    def __init__(self, instrument, rng, link, baud):
        super().__init__(instrument, rng)
        self.link, self.baud = link, baud
        self.plug()

    def plug(self):
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(os.ttyname(slave))
        os.close(slave)
        self.fds = [self.master]

    def unplug(self):
        os.close(self.master)
        self.link.unlink(missing_ok=True)
        self.fds = []

    def address(self):
        return f"serial:{self.link}?baud={self.baud}"

    def serve(self, now):
        try:
            os.write(self.master, self.said(os.read(self.master, 4096), now))
        except OSError:  # nobody has it open
            self.look_again = now + LOOK_S
            if self.stays_held():
                os.close(self.master)
                self.plug()

    def stays_held(self):
        """A program's exclusive hold (TIOCEXCL) stays with a pseudo terminal after the program's end; only root passes it. A real
        line is free when its last user has closed it."""
        try:
            os.close(os.open(self.link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK))
        except OSError as error:
            look = select.poll()
            look.register(self.master, 0)  # a hang-up is told all the same
            return error.errno == errno.EBUSY and any(event & select.POLLHUP for _, event in look.poll(0))
        return False


class Lab:
    def __init__(self, folder, stage_port, profiler_port, seed=1):
        rng = random.Random(seed)
        self.surface = Surface(rng)
        jet, profiler = Jet(self.surface), Profiler(self.surface, rng)
        self.stage = Stage(jet, profiler)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "keys").unlink(missing_ok=True)
        os.mkfifo(folder / "keys")
        self.keys = os.open(folder / "keys", os.O_RDWR)  # it never ends
        self.ports = {"stage": TcpPort(self.stage, rng, stage_port),
                      "jet": SerialPort(jet, rng, folder / "jet", 9600),
                      "laser_profiler": TcpPort(profiler, rng, profiler_port),
                      "lamp": SerialPort(Lamp(), rng, folder / "lamp", 19200)}

    def addresses(self):
        return {name: port.address() for name, port in self.ports.items()}

    def turn(self):
        """Serves what comes within LOOK_S."""
        now = time.monotonic()
        listened = {fd: port for port in self.ports.values() if now >= port.look_again for fd in port.fds}
        ready, _, _ = select.select([self.keys, *listened], [], [], LOOK_S)
        now = time.monotonic()
        self.stage.advance(now)
        for fd in ready:
            if fd in listened:
                listened[fd].serve(now)
        if self.keys in ready:
            for line in os.read(self.keys, 4096).decode().splitlines():
                self.hurt(line.split())

    def hurt(self, words):
        try:
            name, kind = words
            if name == "substrate":
                self.surface.change(kind)
            else:
                self.ports[name].hurt(kind, time.monotonic())
            print(f"{name}: {kind}", file=sys.stderr, flush=True)
        except (ValueError, KeyError) as wrong:
            print(f"not understood: {' '.join(words)}: {wrong}", file=sys.stderr, flush=True)

    def unplug(self):
        os.close(self.keys)
        for port in self.ports.values():
            if port.fds:
                port.unplug()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path, default=Path("fake-lab"), help="where the serial lines appear")
    parser.add_argument("--stage", type=int, default=18000, metavar="PORT", help="TCP port; 0: a free one")
    parser.add_argument("--profiler", type=int, default=24691, metavar="PORT", help="TCP port; 0: a free one")
    parser.add_argument("--fault", action="append", default=[], metavar="\"SECONDS NAME KIND\"",
                        help=f"so long after the start; KIND: {', '.join(KINDS)}")
    parser.add_argument("--json", action="store_true", help="print the addresses as JSON")
    options = parser.parse_args()
    faults = sorted((float(at), name, kind) for at, name, kind in (fault.split() for fault in options.fault))
    lab = Lab(options.folder.resolve(), options.stage, options.profiler)
    if options.json:
        print(json.dumps(lab.addresses()), flush=True)
    else:
        print("[devices]", *(f'{name}.port = "{at}"' for name, at in lab.addresses().items()), sep="\n", flush=True)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())
    begin = time.monotonic()
    try:
        while True:
            while faults and time.monotonic() - begin >= faults[0][0]:
                lab.hurt(faults.pop(0)[1:])
            lab.turn()
    except KeyboardInterrupt:
        pass
    finally:
        lab.unplug()


if __name__ == "__main__":
    main()
