"""FakeLab runs tests/examples/fake_lab.py beside a test."""
import json
import socket
import subprocess
import sys
from pathlib import Path


class FakeLab:
    def __init__(self, root, folder, *words):
        """On free ports, unless `words` name some."""
        program = Path(root) / "tests" / "examples" / "fake_lab.py"
        self.keys = Path(folder) / "keys"
        self.process = subprocess.Popen([sys.executable, "-B", program, "--folder", folder, "--json",
                                         *(words or ("--stage", "0", "--profiler", "0"))],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addresses = json.loads(self.process.stdout.readline())

    def devices(self):
        """The lines of a lab file."""
        return "\n".join(["[devices]", *(f'{name}.port = "{at}"' for name, at in self.addresses.items())])

    def hurt(self, name, kind):
        """Returns when it is so."""
        self.keys.write_text(f"{name} {kind}\n")
        told = self.process.stderr.readline().strip()
        if told != f"{name}: {kind}":
            raise RuntimeError(told)

    @staticmethod
    def unheard_port():
        """A TCP port at which nobody listens."""
        with socket.socket() as one:
            one.bind(("127.0.0.1", 0))
            return one.getsockname()[1]

    def end(self):
        self.process.terminate()
        self.process.communicate()
