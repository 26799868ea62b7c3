"""The control law: which there are, and how one is read from JSON.

The form is that of the crate `system`'s `Design`. Reading is strict: every
field has to be there and no other may be, shapes have to fit, numbers are
finite. What a law does is in the module of its name.
"""

from __future__ import annotations

import json
from math import inf, isfinite
from typing import List, NoReturn, Optional, Protocol, Sequence, Tuple

from webloop.aged import AgedFeedback, Noise
from webloop.feedback import Commands, StateFeedback
from webloop.message import Moment, Signal
from webloop.model import Matrices, Model
from webloop.pid import BACK_CALCULATION, CONDITIONAL, OFF, Gains, Limits, Pid
from webloop.query import excerpt
from webloop.smith import Smith
from webloop.transfer import Transfer

PAPER_A0 = 0.1701
"""Proportional gain of the paper's controller."""

PAPER_A1 = 0.378
"""Integral gain of the paper's controller, 1/s."""

MAX_TICKS = 1_000_000
"""The longest round trip that a Smith predictor expects, in updates."""

_PID = ("kp", "ki", "kd", "filter_rad_s", "limits")
_FIELDS = {
    "pid": _PID,
    "transfer": ("model", "limits"),
    "smith": ("pid", "model", "ticks"),
    "state-feedback": ("model", "gains", "observer", "reference", "others", "limits"),
    "aged-feedback": ("model", "gains", "reference", "others", "limits", "h_ns", "noise"),
}

_Size = Tuple[int, str]
"""How many a list has to have, and for each of what, as an error says it."""


class Law(Protocol):
    """What turns outputs into commands."""

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> Signal:
        """The command for the reference r and the newest output y, `dt_s` after
        the last; `times` says when both are, for a law that asks. Always finite,
        and never raises: only `own`'s does, which ends the run."""


class InvalidLaw(ValueError):
    """Why a law was refused. Its text names the field."""


def paper_pi() -> Pid:
    """The paper's controller at rest."""
    return Pid(Gains(PAPER_A0, PAPER_A1))


def parse_law(text: str) -> Law:
    """A law at rest, from JSON such as `{"law":"pid","kp":0.17,...}`.

    Raises `InvalidLaw`.
    """
    try:
        return _law(json.loads(text))
    except InvalidLaw:
        raise
    except (ValueError, RecursionError) as error:
        raise InvalidLaw(
            f"the law `{excerpt(text)}` is not JSON ({error});"
            ' write it like {"law":"pid","kp":0.1701,"ki":0.378,"kd":0.0,'
            '"filter_rad_s":null,"limits":null}'
        ) from None


def _law(value: object) -> Law:
    kind = value.get("law") if isinstance(value, dict) else None
    if not (isinstance(kind, str) and kind in _FIELDS):
        _refuse("law", kind, f"one of {', '.join(_FIELDS)}")
    fields = _fields("", value, ("law", *_FIELDS[kind]))[1:]
    if kind == "pid":
        return _pid("", fields)
    if kind == "transfer":
        return Transfer(_model(fields[0]), _limits("limits", fields[1], (OFF,)) or Limits())
    if kind == "smith":
        pid = _pid("pid.", _fields("pid", fields[0], _PID))
        return Smith(pid, _model(fields[1]), _ticks(fields[2]))
    if kind == "aged-feedback":
        return _aged(fields)
    return _feedback(fields)


def _pid(at: str, fields: Sequence[object]) -> Pid:
    """A PID from its fields, whose names begin with `at` in an error."""
    kp, ki, kd = (_number(at + name, value) for name, value in zip(_PID, fields[:3]))
    filter_rad_s = inf if fields[3] is None else _positive(f"{at}filter_rad_s", fields[3])
    limits = _limits(f"{at}limits", fields[4], (OFF, CONDITIONAL, BACK_CALCULATION))
    return Pid(Gains(kp, ki, kd, filter_rad_s), limits)


def _feedback(fields: Sequence[object]) -> StateFeedback:
    model, gains, observer, reference, others, limits = fields
    matrices, commands = _by_states(model, gains, reference, others, limits)
    states, outputs = len(matrices.a), (len(matrices.c), "row of `model.c`")
    rows = _list("observer", observer)
    line = len(rows) - states
    if line < outputs[0] or line % outputs[0] != 0:
        raise InvalidLaw(
            f"field `observer` has {len(rows)} rows; give {states} for the model's states and"
            f" {outputs[0]} for each tick that its outputs are on their way, at least one"
        )
    by_output = [_numbers(f"observer[{index}]", row, outputs) for index, row in enumerate(rows)]
    return StateFeedback(matrices, commands, by_output)


def _aged(fields: Sequence[object]) -> AgedFeedback:
    model, gains, reference, others, limits, h_ns, noise = fields
    matrices, commands = _by_states(model, gains, reference, others, limits)
    if isinstance(h_ns, bool) or not isinstance(h_ns, int) or h_ns < 1:
        _refuse("h_ns", h_ns, "a whole number above zero")
    covariance, drift, cross, output = _fields("noise", noise, Noise._fields)
    states, outputs = (len(matrices.a), "row of `model.a`"), (len(matrices.c), "row of `model.c`")
    numbers = Noise(
        _matrix("noise.covariance", covariance, states, states),
        _matrix("noise.drift", drift, states, states),
        _matrix("noise.cross", cross, states, outputs),
        _matrix("noise.output", output, outputs, outputs),
    )
    return AgedFeedback(matrices, commands, numbers, h_ns)


def _by_states(
    model: object, gains: object, reference: object, others: object, limits: object
) -> Tuple[Matrices, Commands]:
    """What both laws that know the plant's states have."""
    a, b, c, d = _fields("model", model, ("a", "b", "c", "d"))
    states = (len(_list("model.a", a)), "row of `model.a`")
    inputs = (_one_or_two("gains", gains, "input"), "row of `gains`")
    by_state = _matrix("gains", gains, inputs, states)
    outputs = (_one_or_two("model.c", c, "output"), "row of `model.c`")
    rest = _numbers("others", others)
    if len(rest) >= outputs[0]:
        raise InvalidLaw(
            f"field `others` has {len(rest)} numbers; give at most {outputs[0] - 1}, one for each"
            " output after the first"
        )
    matrices = Matrices(
        _matrix("model.a", a, states, states),
        _matrix("model.b", b, states, inputs),
        _matrix("model.c", c, outputs, states),
        _matrix("model.d", d, outputs, inputs),
    )
    references = (1 + len(rest), "reference, r and `others`")
    return matrices, Commands(
        by_state,
        _matrix("reference", reference, inputs, references),
        rest,
        _limits("limits", limits, (OFF,)) or Limits(),
    )


def _limits(at: str, value: object, windups: Sequence[str]) -> Optional[Limits]:
    if value is None:
        return None
    low, high, windup, gain = _fields(at, value, ("min", "max", "anti_windup", "gain_per_s"))
    least = -inf if low is None else _number(f"{at}.min", low)
    most = inf if high is None else _number(f"{at}.max", high)
    if least >= most:
        raise InvalidLaw(f"field `{at}`: from {least} to {most} is empty; give min below max")
    if not (isinstance(windup, str) and windup in windups):
        _refuse(f"{at}.anti_windup", windup, " or ".join(windups))
    if windup == BACK_CALCULATION:
        return Limits(least, most, windup, _positive(f"{at}.gain_per_s", gain))
    if gain is not None:
        _refuse(f"{at}.gain_per_s", gain, f"null where anti_windup is {windup}")
    return Limits(least, most, windup)


def _model(value: object) -> Model:
    a, b, c, d = _fields("model", value, ("a", "b", "c", "d"))
    states = (len(_list("model.a", a)), "row of `model.a`")
    return Model(
        _matrix("model.a", a, states, states),
        _numbers("model.b", b, states),
        _numbers("model.c", c, states),
        _number("model.d", d),
    )


def _ticks(value: object) -> int:
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= MAX_TICKS:
        return value
    _refuse("ticks", value, f"a whole number from 0 to {MAX_TICKS}")


def _positive(at: str, value: object) -> float:
    number = _number(at, value)
    if number > 0.0:
        return number
    _refuse(at, value, "a number above zero")


def _number(at: str, value: object) -> float:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            number = float(value)
        except OverflowError:
            number = inf
        if isfinite(number):
            return number
    _refuse(at, value, "a finite number")


def _numbers(at: str, value: object, size: Optional[_Size] = None) -> List[float]:
    values = _list(at, value, size, "numbers")
    return [_number(f"{at}[{index}]", number) for index, number in enumerate(values)]


def _matrix(at: str, value: object, rows: _Size, columns: _Size) -> List[List[float]]:
    values = _list(at, value, rows, "rows")
    return [_numbers(f"{at}[{index}]", row, columns) for index, row in enumerate(values)]


def _one_or_two(at: str, value: object, which: str) -> int:
    """How many rows there are, one for each input or output of the plant."""
    count = len(_list(at, value))
    if count in (1, 2):
        return count
    raise InvalidLaw(f"field `{at}` has {count} rows; give one or two, one for each {which}")


def _list(at: str, value: object, size: Optional[_Size] = None, what: str = "") -> List[object]:
    if not isinstance(value, list):
        _refuse(at, value, "a list")
    if size is not None and len(value) != size[0]:
        raise InvalidLaw(f"field `{at}` has {len(value)} {what}; give {size[0]}, one for each {size[1]}")
    return value


def _fields(at: str, value: object, names: Sequence[str]) -> List[object]:
    """The values of the fields `names`, in their order."""
    if not isinstance(value, dict):
        _refuse(at, value, f"an object with the fields {', '.join(names)}")
    dot = f"{at}." if at else ""
    for name in value:
        if name not in names:
            raise InvalidLaw(
                f"field `{dot}{excerpt(name)}` is unknown; there are {', '.join(names)}"
            )
    for name in names:
        if name not in value:
            raise InvalidLaw(f"field `{dot}{name}` is missing; there are {', '.join(names)}")
    return [value[name] for name in names]


def _refuse(at: str, value: object, remedy: str) -> NoReturn:
    raise InvalidLaw(f"field `{at}`: `{excerpt(json.dumps(value))}` is wrong; give {remedy}")
