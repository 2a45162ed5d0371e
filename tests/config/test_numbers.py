"""Numbers that are typed: whole ones in any spelling, and none that no robot or machine could have."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import pytest
from entry import Cli
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf, flag_override

from curionav_cli import build
from curionav_cli.config.catalogue import flat
from curionav_cli.config.compose import plan
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import as_settings
from curionav_cli.config.sources import MAIN, opened
from curionav_cli.config.suggestions import type_of
from curionav_cli.errors import UserError
from curionav_cli.execution.progress import duration

EVERYTHING = (["agent=lbs_dreamer"], ["agent=cbet"], ["agent=sticky"], ["agent=bounce", "robot=turtlebot2i_plus"],
              ["agent=random", "env=live", "robot=rosbridge"])
BEYOND = ("1e300", "nan", "-1e9", "1e12")


@pytest.fixture(scope="module", params=EVERYTHING, ids=lambda words: words[0])
def composed(request: pytest.FixtureRequest) -> DictConfig:
    with opened("explore") as hydra:  # closed before the next test, which may open its own
        return hydra.compose_config(MAIN, request.param, RunMode.RUN)


def numbers(config: DictConfig) -> Iterator[tuple[str, bool]]:
    """Every setting that is a number, and whether it is a list of them."""
    for key, _ in flat(config):
        kind = type_of(config, key)
        parts = {kind, *get_args(kind), *(inner for part in get_args(kind) for inner in get_args(part))}
        if parts & {int, float}:
            yield key, any("list" in str(part) for part in parts)


def with_value(config: DictConfig, key: str, value: str) -> Config:
    before = OmegaConf.select(config, key)
    with flag_override(config, "readonly", False):
        try:
            OmegaConf.update(config, key, value)
            return as_settings(config)
        finally:
            OmegaConf.update(config, key, before)


def test_no_number_is_without_bounds(composed: DictConfig) -> None:
    """Each is answered in one line that names it; those of a scene when it is built."""
    seen, first = 0, composed.agent.name == "lbs_dreamer"
    for key, many in (one for one in numbers(composed) if first or one[0].startswith(("agent.", "robot."))):
        for value in () if many else BEYOND:
            with pytest.raises(Exception, match=r".") as answer:  # of OmegaConf or of the schema
                build.world(with_value(composed, key, value))
            line = str(answer.value)
            assert isinstance(answer.value, UserError) or "could not be converted" in line, (key, value, line)
            assert len(line.splitlines()[0]) < 400 and key.rpartition(".")[2] in line, (key, value, line)
            seen += 1
    assert seen


@pytest.mark.parametrize(("typed", "said"), [
    ("robot.docking.staging=9", "robot.docking.staging: 9.0 is not between 0.4 and 4"),
    ("robot.odometry.noise=1e6", "robot.odometry.noise: 1000000.0 is not between 0 and 1"),
    ("robot.scan_odometry.position=1e300", "robot.scan_odometry.position: 1e+300 is not between 0.0001 and 1"),
    ("loop.steps=1e12", "loop.steps: 1000000000000 is not between 1 and 1000000"),
])
def test_the_answer_names_the_bounds(cli: Cli, typed: str, said: str) -> None:
    answer = cli("dock", typed)
    assert (answer.code, answer.error) == (2, f"{said}\n")


def test_a_whole_number_in_any_spelling(tmp_path: Path) -> None:
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "mine.yaml").write_text("# @package _global_\nloop:\n  steps: 1e3\n  episodes: 7.0\n")
    seen: list[Config] = []
    with opened("explore", tmp_path) as hydra:
        plan(hydra, ["experiment=mine", "seed=2e0,'3e0'", "env.unknown_grey=2.05e2"], True, seen.append)
    assert [(one.loop.steps, one.loop.episodes, one.seed, one.env.unknown_grey) for one in seen] == [
        (1000, 7, 2, 205), (1000, 7, 3, 205)]
    assert all(type(one.loop.steps) is int for one in seen)


@pytest.mark.parametrize("value", ["1.5", "true", "nan", "inf", "1e300", "1e3x"])
def test_what_is_no_whole_number_stays_none(composed: DictConfig, value: str) -> None:
    with pytest.raises(Exception, match=r"could not be converted to Integer"):
        with_value(composed, "loop.steps", value)


@pytest.mark.parametrize(("seconds", "said"), [
    (0.4, "0 min 00 s"), (59.6, "1 min 00 s"), (2819.7, "47 min 00 s"), (3599.4, "59 min 59 s"),
    (3599.6, "1 h 00 min"), (7199.6, "2 h 00 min"), (11220, "3 h 07 min")])
def test_no_minute_has_sixty_seconds(seconds: float, said: str) -> None:
    assert duration(seconds) == said
