"""A controller as other people write it: PI, one command each h, in whatever Python has for HTTP.

    stranger.py LIBRARY [each] [early] [seq] [stamp] [rows]

LIBRARY is socket, http.client, urllib, requests, httpx, aiohttp, websockets or curl. `each`: a connection for each
message; else one is kept. `early`: it is opened before the start. `seq`, `stamp`: what the contract offers. `rows`:
leaves messages.csv, as webloop's own clients do. Libraries beyond Python's own are looked for in target/strangers;
one that is not there is not supported.
"""

import asyncio
import os
import pathlib
import subprocess
import sys
import time
import urllib.parse
import urllib.request

HERE = pathlib.Path(__file__).resolve()
sys.path.append(str(HERE.parents[4] / "target" / "strangers"))

LIBRARY, *HABITS = sys.argv[1:]
PLANT = os.environ["WEBLOOP_PLANT"]
HOST, PORT = PLANT.split("//")[1].split(":")
H_S = float(os.environ["WEBLOOP_H_S"])
R = float(os.environ["WEBLOOP_R"])
START_NS = int(os.environ["WEBLOOP_START_NS"])
COUNT = round(float(os.environ["WEBLOOP_DURATION_S"]) / H_S)
OUT = os.environ.get("WEBLOOP_OUT", ".")


def unsupported(why):
    print(why)
    sys.exit(127)


class Loop:
    """The law, and the rows if they are asked for."""

    def __init__(self):
        self.y = self.integral = 0.0
        self.rows = []

    def query(self, k):
        e = R - self.y
        self.integral += 0.378 * H_S * e
        u = 0.1701 * e + self.integral
        words = {"u": repr(u)}
        now_ns = time.monotonic_ns()
        if "seq" in HABITS:
            words["seq"] = k
        if "stamp" in HABITS:
            words["t_send_ns"] = now_ns
        row = [k, START_NS + round(k * H_S * 1e9), now_ns, "", "", R, self.y, e, u, "", "timeout"]
        self.rows.append(row)
        return urllib.parse.urlencode(words)

    def answered(self, text):
        answer = urllib.parse.parse_qs(text)
        self.y = float(answer["y"][0])
        row = self.rows[-1]
        row[3:5] = time.monotonic_ns(), int(answer["t_arrive_ns"][0])
        row[9:] = int(answer["tick"][0]), "answered"

    def close(self):
        if "rows" not in HABITS:
            return
        sent = {row[0] for row in self.rows}
        head = "seq,t_due_ns,t_send_ns,t_receive_ns,t_arrive_ns,r,y,e,u,tick,outcome"
        missed = [[k, START_NS + round(k * H_S * 1e9), "", "", "", R, "", "", "", "", "missed"]
                  for k in range(COUNT) if k not in sent]
        lines = [head] + [",".join(map(str, row)) for row in self.rows + missed]
        pathlib.Path(OUT, "messages.csv").write_text("\n".join(lines) + "\n")


def left_s(k):
    return (START_NS + k * H_S * 1e9 - time.monotonic_ns()) / 1e9


def deadlines():
    """Each deadline that is still to come when the answer before it has."""
    for k in range(COUNT):
        left = left_s(k)
        if left <= -H_S:
            continue
        time.sleep(max(0.0, left))
        yield k


def by_socket():
    import socket

    def connect():
        plug = socket.create_connection((HOST, int(PORT)), timeout=5)
        plug.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return plug

    kept = connect() if "early" in HABITS else None

    def get(query):
        nonlocal kept
        plug = kept or connect()
        close = "connection: close\r\n" if "each" in HABITS else ""
        plug.sendall(f"GET /closed?{query} HTTP/1.1\r\nhost: {HOST}\r\n{close}\r\n".encode())
        text = b""
        while b"\r\n\r\n" not in text:
            text += plug.recv(4096)
        head, body = text.split(b"\r\n\r\n", 1)
        length = next(int(line.split(b":")[1]) for line in head.split(b"\r\n") if line.lower().startswith(b"content-length"))
        while len(body) < length:
            body += plug.recv(4096)
        kept = None if "each" in HABITS else plug
        if "each" in HABITS:
            plug.close()
        return body.decode()

    return get


def by_http_client():
    import http.client

    kept = http.client.HTTPConnection(HOST, int(PORT), timeout=5)
    if "early" in HABITS:
        kept.connect()

    def get(query):
        nonlocal kept
        kept.request("GET", f"/closed?{query}")
        text = kept.getresponse().read().decode()
        if "each" in HABITS:
            kept.close()
        return text

    return get


def by_urllib():
    return lambda query: urllib.request.urlopen(f"{PLANT}/closed?{query}", timeout=5).read().decode()


def by_requests():
    import requests

    session = requests.Session()
    if "early" in HABITS:
        session.get(f"{PLANT}/state", timeout=5)
    get = requests.get if "each" in HABITS else session.get
    return lambda query: get(f"{PLANT}/closed?{query}", timeout=5).text


def by_httpx():
    import httpx

    client = httpx.Client(timeout=5)
    if "early" in HABITS:
        client.get(f"{PLANT}/state")
    get = httpx.get if "each" in HABITS else client.get
    return lambda query: get(f"{PLANT}/closed?{query}").text


def by_curl():
    get = ["curl", "--silent", "--max-time", "5"]
    return lambda query: subprocess.run([*get, f"{PLANT}/closed?{query}"], capture_output=True, text=True).stdout


async def by_aiohttp(loop):
    import aiohttp

    connector = aiohttp.TCPConnector(force_close="each" in HABITS)
    async with aiohttp.ClientSession(connector=connector) as session:
        if "early" in HABITS:
            await (await session.get(f"{PLANT}/state")).text()
        for k in range(COUNT):
            if left_s(k) <= -H_S:
                continue
            await asyncio.sleep(max(0.0, left_s(k)))
            async with session.get(f"{PLANT}/closed?{loop.query(k)}") as answer:
                loop.answered(await answer.text())


async def by_websockets(loop):
    import websockets

    async with websockets.connect(f"ws://{HOST}:{PORT}/socket?mode=closed") as plug:
        for k in range(COUNT):
            if left_s(k) <= -H_S:
                continue
            await asyncio.sleep(max(0.0, left_s(k)))
            await plug.send(loop.query(k))
            loop.answered(await plug.recv())


def main():
    loop = Loop()
    turns = {"aiohttp": by_aiohttp, "websockets": by_websockets}
    calls = {"socket": by_socket, "http.client": by_http_client, "urllib": by_urllib, "requests": by_requests,
             "httpx": by_httpx, "curl": by_curl}
    try:
        if LIBRARY in turns:
            asyncio.run(turns[LIBRARY](loop))
        else:
            get = calls[LIBRARY]()
            for k in deadlines():
                loop.answered(get(loop.query(k)))
    except ImportError as problem:
        unsupported(problem)
    except FileNotFoundError as problem:
        unsupported(problem)
    loop.close()


main()
