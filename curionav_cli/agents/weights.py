"""Tensors as safetensors files: nothing is pickled, a file is whole or absent, and a broken one is named."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from curionav_cli.errors import RunFolderError, WeightsRefused
from curionav_cli.files import write_whole

WEIGHTS = "weights.safetensors"


def save_weights(networks: nn.Module, folder: Path) -> None:
    """Write all parameters and buffers into an existing folder."""
    write_tensors(folder / WEIGHTS, networks.state_dict())


def load_weights(networks: nn.Module, folder: Path) -> None:
    """Load what `save_weights` wrote. Raises RunFolderError where the file is missing, broken or another network's."""
    weights, own = read_tensors(folder / WEIGHTS), networks.state_dict()
    for name in sorted(own.keys() | weights.keys()):
        there, here = (tuple(side[name].shape) if name in side else None for side in (weights, own))
        if there != here:
            raise RunFolderError(
                f"{folder / WEIGHTS} does not fit this agent: {name} is {there or 'absent'} there and "
                f"{here or 'absent'} here. Use the settings (scale=..., agent....) that it was trained with.")
    networks.load_state_dict(weights)


def write_tensors(path: Path, tensors: dict[str, Tensor]) -> None:
    """Write a safetensors file, whole or not at all."""
    content = pack(tensors)
    write_whole(path, lambda file: file.write(content))


def pack(tensors: Mapping[str, Tensor]) -> bytes:
    """Return the tensors as a safetensors file; the same tensors give the same bytes."""
    return save({name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()})


def unpack(raw: bytes, own: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """Read what `pack` made of tensors of the names, shapes and types of `own`.

    Raises WeightsRefused for a broken file, for other tensors, and for numbers that are not finite.
    """
    try:
        tensors = load(raw)
    except SafetensorError as error:
        raise WeightsRefused(f"they are no whole safetensors file ({error})") from error
    for name in sorted(own.keys() | tensors.keys()):
        there, here = (describe(side, name) for side in (tensors, own))
        if there != here:
            raise WeightsRefused(f"{name} is {there} there and {here} here")
        if not tensors[name].isfinite().all():
            raise WeightsRefused(f"{name} holds numbers that are not finite")
    return tensors


def describe(tensors: Mapping[str, Tensor], name: str) -> str:
    """Type and shape of a tensor, such as 'float32 (16, 16)'; 'absent' if there is none of that name."""
    return f"{str(tensors[name].dtype)[6:]} {tuple(tensors[name].shape)}" if name in tensors else "absent"


@torch.no_grad()
def overwrite(own: Mapping[str, Tensor], values: Mapping[str, Tensor]) -> None:
    """Copy the values into the tensors of `own`, in place."""
    for name, tensor in own.items():
        tensor.copy_(values[name])


def read_tensors(path: Path) -> dict[str, Tensor]:
    """Read a safetensors file. Raises RunFolderError where it is missing or broken."""
    try:
        return load(path.read_bytes())
    except (OSError, SafetensorError) as error:
        raise RunFolderError(f"{path} cannot be read ({error}).") from error


def prefixed(name: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """Put `name/` before every key."""
    return {f"{name}/{path}": tensor for path, tensor in tensors.items()}


def below(name: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """Return the entries whose keys begin with `name/`, without that prefix."""
    prefix = f"{name}/"
    return {path.removeprefix(prefix): tensor for path, tensor in tensors.items() if path.startswith(prefix)}
