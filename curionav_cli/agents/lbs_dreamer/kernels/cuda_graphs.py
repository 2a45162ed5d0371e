"""An update as one CUDA graph: it has thousands of small kernels, which take longer to launch than to run.

A graph repeats the kernels that a function launched while it was recorded, on the same addresses. So the function must
turn tensors into tensors of fixed shapes without waiting for a value; random numbers, counters and decisions stay
outside and come in as tensors. Inputs are copied to where the graph reads them; outputs stay where it wrote them, until
it runs again.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import torch
from torch import Tensor

from curionav_cli.errors import RunFailed

WARM_UP = 3  # runs before recording, in which libraries choose their kernels and take their memory

Outputs = dict[str, Tensor]
Run = tuple[Callable[[], None], Outputs]  # repeats the function; the tensors that it writes
Capture = Callable[[Callable[[], Outputs], list[Tensor]], Run]
Record = Callable[[Callable[..., Outputs], list[Tensor]], Callable[..., Outputs]]


def as_it_is(function: Callable[..., Outputs], state: list[Tensor]) -> Callable[..., Outputs]:
    """Return the function itself: no graph."""
    return function


class Recorded:
    """A function of named tuples of tensors, recorded when it is first called and repeated from then on.

    state: the tensors that the function changes in place; recording leaves them as they were. The outputs are the same
    tensors at every call: read or add them up before the next. The first call raises RunFailed where the function
    cannot be recorded.
    """

    def __init__(self, capture: Capture, device: torch.device, function: Callable[..., Outputs],
                 state: list[Tensor]):
        self.capture, self.device, self.function, self.state = capture, device, function, state
        self.inputs: list[Any] = []
        self.run: Run | None = None

    def __call__(self, *inputs: Any) -> Outputs:
        if self.run is None:
            self.inputs = [self._empty_like(given) for given in inputs]
        for own, given in zip(self.inputs, inputs, strict=True):
            fill(own, given)
        if self.run is None:
            try:
                self.run = self.capture(partial(self.function, *self.inputs), self.state)
            except RuntimeError as error:
                raise RunFailed(f"It could not be recorded as a CUDA graph: {str(error).splitlines()[0]} "
                                "compile=graph does without torch.compile, compile=none without graphs.") from error
        repeat, outputs = self.run
        repeat()
        return outputs

    def _empty_like(self, given: Any) -> Any:
        """Uninitialised memory on the device for a named tuple like this one."""
        return type(given)(*(None if tensor is None else torch.empty_like(tensor, device=self.device)
                             for tensor in given))


def fill(own: Any, given: Any) -> None:
    """Copy a named tuple of tensors into one of the same shapes and kinds."""
    for target, source in zip(own, given, strict=True):
        if source is not None:
            assert target.shape == source.shape and target.dtype == source.dtype, (target.shape, source.shape)
            target.copy_(source, non_blocking=True)


def cuda_graph(function: Callable[[], Outputs], state: list[Tensor]) -> Run:
    """Record `function` on a stream of its own; `state` is restored after warming up."""
    before = [tensor.clone() for tensor in state]
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.stream(stream):
        for _ in range(WARM_UP):
            function()
    torch.cuda.synchronize()
    graph = torch.cuda.CUDAGraph()
    with torch.cuda.graph(graph, stream=stream):  # computes nothing
        outputs = function()
    with torch.no_grad():
        for tensor, value in zip(state, before, strict=True):
            tensor.copy_(value)
    return graph.replay, outputs
