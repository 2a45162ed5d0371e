"""For comparisons with the originals: inputs drawn by us, and where the numbers that their code made of them stand."""

import math
from pathlib import Path

import numpy as np
import torch

FIXTURES = Path(__file__).parent / "fixtures"


class Draw:
    """Numbers made of PCG64's raw stream, which NumPy promises not to change."""

    def __init__(self, seed):
        self.bits = np.random.PCG64(seed)

    def uniform(self, *shape, scale=1.0):
        """float64 in [-scale, scale)"""
        raw = self.bits.random_raw(math.prod(shape)) >> np.uint64(11)
        return torch.from_numpy(scale * (raw.reshape(shape) * 2.0**-52 - 1))

    def integers(self, below, *shape):
        return torch.from_numpy((self.bits.random_raw(math.prod(shape)) % below).astype(np.int64).reshape(shape))

    def image(self, *shape):
        return self.integers(256, *shape, 64, 64, 3).to(torch.uint8)

    def fill(self, module, scale=0.5):
        """Every parameter of the module, in its order."""
        with torch.no_grad():
            for parameter in module.parameters():
                parameter.copy_(self.uniform(*parameter.shape, scale=scale))
        return module
