"""What a description cannot tell schemathesis of a plant: whose turn it is, and what a checksum is.

A plant has one controller at a time, and whoever was heard last keeps it for seconds. So a valid request that
needs a session gets its token, and the session of an earlier one is ended before a request that would be refused
because of it. What is wrong in an invalid request is left alone.
"""

import atexit
import collections
import json
import os
import time
from urllib.parse import parse_qsl

import requests
import schemathesis

TOKEN = "Webloop-Session"
FORM = "application/x-www-form-urlencoded"

# Whether this plant takes commands of sessions only.
by_token = os.environ["WEBLOOP_SCHEMA_LEASE"] == "token"
# How often each status was answered, kept in a file at the end.
statuses: collections.Counter[str] = collections.Counter()
plant = requests.Session()


@atexit.register
def keep_counts() -> None:
    with open(os.environ["WEBLOOP_SCHEMA_COUNTS"], "w") as file:
        json.dump(statuses, file)


class Control:
    """The session that is held, if there is one."""

    token: str | None = None
    chunk = 0

    def begin(self, url: str) -> None:
        """Claims the plant, as soon as a controller without a session has been silent for long enough."""
        for _ in range(100):
            answer = plant.post(f"{url}/session", json={"client": "schemathesis"})
            if answer.status_code == 200:
                self.token, self.chunk = answer.json()["session"], 0
                return
            time.sleep(0.1)
        raise RuntimeError(f"no session within 10 s: {answer.text}")

    def end(self, url: str) -> None:
        plant.post(f"{url}/session/end", json={}, headers={TOKEN: self.token}).raise_for_status()
        self.token = None


control = Control()


@schemathesis.hook
def before_call(context, case, kwargs):
    # An answer is JSON where it is asked for, and else a query.
    if statuses.total() % 2:
        case.headers["Accept"] = "application/json"
    if case.meta is None or not case.meta.generation.mode.is_positive:
        return
    url = case.operation.base_url.rstrip("/")
    path = case.operation.path
    query, headers = case.query, case.headers
    commands = path in ("/closed", "/open", "/reset", "/socket")
    if path in ("/session/rows", "/session/end") or (commands and by_token):
        if control.token is None:
            control.begin(url)
        if path == "/socket":
            query["session"] = control.token
        else:
            headers[TOKEN] = control.token
        if path == "/session/rows":
            query["chunk"] = min(int(query["chunk"]), control.chunk)
    elif commands or case.method == "POST":
        headers.pop(TOKEN, None)
        query.pop("session", None)
        if control.token is not None:
            control.end(url)
    if query.pop("crc", None) is not None:
        sent = requests.Request(**case.as_transport_kwargs()).prepare().url.partition("?")[2]
        query["crc"] = f"{crc32c(sent.encode()):08x}"


@schemathesis.hook
def after_call(context, case, response):
    statuses[str(response.status_code)] += 1
    path, status = case.operation.path, response.status_code
    if path == "/session" and case.method == "POST" and status == 200:
        control.token, control.chunk = response.json()["session"], 0
    elif path == "/session/rows" and status == 204:
        control.chunk = max(control.chunk, int(case.query["chunk"]) + 1)
    elif path == "/session/end" and status == 204:
        control.token = None


def crc32c(data: bytes) -> int:
    """The checksum of a command, as RFC 3720 has it."""
    crc = 0xFFFFFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x82F63B78 * (crc & 1)
    return crc ^ 0xFFFFFFFF


@schemathesis.deserializer(FORM)
def read_form(context, response):
    """An answer that is a query, with its numbers read."""
    return {name: value(name, text) for name, text in parse_qsl(response.text, strict_parsing=True)}


def value(name: str, text: str):
    if name == "crc":
        return text
    values = [json.loads(part) for part in text.split(",")]
    return values[0] if len(values) == 1 else values
