"""A step as the paper made it: Python's threading HTTP server, and urllib with a connection a message."""

import os
import signal
import sys
import time
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

path, measure_ms = sys.argv[1:]
ANSWER = b"seq=1234567&tick=1234567&t_arrive_ns=333946040170&y=0.12345678901234567&u=0.17010378"


class Plant(BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Length", str(len(ANSWER)))
        self.end_headers()
        self.wfile.write(ANSWER)

    def log_message(self, *_):
        pass


server = ThreadingHTTPServer(("127.0.0.1", 0), Plant)
url = "http://127.0.0.1:%d%s" % (server.server_port, path)
plant = os.fork()
if plant == 0:
    server.serve_forever()
server.socket.close()
try:
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    for _ in range(50):
        opener.open(url).read()
    took = []
    end = time.monotonic() + float(measure_ms) / 1000
    while time.monotonic() < end:
        begun = time.monotonic_ns()
        opener.open(url).read()
        took.append(time.monotonic_ns() - begun)
finally:
    os.kill(plant, signal.SIGKILL)
took.sort()
for name, share in ("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999):
    print(name, took[int((len(took) - 1) * share)] / 1000)
