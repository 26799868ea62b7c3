"""Stands in for rosbridge_server and a node behind it: the paper's PI on the topics of the ROS package
`pid`. It speaks the part of rosbridge's protocol that adapter.py needs, to one client.
"""

import base64
import hashlib
import json
import os
import socket

GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455, section 1.3


class Pi:
    """The node: /setpoint and /state in, /control_effort out, each h."""

    def __init__(self, h):
        self.h, self.r, self.integral = h, 0.0, 0.0

    def on_message(self, topic, value):
        if topic == "/setpoint":
            self.r = value
        elif topic == "/state":
            e = self.r - value
            self.integral += 0.378 * self.h * e
            return 0.1701 * e + self.integral
        return None


def frames(stream):
    """The opcode and the payload of each frame that a client sends."""
    while True:
        head = stream.read(2)
        if len(head) < 2:
            return
        length = head[1] & 0x7F
        if length > 125:
            length = int.from_bytes(stream.read(2 if length == 126 else 8), "big")
        mask, payload = stream.read(4), stream.read(length)
        yield head[0] & 0x0F, bytes(byte ^ mask[at % 4] for at, byte in enumerate(payload))


def text_frame(text):
    payload = text.encode()
    assert len(payload) < 126
    return bytes((0x81, len(payload))) + payload


with socket.create_server(("127.0.0.1", int(os.environ["ROSBRIDGE_PORT"]))) as server:
    client, _ = server.accept()
client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
stream = client.makefile("rb")
headers = dict(line.decode().strip().split(": ", 1) for line in iter(stream.readline, b"\r\n") if b": " in line)
accept = base64.b64encode(hashlib.sha1((headers["Sec-WebSocket-Key"] + GUID).encode()).digest()).decode()
client.sendall(
    f"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    f"Sec-WebSocket-Accept: {accept}\r\n\r\n".encode()
)
node = Pi(float(os.environ["WEBLOOP_H_S"]))
for opcode, payload in frames(stream):
    if opcode == 8:
        break
    message = json.loads(payload)
    if message["op"] != "publish":
        continue  # `advertise` and `subscribe`: there is one client, and it gets all
    u = node.on_message(message["topic"], message["msg"]["data"])
    if u is not None:
        client.sendall(text_frame(json.dumps({"op": "publish", "topic": "/control_effort", "msg": {"data": u}})))
