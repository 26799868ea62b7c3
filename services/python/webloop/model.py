"""A sampled model as matrices: x' = A x + B u, y = C x + D u.

A port of the crate `control`'s `Stepper`. Sums run from left to right and from
0, as its do; `sum` of a newer Python rounds otherwise. The state is kept by
whoever steps, who may then look at a step before it is taken.
"""

from __future__ import annotations

from math import isfinite
from typing import List, NamedTuple, Sequence, Tuple


class Model(NamedTuple):
    """A, B, C and D of a system with n states, one input and one output: n by n,
    n, n and a number."""

    a: Sequence[Sequence[float]]
    b: Sequence[float]
    c: Sequence[float]
    d: float

    def at_rest(self) -> List[float]:
        """The state of a model that nothing has happened to."""
        return [0.0] * len(self.b)

    def step(self, x: Sequence[float], u: float) -> Tuple[float, List[float]]:
        """One tick from the state `x` with input `u`: the output of the same
        tick, and the next state."""
        y = dot(self.c, x) + self.d * u
        return y, [dot(row, x) + b * u for row, b in zip(self.a, self.b)]


class Matrices(NamedTuple):
    """A, B, C and D of a system with n states, m inputs and p outputs, as rows:
    n by n, n by m, p by n and p by m."""

    a: Sequence[Sequence[float]]
    b: Sequence[Sequence[float]]
    c: Sequence[Sequence[float]]
    d: Sequence[Sequence[float]]


def dot(left: Sequence[float], right: Sequence[float], total: float = 0.0) -> float:
    """The sum of the products, added to `total` one after the other."""
    for a, b in zip(left, right):
        total += a * b
    return total


def all_finite(values: Sequence[float]) -> bool:
    """Whether every one is a finite number."""
    return all(map(isfinite, values))
