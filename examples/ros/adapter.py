"""A controller that is a ROS node: the loop's y and r go to it as topics through rosbridge, and its u comes
back as one. The topics are those of the ROS package `pid`: /setpoint, /state and /control_effort.

A controller reaches no network but the loop's, so the ROS side is started from here: all arguments are its
command, which has to answer rosbridge's JSON over a WebSocket at ROSBRIDGE_PORT on 127.0.0.1. With ROS that
is a script that launches rosbridge_server and the node; node.py stands in for both.
"""

import atexit
import json
import os
import socket
import subprocess
import sys
import threading
import time

import webloop
from webloop.exchange import ExchangeError, NoAnswer
from webloop.websocket import Closed, WebSocket

START_WITHIN_S = 10


class Ros:
    def __init__(self, bridge):
        self.bridge = bridge
        self.u = 0.0
        self.came = threading.Condition()
        threading.Thread(target=self.listen, daemon=True).start()

    def say(self, op, topic, **more):
        self.bridge.send(json.dumps({"op": op, "topic": topic, **more}))

    def start(self, h, r):
        for topic in ("/setpoint", "/state"):
            self.say("advertise", topic, type="std_msgs/Float64")
        self.say("subscribe", "/control_effort", type="std_msgs/Float64")
        self.say("publish", "/setpoint", msg={"data": r})

    def update(self, r, y, dt):
        with self.came:
            self.say("publish", "/state", msg={"data": y})
            self.came.wait(dt / 2)  # a node that is slower is answered by its last command
            return self.u

    def listen(self):
        try:
            while True:
                for text in self.bridge.receive(1_000_000_000):
                    message = json.loads(text)
                    if message.get("topic") == "/control_effort":
                        with self.came:
                            self.u = float(message["msg"]["data"])
                            self.came.notify()
        except Closed as error:
            sys.exit(f"rosbridge: {error}")


def connect(command):
    """Starts the ROS side and connects to its rosbridge."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    ros = subprocess.Popen(command, env={**os.environ, "ROSBRIDGE_PORT": str(port)})
    atexit.register(ros.terminate)
    give_up = time.monotonic() + START_WITHIN_S
    while True:
        try:
            return WebSocket(("127.0.0.1", port), "/", 1_000_000_000)
        except (ExchangeError, NoAnswer) as error:
            if ros.poll() is not None or time.monotonic() > give_up:
                sys.exit(f"no rosbridge answers on port {port}: {error}")
            time.sleep(0.05)


if os.environ.get("WEBLOOP_MODE") == "open":
    sys.exit(127)  # an open loop is not supported
if len(sys.argv) < 2:
    sys.exit("give the command that starts rosbridge and the node, like python3 node.py")
webloop.control(Ros(connect(sys.argv[1:])))
