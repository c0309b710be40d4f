"""A UV lamp on a laboratory power supply that speaks SCPI, over TCP or a serial line.

    [devices.lamp]
    port = "tcp:10.0.0.7:5025"
    kind = "python:scpi_lamp.py:Lamp(volts=12.0, full_a=0.7)"

The current sets the brightness: iris_percent of full_a. docs/write-a-driver.md explains each member.
"""
import time

from firn import Refused


class Lamp:
    safe_bytes = "OUTP OFF\n"  # sent by Firn itself, whatever this class does
    timeout_s = 1.0            # of each method below
    poll_s = 2.0               # between two calls of poll()

    def __init__(self, port, volts=12.0, full_a=0.7):
        port.timeout_s = 0.3
        self.port, self.volts, self.full_a = port, volts, full_a
        self.command("*CLS")
        self.command(f"VOLT {volts:.3f}")

    def identify(self):
        return self.port.ask("*IDN?")

    def on(self, iris_percent=100):
        if self.port.ask("STAT:INTERLOCK?") != "1":
            raise Refused("the door of the lamp's housing is open")
        self.command(f"CURR {self.full_a * iris_percent / 100:.4f}")
        self.command("OUTP ON")

    def off(self):
        self.command("OUTP OFF")

    def safe(self):
        self.off()
        if self.lit():
            raise RuntimeError("the output is still on")

    def lit(self):
        """The current tells whether it shines: a supply with a broken lead says ON as well."""
        if self.port.ask("OUTP?") != "1":
            return False
        time.sleep(0.02)  # until the current is there
        return float(self.port.ask("MEAS:CURR?")) > 0.05 * self.full_a

    def poll(self):
        if self.lit():
            raise RuntimeError("the output is on, and nobody switched it on")

    def command(self, text):
        """Sends it and asks whether it was obeyed."""
        error = self.port.ask(text + ";:SYST:ERR?")
        if not error.startswith(("0,", "+0,")):
            raise RuntimeError(f"{text}: {error}")
