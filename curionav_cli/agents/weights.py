"""Tensors as safetensors files: nothing pickled, finished or absent, and a broken file is named."""

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
    """All parameters and buffers, into an existing folder."""
    write_tensors(folder / WEIGHTS, networks.state_dict())


def load_weights(networks: nn.Module, folder: Path) -> None:
    """Raises RunFolderError where the file is missing or broken, or holds another network's weights."""
    weights, own = read_tensors(folder / WEIGHTS), networks.state_dict()
    for name in sorted(own.keys() | weights.keys()):
        there, here = (tuple(side[name].shape) if name in side else None for side in (weights, own))
        if there != here:
            raise RunFolderError(
                f"{folder / WEIGHTS} does not fit this agent: {name} is {there or 'absent'} there and "
                f"{here or 'absent'} here. Use the settings (scale=..., agent....) that it was trained with.")
    networks.load_state_dict(weights)


def write_tensors(path: Path, tensors: dict[str, Tensor]) -> None:
    content = pack(tensors)
    write_whole(path, lambda file: file.write(content))


def pack(tensors: Mapping[str, Tensor]) -> bytes:
    """A safetensors file, the same bytes for the same tensors."""
    return save({name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()})


def unpack(raw: bytes, own: Mapping[str, Tensor]) -> dict[str, Tensor]:
    """What `pack` made of tensors such as `own`. Raises WeightsRefused for others, and for what is not finite."""
    try:
        tensors = load(raw)
    except SafetensorError as error:
        raise WeightsRefused(f"they are no whole safetensors file ({error})") from error
    for name in sorted(own.keys() | tensors.keys()):
        there, here = (described(side, name) for side in (tensors, own))
        if there != here:
            raise WeightsRefused(f"{name} is {there} there and {here} here")
        if not tensors[name].isfinite().all():
            raise WeightsRefused(f"{name} holds numbers that are not finite")
    return tensors


def described(tensors: Mapping[str, Tensor], name: str) -> str:
    """'float32 (16, 16)', or 'absent'."""
    return f"{str(tensors[name].dtype)[6:]} {tuple(tensors[name].shape)}" if name in tensors else "absent"


@torch.no_grad()
def put(own: Mapping[str, Tensor], values: Mapping[str, Tensor]) -> None:
    """Write over `own`, in place."""
    for name, tensor in own.items():
        tensor.copy_(values[name])


def read_tensors(path: Path) -> dict[str, Tensor]:
    """Raises RunFolderError where the file is missing or broken."""
    try:
        return load(path.read_bytes())
    except (OSError, SafetensorError) as error:
        raise RunFolderError(f"{path} cannot be read ({error}).") from error


def prefixed(name: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """{'a': ...} -> {'name/a': ...}"""
    return {f"{name}/{path}": tensor for path, tensor in tensors.items()}


def below(name: str, tensors: dict[str, Tensor]) -> dict[str, Tensor]:
    """What `prefixed` put under this name, without it."""
    prefix = f"{name}/"
    return {path.removeprefix(prefix): tensor for path, tensor in tensors.items() if path.startswith(prefix)}
