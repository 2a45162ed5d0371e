"""YAML: the fast loader, and a check for aliases of aliases, by which a few lines become gigabytes."""

from __future__ import annotations

import yaml

NODES, DEPTH = 10**6, 100  # limits for a YAML file with its aliases written out
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # ten times as fast, where libyaml is installed


def refuse_bomb(text: str, first_only: bool = False) -> None:
    """Raises ValueError where YAML with its aliases written out has more than NODES nodes or DEPTH levels.

    first_only: check the first document only, for readers that read no other.
    """
    sizes: dict[str, int] = {}
    open_nodes: list[tuple[str | None, int]] = [(None, 0)]
    for event in yaml.parse(text, LOADER):
        if first_only and isinstance(event, yaml.DocumentEndEvent):
            return
        anchor, size = getattr(event, "anchor", None), 1
        if isinstance(event, yaml.MappingStartEvent | yaml.SequenceStartEvent):
            open_nodes.append((anchor, 0))
            size = 0
        elif isinstance(event, yaml.MappingEndEvent | yaml.SequenceEndEvent):
            anchor, size = open_nodes.pop()
        elif isinstance(event, yaml.AliasEvent):
            anchor, size = None, sizes.get(str(event.anchor), NODES)
        if anchor:
            sizes[anchor] = size
        outer, so_far = open_nodes[-1]
        open_nodes[-1] = (outer, so_far + size + 1)
        if so_far + size > NODES or len(open_nodes) > DEPTH:
            raise ValueError(f"it unfolds into more than {NODES} parts, or is deeper than {DEPTH}")
