"""Expressions over truth and logged values, in the language of `seam replay find --when` and of models' formulas.

    -abs(truth.r0.pan_rad - 0.5)
    truth.r0.ball_distance_m < 0.3 && r0.area_px.age_s > 1

What reads a value that is not there yet is not a number. tests/gym_test.py compares them with `seam replay find`.
"""
from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping

import numpy as np

_TOKEN = re.compile(r"\s*(?:(?P<number>\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_][\w.]*)|"
                    r"(?P<sign>&&|\|\||[=!<>]=|[-+*/^<>(),?:]))")
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    **{name: (1, getattr(np, name)) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "floor", "tanh", "abs", "sign")},
    "asin": (1, np.arcsin), "acos": (1, np.arccos), "atan": (1, np.arctan), "atan2": (2, np.arctan2), "ln": (1, np.log),
    "pow": (2, np.power), "round": (1, lambda x: np.floor(x + 0.5)), "if": (3, lambda a, b, c: b if a else c), "min": (0, min), "max": (0, max)}
# By rising strength; each level is read from the left.
_LEVELS: tuple[dict[str, Callable[[float, float], float]], ...] = (
    {"||": lambda a, b: a != 0 or b != 0}, {"&&": lambda a, b: a != 0 and b != 0},
    {"==": lambda a, b: a == b, "!=": lambda a, b: a != b, "<": lambda a, b: a < b, ">": lambda a, b: a > b, "<=": lambda a, b: a <= b,
     ">=": lambda a, b: a >= b},
    {"+": lambda a, b: a + b, "-": lambda a, b: a - b}, {"*": lambda a, b: a * b, "/": lambda a, b: a / b})

_Node = Callable[[Mapping[str, float]], float]


class Expression:
    """`names` are those that it reads."""

    def __init__(self, text: str) -> None:
        self.text, self.names = text, set()
        self._tokens = self._split(text)
        self._value = self._choice()
        if self._tokens[-1] is not None:
            raise self._fault()

    def __call__(self, values: Mapping[str, float]) -> float:
        if any(name not in values for name in self.names):
            return math.nan
        with np.errstate(all="ignore"):  # A root of something negative, a division by zero: as IEEE has them.
            return float(self._value(values))

    # ---- Reading: the next token is the last of the list ----

    def _split(self, text: str) -> list[tuple[str, str] | None]:
        tokens, at = [], 0
        while text[at:].strip():
            found = _TOKEN.match(text, at)
            if not found:
                raise ValueError(f"{text!r}: found {text[at:].strip()[:10]!r}, expected a number, a name or an operator")
            tokens.append((found.lastgroup, found[found.lastgroup]))
            at = found.end()
        return [None, *reversed(tokens)]

    def _fault(self) -> ValueError:
        token = self._tokens[-1]
        return ValueError(f"{self.text!r}: found {'the end' if token is None else repr(token[1])}, expected an expression such as "
                          "'truth.r0.x_m > 1 && time_s > 5'")

    def _takes(self, sign: str) -> bool:
        if self._tokens[-1] != ("sign", sign):
            return False
        self._tokens.pop()
        return True

    def _need(self, sign: str) -> None:
        if not self._takes(sign):
            raise self._fault()

    def _choice(self) -> _Node:
        condition = self._operation(0)
        if not self._takes("?"):
            return condition
        first = self._choice()
        self._need(":")
        second = self._choice()
        return lambda values: first(values) if condition(values) else second(values)

    def _operation(self, level: int) -> _Node:
        if level == len(_LEVELS):
            return self._signed()
        left = self._operation(level + 1)
        while (token := self._tokens[-1]) is not None and token[0] == "sign" and token[1] in _LEVELS[level]:
            self._tokens.pop()
            left = self._joined(_LEVELS[level][token[1]], left, self._operation(level + 1))
        return left

    @staticmethod
    def _joined(action: Callable[[float, float], float], left: _Node, right: _Node) -> _Node:
        return lambda values: action(left(values), right(values))

    def _signed(self) -> _Node:
        if self._takes("-"):
            value = self._signed()
            return lambda values: -value(values)
        if self._takes("+"):
            return self._signed()
        base = self._operand()
        return self._joined(lambda a, b: a ** b, base, self._signed()) if self._takes("^") else base

    def _operand(self) -> _Node:
        if self._takes("("):
            value = self._choice()
            self._need(")")
            return value
        kind, text = self._tokens.pop() or (None, "")
        if kind == "number":
            number = np.float64(text)
            return lambda values: number
        if kind == "name" and self._takes("("):
            return self._call(text)
        if kind == "name" and text == "pi":
            return lambda values: math.pi
        if kind == "name":
            self.names.add(text)
            return lambda values: np.float64(values[text])
        self._tokens.append((kind, text) if kind else None)
        raise self._fault()

    def _call(self, name: str) -> _Node:
        if name not in _FUNCTIONS:
            raise ValueError(f"{self.text!r}: no function {name!r}, expected one of: {' '.join(sorted(_FUNCTIONS))}")
        count, function = _FUNCTIONS[name]
        parts = [self._choice()]
        while self._takes(","):
            parts.append(self._choice())
        self._need(")")
        if count and len(parts) != count:
            raise ValueError(f"{self.text!r}: {name} has {len(parts)} arguments, expected {count}")
        return lambda values: function(*(part(values) for part in parts))
