"""Spaces: Gymnasium's where it is installed, else small ones that do the same for those who ask no more of a space than
`sample`, `contains`, `seed`, `shape` and `dtype`.
"""
from __future__ import annotations

from typing import Any, Iterator, Mapping

import numpy as np

try:
    from gymnasium.spaces import Box, Dict, Discrete
    from gymnasium.vector.utils import batch_space as batched
except ImportError:

    class Space:
        """What all spaces have."""

        def __init__(self, shape: tuple[int, ...] | None, dtype: Any, seed: int | None) -> None:
            self.shape, self.dtype = shape, None if dtype is None else np.dtype(dtype)
            self.seed(seed)

        def seed(self, seed: int | None = None) -> Any:
            self._random = np.random.default_rng(seed)
            return seed

        def contains(self, x: Any) -> bool:
            raise NotImplementedError

        def __contains__(self, x: Any) -> bool:
            return self.contains(x)

    class Box(Space):
        """Arrays between two bounds, which may be infinite."""

        def __init__(self, low: Any, high: Any, shape: tuple[int, ...] | None = None, dtype: Any = np.float32,
                     seed: int | None = None) -> None:
            shape = np.broadcast_shapes(np.shape(low), np.shape(high)) if shape is None else tuple(shape)
            super().__init__(shape, dtype, seed)
            self.low = np.full(shape, low).astype(dtype)
            self.high = np.full(shape, high).astype(dtype)

        def sample(self) -> np.ndarray:
            if self.dtype.kind in "iu":
                return self._random.integers(self.low, self.high, endpoint=True, dtype=self.dtype)
            if np.all(np.isfinite(self.low) & np.isfinite(self.high)):
                return self._random.uniform(self.low, self.high).astype(self.dtype)
            return np.clip(self._random.normal(size=self.shape), self.low, self.high).astype(self.dtype)

        def contains(self, x: Any) -> bool:
            return (isinstance(x, np.ndarray) and x.shape == self.shape and np.can_cast(x.dtype, self.dtype)
                    and bool(np.all(x >= self.low) and np.all(x <= self.high)))

        def __eq__(self, other: Any) -> bool:
            return (isinstance(other, Box) and self.shape == other.shape and self.dtype == other.dtype
                    and np.array_equal(self.low, other.low) and np.array_equal(self.high, other.high))

        def __repr__(self) -> str:
            return f"Box({self.low.min()}, {self.high.max()}, {self.shape}, {self.dtype})"

    class Discrete(Space):
        """0, 1, ..., n - 1."""

        def __init__(self, n: int, seed: int | None = None) -> None:
            super().__init__((), np.int64, seed)
            self.n = n

        def sample(self) -> np.int64:
            return np.int64(self._random.integers(self.n))

        def contains(self, x: Any) -> bool:
            whole = isinstance(x, (int, np.integer)) or isinstance(x, np.ndarray) and x.shape == () and x.dtype.kind in "iu"
            return whole and 0 <= int(x) < self.n

        def __eq__(self, other: Any) -> bool:
            return isinstance(other, Discrete) and self.n == other.n

        def __repr__(self) -> str:
            return f"Discrete({self.n})"

    class Dict(Space):
        """Spaces by name."""

        def __init__(self, spaces: Mapping[str, Any], seed: int | None = None) -> None:
            self.spaces = dict(spaces)
            super().__init__(None, None, seed)

        def seed(self, seed: int | None = None) -> Any:
            for place, space in enumerate(self.spaces.values()):
                space.seed(None if seed is None else seed + place)
            return seed

        def sample(self) -> dict[str, Any]:
            return {name: space.sample() for name, space in self.spaces.items()}

        def contains(self, x: Any) -> bool:
            return (isinstance(x, dict) and x.keys() == self.spaces.keys()
                    and all(space.contains(x[name]) for name, space in self.spaces.items()))

        def __getitem__(self, name: str) -> Any:
            return self.spaces[name]

        def __iter__(self) -> Iterator[str]:
            return iter(self.spaces)

        def __eq__(self, other: Any) -> bool:
            return isinstance(other, Dict) and self.spaces == other.spaces

        def __repr__(self) -> str:
            return f"Dict({self.spaces})"

    def batched(space: Any, count: int) -> Any:
        """The space of `count` samples together."""
        if isinstance(space, Dict):
            return Dict({name: batched(part, count) for name, part in space.spaces.items()})
        if isinstance(space, Discrete):
            return Box(0, space.n - 1, (count,), np.int64)
        return Box(np.repeat(space.low[None], count, 0), np.repeat(space.high[None], count, 0), dtype=space.dtype)


def stacked(space: Any, samples: list[Any]) -> Any:
    """The sample of the batched space that these samples make."""
    if isinstance(space, Dict):
        return {name: stacked(part, [sample[name] for sample in samples]) for name, part in space.spaces.items()}
    return np.stack(samples)
