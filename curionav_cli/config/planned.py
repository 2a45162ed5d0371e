"""How many runs a sweep is of, from what Hydra noted in its folder."""

from __future__ import annotations

import math
from pathlib import Path

import yaml
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

from curionav_cli.config.search import NOTE, noted


def planned_runs(folder: Path) -> int | None:
    """The number of runs of the sweep in `folder`; None where it is no sweep, or its note cannot be read."""
    if trials := noted(folder).get("n_trials"):
        return int(trials)
    try:
        hydra = yaml.safe_load((folder / NOTE).read_text())["hydra"]
        params = [f"{key}={value}" for key, value in (hydra["sweeper"].get("params") or {}).items()]
        overrides = OverridesParser.create().parse_overrides([*hydra["overrides"]["task"], *params])
        return math.prod(len(list(one.sweep_string_iterator())) for one in overrides if one.is_discrete_sweep())
    except (OSError, yaml.YAMLError, HydraException, LookupError, TypeError, ValueError):
        return None
