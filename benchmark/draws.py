"""Random numbers by counter: the same key gives the same bits, on each machine and in each version of numpy.

The key is a text such as "boards 12 noise". Raw words come from Philox, whose definition is fixed; all distributions
are made from them here, because numpy may change its own.
"""
import hashlib
import math

import numpy as np


class Draw:
    def __init__(self, *key):
        self.key = " ".join(str(part) for part in key)
        digest = hashlib.sha256(self.key.encode()).digest()
        self._bits = np.random.Philox(key=int.from_bytes(digest[:16], "little"))

    def of(self, name):
        """An independent stream for one purpose: a further draw there moves no number elsewhere."""
        return Draw(self.key, name)

    def _unit(self, count):
        words = self._bits.random_raw(count)
        return (np.asarray(words, dtype=np.uint64) >> np.uint64(11)).astype(float) * 2.0 ** -53

    def uniform(self, low=0.0, high=1.0, size=None):
        values = low + (high - low) * self._unit(1 if size is None else int(np.prod(size)))
        return float(values[0]) if size is None else values.reshape(size)

    def normal(self, sigma=1.0, size=None):
        """By Box and Muller."""
        count = 1 if size is None else int(np.prod(size))
        radius = np.sqrt(-2 * np.log(1 - self._unit(count)))
        values = sigma * radius * np.cos(2 * math.pi * self._unit(count))
        return float(values[0]) if size is None else values.reshape(size)

    def log_uniform(self, low, high):
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def integer(self, low, high):
        """From low to high, both included."""
        return low + int(self._unit(1)[0] * (high - low + 1))

    def choice(self, options):
        return options[self.integer(0, len(options) - 1)]

    def sample(self, options, count):
        """Some of the options, none twice."""
        left = list(options)
        return [left.pop(self.integer(0, len(left) - 1)) for _ in range(min(count, len(left)))]

    def signed(self, low, high):
        """A size between two limits, of either sign."""
        return self.choice((-1, 1)) * self.uniform(low, high)

    def chance(self, share):
        return self.uniform() < share

    def poisson(self, mean):
        """Knuth's products where the mean is small, else the normal law with its skewness (Cornish and Fisher)."""
        mean = np.maximum(np.asarray(mean, dtype=float), 0)
        z = self.normal(size=mean.shape)
        counts = np.maximum(np.rint(mean + np.sqrt(mean) * z + (z * z - 1) / 6), 0)
        small = mean < 60
        if np.any(small):
            limit = np.exp(-mean[small])
            product, events = self._unit(limit.size), np.zeros(limit.size)
            running = product > limit
            while np.any(running):
                events[running] += 1
                product = product * self._unit(limit.size)
                running &= product > limit
            counts[small] = events
        return counts

    def wander(self, times, sigma, tau):
        """An Ornstein-Uhlenbeck process at increasing times."""
        z = self.normal(size=len(times))
        values = np.empty(len(times))
        for k, t in enumerate(times):
            keep = math.exp(-(t - times[k - 1]) / tau) if k else 0.0
            values[k] = (keep * values[k - 1] if k else 0.0) + sigma * math.sqrt(1 - keep * keep) * z[k]
        return values
