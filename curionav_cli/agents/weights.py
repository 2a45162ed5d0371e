"""Tensors as safetensors files: nothing pickled, finished or absent, and a broken file is named."""

from __future__ import annotations

from pathlib import Path

from safetensors import SafetensorError
from safetensors.torch import load, save
from torch import Tensor, nn

from curionav_cli.errors import RunFolderError
from curionav_cli.records import write_whole

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
    content = save({name: tensor.detach().cpu().contiguous() for name, tensor in tensors.items()})
    write_whole(path, lambda file: file.write(content))


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
