"""Settings that older runs lack: such a run is read and resumed as it began."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from curionav_cli.config.compose import composed
from curionav_cli.config.settings import read_settings, settings_yaml
from curionav_cli.errors import RunFolderError
from curionav_cli.storage.checkpoint import refuse_changes
from curionav_cli.storage.older_runs import HELD

LBS = [f"{key}={value}" for key, value in HELD.items() if key.startswith("agent.")]


@pytest.mark.parametrize(("agent", "words"), [("lbs_dreamer", LBS), ("random", ["agent.options=none"])])
def test_settings_without_them_are_read_as_what_held(tmp_path: Path, agent: str, words: list[str]) -> None:
    now = composed("explore", f"agent={agent}", *words)
    plain = yaml.safe_load(settings_yaml(now))
    for word in words:
        del plain["agent"][word.partition("=")[0].removeprefix("agent.")]
    file = tmp_path / "config.yaml"
    file.write_text(yaml.safe_dump(plain))
    assert read_settings(file) == now


@pytest.mark.parametrize("key", HELD)
def test_one_that_keeps_its_value_is_no_change(tmp_path: Path, key: str) -> None:
    group, name = key.split(".")
    was = {group: {"name": "any"}}
    refuse_changes(tmp_path, was, {group: {"name": "any", name: HELD[key]}})
    with pytest.raises(RunFolderError, match=f"{key} was null, now 7"):
        refuse_changes(tmp_path, was, {group: {"name": "any", name: 7}})
