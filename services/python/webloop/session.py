"""The session in which a controller commands a plant whose lease is `token`.

It is claimed before the first command, and again after the plant has ended it: it does when it has
heard nothing for 15 s, as after a long outage.
"""

from __future__ import annotations

import http.client
import json
import socket
import threading
from typing import Dict, Optional, Tuple

from webloop.exchange import ExchangeError, NoAnswer
from webloop.query import MAX_BYTES, excerpt

HEADER = "Webloop-Session"
"""The header that carries the token."""

LOST = 409
"""The status by which a plant says that it does not accept a token."""

_CLAIM = json.dumps({"client": "webloop python", "rows": False})

_EXCERPT_CHARS = 200

_END_S = 1.0
"""How long to wait until the plant has taken its session back."""


class Session:
    """A session, claimed when it is needed; for several threads."""

    def __init__(self, plant: Tuple[str, int]) -> None:
        self._plant = plant
        self._token: Optional[str] = None
        self._lock = threading.Lock()

    def token(self, timeout_ns: int) -> str:
        """The token; of a session that is claimed now, if there is none.

        Raises `ExchangeError` or `NoAnswer`.
        """
        with self._lock:
            if self._token is None:
                text = self._post("/session", _CLAIM, {}, timeout_ns / 1e9)
                try:
                    self._token = str(json.loads(text)["session"])
                except (ValueError, KeyError, TypeError):
                    said = excerpt(text, _EXCERPT_CHARS)
                    raise ExchangeError(f"the claim's answer has no session: {said}") from None
            return self._token

    def forget(self, refused: str) -> None:
        """Takes notice that the plant does not accept this token any more."""
        with self._lock:
            if self._token == refused:
                self._token = None

    def end(self) -> None:
        """Gives the plant back. If that fails, its session ends by silence."""
        with self._lock:
            token, self._token = self._token, None
        if token is not None:
            try:
                self._post("/session/end", "{}", {HEADER: token}, _END_S)
            except (ExchangeError, NoAnswer):
                pass

    def _post(self, path: str, body: str, headers: Dict[str, str], timeout_s: float) -> str:
        client = http.client.HTTPConnection(*self._plant, timeout=timeout_s)
        try:
            client.request("POST", path, body, {"Content-Type": "application/json", **headers})
            response = client.getresponse()
            text = response.read(MAX_BYTES).decode("utf-8", "replace")
        except socket.timeout:
            raise NoAnswer from None
        except (OSError, http.client.HTTPException) as error:
            raise ExchangeError(str(error) or type(error).__name__) from None
        finally:
            client.close()
        if response.status >= 300:
            said = excerpt(text.rstrip(), _EXCERPT_CHARS)
            raise ExchangeError(f"{response.status} {response.reason}: {said}")
        return text
