"""Means of scalars over many updates, read from the device once."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from curionav_cli.errors import RunFailed


class Meter:
    """Sums on the device; a name that is missing in some updates is averaged over the others.

    The sums are its own: a scalar that was added may change afterwards, as those of a CUDA graph do.
    """

    def __init__(self) -> None:
        self.sums: dict[str, Tensor] = {}
        self.counts: dict[str, int] = {}

    def add(self, scalars: dict[str, Tensor]) -> None:
        for name, value in scalars.items():
            self.sums.setdefault(name, torch.zeros_like(value))
            self.counts[name] = self.counts.get(name, 0) + 1
        torch._foreach_add_([self.sums[name] for name in scalars], list(scalars.values()))

    def read(self) -> dict[str, float]:
        """Plain floats; one wait for the device."""
        if not self.sums:
            return {}
        means = torch.stack([self.sums[name].double() / self.counts[name] for name in self.sums])
        return dict(zip(self.sums, means.tolist(), strict=True))


def finite(metrics: dict[str, float], updates: int, rate: str) -> dict[str, float]:
    """The same. Raises RunFailed where one is not finite, and names the setting `rate`; the last save is a good one."""
    broken = [name for name, value in metrics.items() if not math.isfinite(value)]
    if broken:
        raise RunFailed(f"training diverged: {', '.join(broken)} not finite after {updates} updates. "
                        f"The last checkpoint is unharmed; a lower {rate} usually helps.")
    return metrics
