"""The bus of a print for a program of the lab's own: hears LCM messages, publishes those that others may publish.

Python's standard library and lcm-gen (package liblcm-bin) are enough. With LCM's own Python module, `seal` alone is
needed: lcm.LCM(bus).publish(name, seal(...)).
"""
import hashlib
import importlib
import itertools
import os
import select
import socket
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

TYPES = Path(__file__).resolve().parents[2] / "lcmtypes"
MAGIC = 0x4C433032  # "LC02", a short message of LCM


def message_types():
    """Makes Python classes of Firn's messages. Returns a function from the name of a type to its class."""
    folder = tempfile.mkdtemp()
    subprocess.run(["lcm-gen", "--python", "--ppath", folder, *sorted(TYPES.glob("*.lcm"))], check=True)
    sys.path.insert(0, folder)
    return lambda name: getattr(importlib.import_module("firn." + name), name)


def seal(key, name, message, sender, number):
    """The message with what stands behind it: sender (8 bytes), number, and BLAKE2b of all under the program's key."""
    tail = sender + struct.pack(">Q", number)
    code = hashlib.blake2b(name.encode() + b"\0" + message + tail, key=key, digest_size=16)
    return message + tail + code.digest()


class Bus:
    def __init__(self, admission):
        """admission: the object that firn key --json prints, or the first line of a started program's input."""
        address, port = admission["bus"].removeprefix("udpm://").split("?")[0].split(":")
        self.group = (address, int(port))
        self.key = bytes.fromhex(admission["key"])
        self.prefix = f"own/{admission['program']}/"
        self.sender, self.numbers = os.urandom(8), itertools.count(1)
        loopback = socket.inet_aton("127.0.0.1")
        self.out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self.out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, loopback)
        self.heard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.heard.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.heard.bind(self.group)
        self.heard.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(address) + loopback)

    def publish(self, channel, message):
        """channel: "OWN_VALUES"; message: encoded."""
        name = self.prefix + channel
        sealed = seal(self.key, name, message, self.sender, next(self.numbers)) if self.key else message
        self.out.sendto(struct.pack(">II", MAGIC, 0) + name.encode() + b"\0" + sealed, self.group)

    def hear(self, seconds):
        """Returns (channel, bytes) of the next message; None if none comes. Messages of more than 60 kB come in tiles."""
        if not select.select([self.heard], [], [], seconds)[0]:
            return None
        packet = self.heard.recv(65536)
        if len(packet) < 10 or struct.unpack(">I", packet[:4])[0] != MAGIC:
            return None
        name, _, message = packet[8:].partition(b"\0")
        return name.decode(), message
