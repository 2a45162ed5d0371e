"""Lookup of a class by the name of its file, for intrinsic rewards: another one is a file and a line in an enum."""

from __future__ import annotations

from importlib import import_module
from typing import TypeVar

T = TypeVar("T")


def one_class(package: str, name: str, base: type[T]) -> type[T]:
    """Import package.name and return the one subclass of `base` that it defines (others may be imported there)."""
    module = import_module(f"{package}.{name}")
    found = [value for value in vars(module).values() if isinstance(value, type) and issubclass(value, base)
             and value.__module__ == module.__name__]
    if len(found) != 1:
        raise TypeError(f"{module.__name__} defines {len(found)} subclasses of {base.__name__}, and not one.")
    return found[0]
