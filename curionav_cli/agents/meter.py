"""Means of scalars over many updates, read from the device once."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from curionav_cli.errors import RunFailed


class Meter:
    """Sums scalars on the device; a name that is missing in some updates is averaged over the others.

    `add` copies: a scalar may be overwritten afterwards, as the outputs of a CUDA graph are.
    """

    def __init__(self) -> None:
        self.sums: dict[str, Tensor] = {}
        self.counts: dict[str, int] = {}

    def add(self, scalars: dict[str, Tensor]) -> None:
        """Add the scalars (each of shape ()) of one update."""
        for name, value in scalars.items():
            self.sums.setdefault(name, torch.zeros_like(value))
            self.counts[name] = self.counts.get(name, 0) + 1
        torch._foreach_add_([self.sums[name] for name in scalars], list(scalars.values()))

    def read(self) -> dict[str, float]:
        """Return the means as floats; waits for the device once."""
        if not self.sums:
            return {}
        means = torch.stack([self.sums[name].double() / self.counts[name] for name in self.sums])
        return dict(zip(self.sums, means.tolist(), strict=True))


def finite(metrics: dict[str, float], updates: int, rate: str) -> dict[str, float]:
    """Return the metrics. Raises RunFailed, which names the setting `rate`, where one of them is not finite."""
    broken = [name for name, value in metrics.items() if not math.isfinite(value)]
    if broken:
        raise RunFailed(f"training diverged: {', '.join(broken)} not finite after {updates} updates. "
                        f"The last checkpoint is unharmed; a lower {rate} usually helps.")
    return metrics
