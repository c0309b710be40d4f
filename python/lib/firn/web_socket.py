"""A WebSocket of a client [RFC 6455], with the standard library alone."""
import base64
import hashlib
import os
import socket
import ssl
import struct
import threading

from .program import FirnError

_KEY_END = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, section 1.3
_TEXT, _BINARY, _CLOSE, _PING, _PONG = 1, 2, 8, 9, 10
_MAX_HEAD_BYTES = 1 << 16
_MAX_MESSAGE_BYTES = 1 << 28  # the largest map has 4096 x 4096 values of 4 bytes


class WebSocket:
    """Messages in both directions: text as str, others as bytes. One thread receives; any thread sends."""

    def __init__(self, host, port, path, headers, secure, timeout_s):
        self._socket = socket.create_connection((host, port), timeout=timeout_s)
        try:
            if secure:
                self._socket = ssl.create_default_context().wrap_socket(self._socket, server_hostname=host)
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._sending, self._rest = threading.Lock(), b""
            self._shake_hands(f"{host}:{port}" if ":" not in host else f"[{host}]:{port}", path, headers)
            self._socket.settimeout(None)
        except BaseException:
            self._socket.close()
            raise

    def _shake_hands(self, authority, path, headers):
        key = base64.b64encode(os.urandom(16)).decode()
        lines = [f"GET {path} HTTP/1.1", f"Host: {authority}", "Upgrade: websocket", "Connection: Upgrade", f"Sec-WebSocket-Key: {key}",
                 "Sec-WebSocket-Version: 13", *(f"{name}: {value}" for name, value in headers.items())]
        if any("\r" in line or "\n" in line for line in lines):
            raise FirnError("a line break in an address or a token")
        self._socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        head = b""
        while b"\r\n\r\n" not in head:
            part = self._socket.recv(4096)
            if not part or len(head) > _MAX_HEAD_BYTES:
                raise FirnError(f"{authority}: no answer in HTTP")
            head += part
        head, self._rest = head.split(b"\r\n\r\n", 1)
        status, *fields = head.decode("latin-1").split("\r\n")
        found = {name.strip().lower(): value.strip() for name, _, value in (field.partition(":") for field in fields)}
        if status.split(" ")[1:2] != ["101"]:
            body = self._rest.decode("utf-8", "replace")
            raise FirnError(f"{authority}{path}: {status.partition(' ')[2]} {body}".strip())
        wanted = base64.b64encode(hashlib.sha1((key + _KEY_END).encode()).digest()).decode()
        if found.get("sec-websocket-accept") != wanted:
            raise FirnError(f"{authority}: answers, and speaks no WebSocket")

    def _read(self, count):
        while len(self._rest) < count:
            part = self._socket.recv(max(65536, count - len(self._rest)))
            if not part:
                raise EOFError
            self._rest += part
        data, self._rest = self._rest[:count], self._rest[count:]
        return data

    def _write(self, opcode, data):
        mask = os.urandom(4)
        size = len(data)
        head = bytes([0x80 | opcode])
        if size < 126:
            head += bytes([0x80 | size])
        elif size < 1 << 16:
            head += b"\xfe" + struct.pack(">H", size)
        else:
            head += b"\xff" + struct.pack(">Q", size)
        masked = bytes(byte ^ mask[k % 4] for k, byte in enumerate(data))
        with self._sending:
            self._socket.sendall(head + mask + masked)

    def send(self, text):
        """Sends a text."""
        self._write(_TEXT, text.encode())

    def receive(self):
        """The next message; None at the end of the connection."""
        parts, kind = b"", None
        try:
            while True:
                first, second = self._read(2)
                size = second & 127
                if size > 125:
                    size = struct.unpack(">H", self._read(2))[0] if size == 126 else struct.unpack(">Q", self._read(8))[0]
                if second & 128 or len(parts) + size > _MAX_MESSAGE_BYTES:
                    return None  # a server masks nothing; no message is so long
                data, opcode = self._read(size), first & 15
                if opcode == _CLOSE:
                    return None
                if opcode == _PING:
                    self._write(_PONG, data)
                elif opcode != _PONG:
                    kind = opcode or kind
                    parts += data
                    if first & 128:
                        return parts.decode("utf-8", "replace") if kind == _TEXT else parts
        except (EOFError, OSError):
            return None

    def close(self):
        """Ends the connection; a thread that receives gets None."""
        try:
            self._write(_CLOSE, b"")
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self._socket.close()
