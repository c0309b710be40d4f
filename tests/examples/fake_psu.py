#!/usr/bin/env python3
"""Plays the SCPI power supply of experiments/drivers/scpi_lamp.py on a TCP port, with faults.

    tests/examples/fake_psu.py [--port PORT] [--log FILE]

It prints its address as a line `tcp:127.0.0.1:PORT`. Lines on standard input hurt it:

    silent     it hears and says nothing        late S     its answers come S seconds late
    nonsense   random bytes for each answer     split      a byte at a time
    drop       its port closes, and opens again with `ok`
    dark       its lead is broken: no current   stuck      OUTP OFF does not switch it off
    door       its interlock is open            refuse     each command is an error
    ok         none of these

FILE gets a line for each change of the output, with the monotonic time in s: "12.345 on 0.5600 A", "12.845 off".
"""
import argparse
import random
import select
import socket
import sys
import time


class Supply:
    def __init__(self, log):
        self.log, self.fault, self.late_s = log, "ok", 0.0
        self.output, self.volts, self.amperes, self.error = False, 0.0, 0.0, ""

    def switch(self, on):
        if on == self.output or (not on and self.fault == "stuck"):
            return
        self.output = on
        words = f"on {self.amperes:.4f} A" if on else "off"
        print(f"{time.monotonic():.6f} {words}", file=self.log, flush=True)

    def execute(self, text):
        """Returns the answer of one command or question; "" if it has none."""
        word, _, value = text.strip().lstrip(":").partition(" ")
        if self.fault == "refuse" and not word.endswith("?"):
            self.error = '-221,"Settings conflict"'
            return ""
        if word == "*IDN?":
            return "FIRN,FAKE PSU,0042,1.0"
        if word == "OUTP?":
            return "1" if self.output else "0"
        if word == "MEAS:CURR?":
            return f"{self.amperes if self.output and self.fault != 'dark' else 0.0:.4f}"
        if word == "STAT:INTERLOCK?":
            return "0" if self.fault == "door" else "1"
        if word == "SYST:ERR?":
            error, self.error = self.error or '0,"No error"', ""
            return error
        try:
            if word == "OUTP":
                self.switch({"ON": True, "1": True, "OFF": False, "0": False}[value])
            elif word == "VOLT":
                self.volts = float(value)
            elif word == "CURR":
                self.amperes = float(value)
            elif word != "*CLS":
                raise KeyError(word)
        except (KeyError, ValueError):
            self.error = f'-113,"Undefined header;{text}"'
        return ""

    def answer(self, line):
        """Returns what it says to a line: the answers of its commands, separated by ';'."""
        answers = [said for said in (self.execute(text) for text in line.split(";")) if said]
        return (";".join(answers) + "\n").encode() if answers else b""


def serve(supply, number):
    rng = random.Random(1)
    listener = socket.create_server(("127.0.0.1", number))
    number = listener.getsockname()[1]
    print(f"tcp:127.0.0.1:{number}", flush=True)
    host, heard, due = None, b"", []  # due: time and bytes of answers to come
    while True:
        watched = [one for one in (listener, host) if one] + [sys.stdin]
        wait = min([0.5, *(max(0.0, at - time.monotonic()) for at, _ in due)])
        ready, _, _ = select.select(watched, [], [], wait)
        if sys.stdin in ready:
            words = sys.stdin.readline().split()
            if not words:
                return
            supply.fault = words[0]
            supply.late_s = float(words[1]) if words[0] == "late" else 0.0
            if words[0] == "drop" and listener:
                for one in filter(None, (listener, host)):
                    one.close()
                listener = host = None
            elif not listener:
                listener = socket.create_server(("127.0.0.1", number))
            print(f"psu: {' '.join(words)}", file=sys.stderr, flush=True)
            continue
        if listener in ready:
            if host:
                host.close()
            host, _ = listener.accept()
            host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            heard, due = b"", []
            continue
        try:
            if host in ready:
                data = host.recv(4096)
                if not data:
                    raise ConnectionError
                *lines, heard = (heard + data).split(b"\n")
                for line in lines:
                    said = supply.answer(line.decode("latin-1").strip())
                    if supply.fault == "nonsense" and said:
                        said = rng.randbytes(len(said) - 1) + b"\n"
                    if supply.fault != "silent":
                        due.append((time.monotonic() + supply.late_s, said))
            while due and due[0][0] <= time.monotonic():
                _, said = due.pop(0)
                for piece in ([said[n:n + 1] for n in range(len(said))] if supply.fault == "split" else [said]):
                    host.sendall(piece)
        except ConnectionError:
            host.close()
            host, due = None, []


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--port", type=int, default=0, help="TCP port; 0: a free one")
    parser.add_argument("--log", default="/dev/null", help="file of the output's changes")
    options = parser.parse_args()
    with open(options.log, "w") as log:
        serve(Supply(log), options.port)


if __name__ == "__main__":
    main()
