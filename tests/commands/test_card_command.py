"""curionav card and init=...: a trained agent is written to a folder, and evaluate, explore and train begin with it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml
from entry import Cli
from tiny import LEARNER

from curionav_cli.config.compose import composed
from curionav_cli.execution.exploration import explore

WEIGHTS = "weights.safetensors"
pytestmark = pytest.mark.usefixtures("blank_figures")
SHORT = ("loop.steps=12", "loop.iterations=1", "loop.episodes=1")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run that has learned, and one that has not, of an episode each."""
    folder = tmp_path_factory.mktemp("runs")
    learner = {word.partition("=")[0]: word for word in (*LEARNER, "loop.episodes=1", "loop.iterations=1", "seed=5")}
    explore(composed("explore", *learner.values()), folder / "trained")
    explore(composed("explore", "agent=bounce", *SHORT), folder / "bounce", drawn=False)
    return folder


@pytest.fixture
def card(cli: Cli, runs: Path, tmp_path: Path) -> Path:
    """A card of the run that has learned."""
    answer = cli("card", f"{runs}/trained", "out=card", "licence=apache-2.0")
    assert answer.code == 0, answer.error
    return tmp_path / "card"


def first_weights(run: Path) -> bytes:
    return (run / "checkpoint" / "000001" / WEIGHTS).read_bytes()


def test_a_card_holds_what_its_page_says(card: Path, runs: Path) -> None:
    assert {path.name for path in card.iterdir()} == {"README.md", "card.json", "config.yaml", "figures",
                                                      "metrics.jsonl", WEIGHTS}
    assert (card / WEIGHTS).read_bytes() == first_weights(runs / "trained")
    text = (card / "README.md").read_text()
    assert text.startswith("---\nlibrary_name: curionav\nlicense: apache-2.0\n")
    for said in ("lbs_dreamer, trained in small_room", "| training | 1 episode of 12 steps in all |",
                 "visitable cells", "(figures/heatmap.png)", "curionav evaluate FOLDER"):
        assert said in text
    assert str(runs) not in text + (card / "config.yaml").read_text() + (card / "card.json").read_text()


def test_evaluate_opens_a_card_and_a_card_shows_evaluations(cli: Cli, card: Path, runs: Path, tmp_path: Path) -> None:
    answer = cli("evaluate", "card", "env=apartment_1", "loop.episodes=1", "hydra.run.dir=evaluated")
    assert answer.code == 0, answer.error
    assert first_weights(tmp_path / "evaluated") == (card / WEIGHTS).read_bytes()
    assert json.loads((tmp_path / "evaluated" / "fixed.json").read_text())["trained"] == {
        "env": "small_room", "episodes": 1}
    assert cli("card", f"{runs}/trained", "evaluated", "out=more").code == 0
    text = (tmp_path / "more" / "README.md").read_text()
    assert "| apartment_1 | lbs_dreamer | small_room | 1 episodes | 5 | 0 |" in text
    assert (tmp_path / "more" / "figures" / "evaluated_heatmap.png").is_file()
    assert "None was chosen" in text


def test_a_run_begins_with_the_weights_and_is_resumed_without_the_card(cli: Cli, card: Path, tmp_path: Path) -> None:
    """Without learning the weights of a run with another seed stay those of the card."""
    words = ("init=card", "env=apartment_1", "loop.steps=12", "loop.iterations=0", "loop.episodes=1", "seed=1")
    answer = cli("explore", *words, "hydra.run.dir=on")
    assert answer.code == 0, answer.error
    assert first_weights(tmp_path / "on") == (card / WEIGHTS).read_bytes()
    settings = yaml.safe_load((tmp_path / "on" / "config.yaml").read_text())
    assert settings["agent"]["gru_units"] == 16 and settings["init"] == str(card)
    card.rename(tmp_path / "away")
    answer = cli("resume", "on", "loop.episodes=2")
    assert answer.code == 0, answer.error
    assert (tmp_path / "on" / "episodes" / "000001.npz").is_file()


def test_a_resumed_run_equals_one_in_one_go(cli: Cli, card: Path, tmp_path: Path) -> None:
    words = ("init=card", "loop.steps=12", "loop.iterations=2", "agent.actor_lr=1e-3")
    for name, episodes in (("whole", 2), ("parts", 1)):
        assert cli("explore", *words, f"loop.episodes={episodes}", f"hydra.run.dir={name}").code == 0
    assert cli("resume", "parts", "loop.episodes=2").code == 0
    for path in (f"checkpoint/000002/{WEIGHTS}", "checkpoint/000002/training.safetensors", "episodes/000001.npz"):
        assert (tmp_path / "whole" / path).read_bytes() == (tmp_path / "parts" / path).read_bytes()
    assert first_weights(tmp_path / "whole") != (card / WEIGHTS).read_bytes()


def test_offline_training_begins_with_the_weights_and_has_a_card(cli: Cli, card: Path, runs: Path,
                                                                tmp_path: Path) -> None:
    for name, more in (("taken", ("init=card",)), ("fresh", LEARNER[1:])):
        words = {word.partition("=")[0]: word for word in (*more, f"data={runs}/trained", "loop.iterations=1",
                                                            f"hydra.run.dir={name}")}
        assert cli("train", *words.values()).code == 0
    taken, fresh = (first_weights(tmp_path / name) for name in ("taken", "fresh"))
    assert taken != fresh
    assert cli("card", "taken").code == 0
    text = (tmp_path / "taken" / "card" / "README.md").read_text()
    assert "| training | 1 iteration on stored episodes |" in text and "covered" not in text


def test_a_pretrained_agent_has_a_name(cli: Cli, card: Path, runs: Path, tmp_path: Path,
                                       monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    answer = cli("evaluate", "pretrained=apartments")
    assert answer.code == 2 and len(answer.error.splitlines()) == 1
    assert answer.error.endswith("Make it in a checkout: make pretrained.\n")
    assert cli("card", f"{runs}/trained", "pretrained=flat").code == 0
    answer = cli("evaluate", "pretrained=flat", "loop.episodes=1", "hydra.run.dir=evaluated")
    assert answer.code == 0, answer.error
    assert first_weights(tmp_path / "evaluated") == (card / WEIGHTS).read_bytes()
    assert "There is flat." in cli("explore", "pretrained=flut").error


def test_what_belongs_to_a_machine_is_left_out(cli: Cli, runs: Path, a_map: str, tmp_path: Path) -> None:
    assert cli("explore", f"init={runs}/trained", "env=map", f"env.map={a_map}", *SHORT, "hydra.run.dir=run").code == 0
    assert cli("card", "run").code == 0
    settings = yaml.safe_load((tmp_path / "run" / "card" / "config.yaml").read_text())
    assert (settings["env"]["map"], settings["init"], settings["data"]) == (Path(a_map).name, None, None)
    answer = cli("evaluate", "run/card")
    assert answer.code == 2 and f"There is no map {tmp_path}/{Path(a_map).name}" in answer.error


def test_mistakes_are_answered_in_one_line(cli: Cli, card: Path, runs: Path) -> None:
    for words, said in (
        (["card"], "Name the folder of a run that has learned"), (["card", "nowhere"], "There is no folder nowhere"),
        (["card", f"{runs}/bounce"], "agent=bounce has no weights, so there is nothing to take along"),
        (["card", "card"], "card is a card already"),
        (["card", f"{runs}/trained", "out=card"], "card exists already"),
        (["card", f"{runs}/trained", "licence=a b"], "licence=a b is no name"),
        (["card", f"{runs}/trained", "out=new", "pretrained=new"], "name the folder twice"),
        (["card", f"{runs}/trained", f"{runs}/bounce", "out=new"], "is no evaluation of these weights"),
        (["explore", "init=nowhere", *SHORT], "There is no folder nowhere"),
        (["explore", "init=card", "agent=bounce", *SHORT], "does not learn, so it has no weights to take from"),
        (["explore", "init=card", "agent.gru_units=8", *SHORT], "does not fit this agent"),
        (["explore", "init=card", "pretrained=flat"], "there is no such agent"),
        (["explore", "init=card", "learner=remote", "storage=file:///tmp/none", *SHORT], "learning in one process"),
    ):
        answer = cli(*words)
        assert answer.code == 2 and said in answer.error, (words, answer)
        assert len(answer.error.strip().splitlines()) == 1, answer


def test_a_damaged_card_is_named(cli: Cli, card: Path) -> None:
    whole = (card / WEIGHTS).read_bytes()
    (card / WEIGHTS).write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    answer = cli("explore", "init=card", *SHORT)
    assert answer.code == 2 and "weights.safetensors is not whole (its checksum is another one)" in answer.error
    (card / WEIGHTS).unlink()
    answer = cli("evaluate", "card")
    assert answer.code == 2 and "weights.safetensors cannot be read (No such file or directory)" in answer.error
