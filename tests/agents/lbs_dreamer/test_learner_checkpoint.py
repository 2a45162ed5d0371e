"""A saved agent goes on to the same bytes; files that are broken or another agent's are refused."""

import json
import subprocess
import sys

import pytest
from traces import fingerprint, ignore, walk

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer
from curionav_cli.errors import RunFolderError


def test_a_resumed_agent_is_the_same_to_the_bit(agent, replay, tmp_path):
    straight, store = agent(), replay()
    straight.learn(store, 3, ignore)
    straight.save(tmp_path)
    resumed = agent()
    resumed.learn(store, 1, ignore)
    resumed.load(tmp_path)
    assert fingerprint(resumed) == fingerprint(straight)
    for made in (straight, resumed):
        walk(made, store.episode(0))
        made.learn(store, 3, ignore)
    assert fingerprint(resumed) == fingerprint(straight)
    assert walk(resumed, store.episode(1)) == walk(straight, store.episode(1))


FRESH = """
from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
import sys
from pathlib import Path
import torch
from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer

from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay
import json
torch.set_num_threads(1)
for folder in map(Path, sys.argv[1:]):
    numbers = json.loads((folder / "hyper.json").read_text())
    kinds = {"precision": lbs_settings.Precision, "curiosity": lbs_settings.Curiosity,
             "options": lbs_settings.OptionSet, "behaviour": lbs_settings.BehaviourKind}
    hyper = lbs_settings.LBSDreamer(**{**numbers, **{key: kind(numbers[key]) for key, kind in kinds.items()}})
    agent = LBSDreamer(hyper, 5, "cpu", FloorPlan.load(folder / "plan"))
    agent.load(folder / "half")
    agent.learn(Replay.open(sorted(folder.glob("*.npz"))), 3, lambda done: None)
    (folder / "end").mkdir()
    agent.save(folder / "end")
"""


def test_a_fresh_process_goes_on_to_the_same_bytes(tiny, replay, a_plan, tmp_path):
    """With every curiosity; one process for all of them, since most of its time goes into its imports."""
    folders = [tmp_path / choice.value for choice in lbs_settings.Curiosity]
    for folder in folders:
        begin(tiny(curiosity=folder.name), replay(), a_plan(), folder)
    subprocess.run([sys.executable, "-c", FRESH, *map(str, folders)], check=True)
    for folder in folders:
        files = sorted(path.name for path in (folder / "straight").iterdir())
        assert files == ["rng.json", "training.json", "training.safetensors", "weights.safetensors"]
        for name in files:
            same = (folder / "end" / name).read_bytes() == (folder / "straight" / name).read_bytes()
            assert same, (folder.name, name)


def begin(settings, store, plan, folder):
    """Settings, plan, episodes, and the agent after three updates and after six."""
    for name in ("half", "straight"):
        (folder / name).mkdir(parents=True)
    numbers = {key: getattr(value, "value", value) for key, value in vars(settings).items()}
    (folder / "hyper.json").write_text(json.dumps(numbers))
    plan.save(folder / "plan")
    for index, episode in enumerate(map(store.episode, range(len(store)))):
        episode.save(folder / f"{index}.npz")
    made = LBSDreamer(settings, 0, "cpu", plan)
    made.learn(store, 3, ignore)
    made.save(folder / "half")
    made.learn(store, 3, ignore)
    made.save(folder / "straight")


def test_weights_of_another_size_are_refused(agent, tmp_path):
    agent().save(tmp_path)
    with pytest.raises(RunFolderError, match=r"does not fit this agent: .* is \(\d+.* there and \("):
        agent(gru_units=24).load(tmp_path)


def test_broken_and_missing_files_are_refused(agent, tmp_path):
    made = agent()
    made.save(tmp_path)
    (tmp_path / "training.json").write_text("{")
    with pytest.raises(RunFolderError, match="cannot be read"):
        made.load(tmp_path)
    (tmp_path / "weights.safetensors").write_bytes(b"cut off")
    with pytest.raises(RunFolderError, match=r"weights\.safetensors cannot be read"):
        made.load(tmp_path)
