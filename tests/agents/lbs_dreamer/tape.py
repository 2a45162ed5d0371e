"""What a CUDA graph does, on a CPU: kernels are recorded as they run, and run again on the same memory.

Python runs once. A question to the device, or a shape that depends on data, is an error as it is there.
"""

import torch
from torch.utils._python_dispatch import TorchDispatchMode
from torch.utils._pytree import tree_leaves

QUESTIONS = {"_local_scalar_dense", "nonzero", "masked_select", "_unique2", "equal", "is_nonzero", "bincount"}


class Tape(TorchDispatchMode):
    """with Tape() as tape: ... then tape.play()"""

    def __init__(self):
        super().__init__()
        self.kernels = []

    def __torch_dispatch__(self, function, types, args=(), kwargs=None):
        name = function.overloadpacket.__name__
        assert name not in QUESTIONS, f"{name}: the host waits for the device"
        out = function(*args, **(kwargs or {}))
        given, made = tensors((args, kwargs)), tensors(out)
        changes = function._schema.is_mutable
        if changes or not memory(made) <= memory(given):  # a view is no kernel
            self.kernels.append((function, args, kwargs or {}, [] if changes else made))
        return out

    def play(self):
        for function, args, kwargs, made in self.kernels:
            again = tensors(function(*args, **kwargs))
            for old, new in zip(made, again if made else [], strict=True):
                old.copy_(new)


def tensors(tree):
    return [leaf for leaf in tree_leaves(tree) if isinstance(leaf, torch.Tensor)]


def memory(found):
    return {tensor.untyped_storage().data_ptr() for tensor in found}


def tape(function, state):
    """Stands in for cuda_graphs.cuda_graph."""
    before = [tensor.clone() for tensor in state]
    function()
    with Tape() as recorded:
        outputs = function()
    with torch.no_grad():
        for tensor, value in zip(state, before, strict=True):
            tensor.copy_(value)

    @torch.inference_mode()
    def play():
        recorded.play()

    return play, outputs
