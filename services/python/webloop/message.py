"""What the two ends say to each other.

A port of the crate `endpoint`'s `message`. On the wire a message is a
URI-encoded query, as in the paper: `seq=7&t_send_ns=1200000&u=0.35`. Of a plant
with two inputs or outputs it has both, the first first: `u=0.35,0.1`.
"""

from __future__ import annotations

from typing import Any, Callable, NamedTuple, Optional, Sequence, Tuple, Union

from webloop.query import InvalidMessage, count, decimal, fields, finite

Signal = Union[float, Tuple[float, float]]
"""The inputs or the outputs of a plant at one instant: a number, or two."""


def first(signal: Signal) -> float:
    """The first input or output; of most plants it is the only one."""
    return signal[0] if isinstance(signal, tuple) else signal


def numbers(signal: Signal) -> Sequence[float]:
    """Each of its numbers, the first one first."""
    return signal if isinstance(signal, tuple) else (signal,)


def signal_of(value: Any, number: Callable[[Any], float]) -> Signal:
    """The signal that a program of one's own gives: what `number` makes of it or, if that is a
    TypeError, of each of the two that are in it: in a tuple, a list or an array.

    Raises what `number` does, or `LookupError`.
    """
    try:
        return number(value)
    except TypeError:
        if len(value) != 2:
            raise
        return number(value[0]), number(value[1])


class Command(NamedTuple):
    """From controller to plant: use this input."""

    seq: int
    """Number of the deadline at which it was sent."""
    t_send_ns: int
    """When it was sent, on the controller's clock."""
    u: Signal
    """The input, or both."""

    def query(self) -> str:
        """The command as it goes on the wire."""
        u = ",".join(map(decimal, numbers(self.u)))
        return f"seq={self.seq}&t_send_ns={self.t_send_ns}&u={u}"


class Answer(NamedTuple):
    """From plant to controller: the command arrived, and what became of the plant."""

    seq: int
    """The command that this answers."""
    t_arrive_ns: int
    """When that command arrived, on the plant's clock."""
    tick: Optional[int] = None
    """The plant's latest tick; none in open loop, where the plant only acknowledges."""
    y: Optional[Signal] = None
    """The output after that tick, or both; none in open loop."""
    u: Optional[Signal] = None
    """The input that the plant holds from now on, or both; none in open loop."""


class AnswerFacts(NamedTuple):
    """What the newest answer tells a law beside the output, and when it was asked for."""

    tick: int
    """The plant's tick to which the output belongs."""
    u: Signal
    """The input that the plant holds from the next tick on, or both."""
    send_ns: int
    """When the message was sent that it answers, on the controller's clock."""


class Moment(NamedTuple):
    """When a command is sent, and when the newest output was."""

    send_ns: int
    """When the command is sent, on the controller's clock."""
    told: Optional[AnswerFacts]
    """The answer that brought the output; none before the first."""


class Observation(NamedTuple):
    """The plant seen without commanding it."""

    t_ns: int
    """When it was seen, on the plant's clock."""
    tick: int
    """The latest tick."""
    y: Signal
    """The output after that tick, or both."""
    u: Signal
    """The input that the plant holds, or both."""


_STATE = ("seq", "tick", "t_arrive_ns", "y", "u")
_ACKNOWLEDGEMENT = ("seq", "t_arrive_ns")
_OBSERVATION = ("t_ns", "tick", "y", "u")
_WATCHDOG = ("u_applied", "safe", "trips")


def parse_answer(mode: str, text: str) -> Answer:
    """Reads an answer in the form that a loop of this mode gets."""
    if mode == "closed":
        seq, tick, t_arrive_ns, y, u = fields(text, _STATE)
        return Answer(
            count("seq", seq),
            count("t_arrive_ns", t_arrive_ns),
            count("tick", tick),
            _signal("y", y, "outputs"),
            _signal("u", u, "inputs"),
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
    # What the plant's watchdog does is not the controller's to know.
    t_ns, tick, y, u = fields(text, _OBSERVATION, _WATCHDOG)
    return Observation(
        count("t_ns", t_ns),
        count("tick", tick),
        _signal("y", y, "outputs"),
        _signal("u", u, "inputs"),
    )


def _signal(field: str, value: str, which: str) -> Signal:
    """One finite number, or two with a comma between them."""
    if "," not in value:
        return finite(field, value)
    parts = value.split(",")
    if len(parts) != 2:
        raise InvalidMessage(f"field `{field}` has {len(parts)} numbers; a plant has one or two {which}")
    return finite(field, parts[0]), finite(field, parts[1])
