"""The schema as a source of Hydra: what it holds, where, and that each composition gets a copy of its own."""

import pytest
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError

from curionav_cli.agents.registry import AGENTS
from curionav_cli.config.schema_source import ROBOTS, Schema, converted, nodes
from curionav_cli.config.sources import opened
from curionav_cli.world.settings import Env


@pytest.fixture
def source() -> Schema:
    return Schema("curionav", "curionav://")


def test_groups_and_their_members(source: Schema) -> None:
    assert source.available() and source.is_group("schema") and source.is_group("schema/agent/")
    assert not source.is_group("schema/env") and not source.is_group("agent")
    assert source.list("", None) == ["schema"]
    assert source.list("schema", ObjectType.GROUP) == ["agent", "robot"]
    assert source.list("schema", ObjectType.CONFIG) == ["config", "env", "live", "scan"]
    assert source.list("schema/agent", ObjectType.CONFIG) == sorted(AGENTS)
    assert source.list("schema/robot", None) == sorted(ROBOTS)


def test_names_are_found_with_and_without_their_suffix(source: Schema) -> None:
    for path in ("schema/env", "schema/env.yaml", "/schema/env"):
        assert source.is_config(path)
        found = source.load_config(path)
        assert found.header == {"package": "env"} and found.config._metadata.ref_type is not None
    assert not source.is_config("schema/agent") and not source.is_config("env")
    with pytest.raises(ConfigLoadError, match="no schema/envv"):
        source.load_config("schema/envv")


def test_each_gets_a_copy(source: Schema) -> None:
    first, second = (source.load_config("schema/env").config for _ in range(2))
    first.name = "changed"
    assert second._get_node("name")._value() != "changed" and converted(Env)._get_node("name")._value() != "changed"


def test_hydra_asks_this_source_for_every_node_of_the_schema() -> None:
    with opened("explore") as hydra:
        repository = hydra.config_loader.repository
        for name in nodes():
            assert repository.load_config(name).path == "curionav://"
        assert hydra.config_loader.get_search_path().get_path()[-1].path == "structured://"
