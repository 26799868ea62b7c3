"""What the two ends say to each other.

A port of the crate `endpoint`'s `message`. On the wire a message is a
URI-encoded query, as in the paper: `seq=7&t_send_ns=1200000&u=0.35`.
"""

from __future__ import annotations

from typing import NamedTuple, Optional

from webloop.query import InvalidMessage, count, decimal, fields, finite


class Command(NamedTuple):
    """From controller to plant: use this input."""

    seq: int
    """Number of the deadline at which it was sent."""
    t_send_ns: int
    """When it was sent, on the controller's clock."""
    u: float
    """The input."""

    def query(self) -> str:
        """The command as it goes on the wire."""
        return f"seq={self.seq}&t_send_ns={self.t_send_ns}&u={decimal(self.u)}"


class Answer(NamedTuple):
    """From plant to controller: the command arrived, and what became of the plant."""

    seq: int
    """The command that this answers."""
    t_arrive_ns: int
    """When that command arrived, on the plant's clock."""
    tick: Optional[int] = None
    """The plant's latest tick; none in open loop, where the plant only acknowledges."""
    y: Optional[float] = None
    """The output after that tick; none in open loop."""


class Observation(NamedTuple):
    """The plant seen without commanding it."""

    t_ns: int
    """When it was seen, on the plant's clock."""
    tick: int
    """The latest tick."""
    y: float
    """The output after that tick."""
    u: float
    """The input that the plant holds."""


_STATE = ("seq", "tick", "t_arrive_ns", "y", "u")
_ACKNOWLEDGEMENT = ("seq", "t_arrive_ns")
_OBSERVATION = ("t_ns", "tick", "y", "u")


def parse_answer(mode: str, text: str) -> Answer:
    """Reads an answer in the form that a loop of this mode gets."""
    if mode == "closed":
        seq, tick, t_arrive_ns, y, u = fields(text, _STATE)
        # The plant's u is read, since an invalid number is a broken answer,
        # and left: what the plant holds is the plant's row.
        finite("u", u)
        return Answer(
            count("seq", seq),
            count("t_arrive_ns", t_arrive_ns),
            count("tick", tick),
            finite("y", y),
        )
    seq, t_arrive_ns = fields(text, _ACKNOWLEDGEMENT)
    return Answer(count("seq", seq), count("t_arrive_ns", t_arrive_ns))


def parse_answer_to(command: Command, mode: str, text: str) -> Answer:
    """Reads the answer to `command`; one to another command is refused, for its
    y belongs to another moment."""
    answer = parse_answer(mode, text)
    if answer.seq != command.seq:
        raise InvalidMessage(
            f"field `seq`: the answer is to command {answer.seq}, the command was {command.seq}"
        )
    return answer


def parse_observation(text: str) -> Observation:
    """Reads the plant's answer to `GET /state`."""
    t_ns, tick, y, u = fields(text, _OBSERVATION)
    return Observation(count("t_ns", t_ns), count("tick", tick), finite("y", y), finite("u", u))
