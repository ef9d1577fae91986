"""A client of RFC 6455, as small as the tests need it: whole messages, with a deadline for everything."""

import base64
import json
import os
import socket
import struct
import time
import urllib.request


class Refused(Exception):
    """The server did not open the websocket; the text is its answer."""


class WebSocket:
    def __init__(self, port, path="/", protocol=None, origin=None, timeout=10):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=timeout)
        self.pending = b""
        lines = [f"GET {path} HTTP/1.1", f"Host: 127.0.0.1:{port}", "Upgrade: websocket", "Connection: Upgrade",
                 "Sec-WebSocket-Key: " + base64.b64encode(os.urandom(16)).decode(), "Sec-WebSocket-Version: 13"]
        if protocol:
            lines.append("Sec-WebSocket-Protocol: " + protocol)
        if origin:
            lines.append("Origin: " + origin)
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        answer = b""
        while b"\r\n\r\n" not in answer:
            part = self.socket.recv(65536)
            if not part:
                raise Refused(answer.decode(errors="replace"))
            answer += part
        head, self.pending = answer.split(b"\r\n\r\n", 1)
        if b" 101 " not in head.split(b"\r\n")[0]:
            raise Refused(head.decode(errors="replace"))
        self.protocol = next((line.split(b":", 1)[1].strip().decode() for line in head.split(b"\r\n")
                              if line.lower().startswith(b"sec-websocket-protocol:")), None)

    def close(self):
        self.socket.close()

    def send(self, data, opcode=1):
        payload = data.encode() if isinstance(data, str) else data
        mask, n = os.urandom(4), len(payload)
        size = struct.pack("!B", 0x80 | n) if n < 126 else struct.pack("!BH", 0xfe, n) if n < 65536 else \
            struct.pack("!BQ", 0xff, n)
        masked = bytes(b ^ mask[i % 4] for i, b in enumerate(payload))
        self.socket.sendall(struct.pack("!B", 0x80 | opcode) + size + mask + masked)

    def send_json(self, value):
        self.send(json.dumps(value))

    def _take(self, count, deadline):
        while len(self.pending) < count:
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError("the websocket was silent")
            self.socket.settimeout(left)
            part = self.socket.recv(1 << 20)
            if not part:
                raise ConnectionError("the websocket was closed")
            self.pending += part
        out, self.pending = self.pending[:count], self.pending[count:]
        return out

    def receive(self, timeout=10):
        """The next message: str, or bytes of a binary one."""
        deadline = time.monotonic() + timeout
        whole, kind = b"", None
        while True:
            first, second = self._take(2, deadline)
            n = second & 127
            if n == 126:
                n = struct.unpack("!H", self._take(2, deadline))[0]
            elif n == 127:
                n = struct.unpack("!Q", self._take(8, deadline))[0]
            payload, opcode = self._take(n, deadline), first & 15
            if opcode == 8:
                raise ConnectionError(f"the websocket was closed: {payload!r}")
            if opcode == 9:
                self.send(payload, 10)
            if opcode >= 8:
                continue
            kind = opcode or kind
            whole += payload
            if first & 0x80:
                return whole.decode() if kind == 1 else whole

    def receive_until(self, condition, timeout=10):
        """The first message for which condition(message) is true."""
        deadline = time.monotonic() + timeout
        while True:
            message = self.receive(max(0.01, deadline - time.monotonic()))
            if condition(message):
                return message


def fetch(port, path, host=None, timeout=10):
    """(status, body) of a path on 127.0.0.1."""
    request = urllib.request.Request(f"http://127.0.0.1:{port}{path}", headers={"Host": host} if host else {})
    try:
        with urllib.request.urlopen(request, timeout=timeout) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as e:
        return e.code, e.read()
