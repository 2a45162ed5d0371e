"""rosbags, which reads and writes bags without ROS; an extra that is imported where it is used."""

from __future__ import annotations

from importlib.util import find_spec

from curionav_cli.errors import ConfigError


def refuse_without_rosbags() -> None:
    """Raises ConfigError where the extra is not installed."""
    if find_spec("rosbags") is None:
        raise ConfigError("Bags need rosbags, which is not installed. "
                          ".venv/bin/pip install -c constraints.txt -e '.[bags]'")
