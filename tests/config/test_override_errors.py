"""What people mistype, and the answer they get: exit code 2, at most four lines, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

TYPED = {
    "env=small_reel": ["There is no small_reel in the group env. Did you mean small_room?", "env has: "],
    "sed=1": ["The settings have no key sed. Did you mean seed?"],
    "lr=1": ["The settings have no key lr. Did you mean", "agent.model_lr"],
    "repeat=1 agent=sticky": ["The settings have no key repeat. Did you mean env.repeat or agent.repeat?"],
    "agent.model_lr=fast": ["agent.model_lr: 'fast' is not a number"],
    "agent=random,bounce": ["A list of values needs a sweep. Add -m: curionav explore -m agent=random,"],
    "launcher=cores": ["launcher=cores is for sweeps. Add -m: curionav explore -m launcher=cores"],
    "hydra.sweeper.max_batch_size=1": ["hydra.sweeper.max_batch_size=1 is for sweeps. Add -m:"],
    "loop.steps=12:30": ["loop.steps: '12:30' is not a whole number."],
    "=5": ["=5 names no setting. Settings are written as key=value."],
    "seed=range(0,3)": ["A list of values needs a sweep. Add -m:"],
    "--seed 3": ["Settings are written without dashes: seed=3"],
    "--loop.steps=3": ["Settings are written without dashes: loop.steps=3"],
    "-x": ["There is no option -x."],
    "+agent.foo=1": ["+agent.foo=1 would add a key that nothing reads."],
    "++foo=1": ["++foo=1 would add a key that nothing reads."],
    "-m env=glob(zz*)": ["env=glob(zz*) matches nothing, so no job would run.", "env has: "],
    "-m seed=range(0,0)": ["matches nothing, so no job would run."],
    "-m agent=random,bounse": ["There is no bounse in the group agent. Did you mean bounce?"],
    "-m agent=random seed=1,x": ["seed: 'x' is not a whole number."],
    "-m seed=interval(0,3)": ["needs a sweeper that draws values: hydra/sweeper=optuna. Without one: key=1,2,3"],
    "-m hydra.job.num=1,2": ["Sweeping over Hydra's configuration is not supported"],
    "env": ["env needs a value: env=...", "env has: "],
    "seed": ["seed needs a value: seed=..."],
    "sead": ["sead is not a setting. Settings are written as key=value. Did you mean seed?"],
    "–m": ["'–m' is not a setting. Settings are written as key=value"],
    "env=": ["env needs one of its options.", "env has: "],
    "env=null": ["env needs one of its options.", "env has: "],
    "env=map": ["env=map: this scene needs a ROS map, env.map=PATH.yaml"],
    "-m hydra.sweeper.params.seed=1": ["hydra.sweeper.params.seed=1: no such key is declared.", "itself: seed=1"],
    "env=a=b": ["env=a=b cannot be read as key=value"],
    "launcher=core": ["There is no core in the group launcher. Did you mean cores?"],
    "hydra/launcher=jobib": ["There is no jobib in the group hydra/launcher. Did you mean joblib?"],
    "hydra.run.foo=3": ["The settings have no key hydra.run.foo."],
    "agent=lbs": ["There is no lbs in the group agent. Did you mean lbs_dreamer?"],
    "agent=cbet agent.options=seven": ["The settings have no key agent.options. It is a setting of "
                                       "agent=random, agent=lbs_dreamer."],
    "agent=random agent.kl_balance=1": ["The settings have no key agent.kl_balance. It is a setting of "
                                        "agent=curious_mapper, agent=lbs_dreamer."],
    "scale=huge": ["There is no huge in the group scale.", "scale has: cpu, paper."],
    "device=gpu": ["device: 'gpu' is not one of auto, cpu, cuda."],
    "compile=yes": ["compile: 'yes' is not one of auto, none, graph, fused."],
    "device=cpu compile=graph": ["compile=graph needs a CUDA device, and this run computes on the CPU."],
    "loop=3": ["loop holds several settings: loop.steps, loop.iterations, loop.episodes, loop.replay_memory, ",
               "loop.replay_episodes, loop.keep."],
    "loop.stps=3": ["The settings have no key loop.stps. Did you mean loop.steps?"],
    "loop.steps=": ["loop.steps: '' is not a whole number."],
    "loop.steps=1.5": ["loop.steps: '1.5' is not a whole number."],
    "loop.steps=0": ["loop.steps: 0 is not between 1 and 1000000"],
    "loop.iterations=-1": ["loop.iterations: -1 is not between 0 and"],
    "loop.episodes=0": ["loop.episodes: 0 is not between 1 and"],
    "loop.replay_memory=-1": ["loop.replay_memory: -1.0 is not between 0 and"],
    "seed=-1": ["seed: -1 is not between 0 and 4294967295"],
    "seed=${nope}": ["seed: Interpolation key 'nope' not found"],
    "agent=sticky agent.repeat=2": ["agent.repeat: 2.0 is not between 0 and 1"],
    "agent=bounce agent.min_turn=90 agent.max_turn=60": ["agent.max_turn: 60.0 is not between 90.0 and 180"],
    "env.start=[1,2,x]": ["env.start: '[1,2,x]' is not a list [...], each a number."],
    "env.collision=bounce": ["env.collision: 'bounce' is not one of cancel, stop, slide."],
    "hydra.run.dir=": ["hydra.run.dir is empty. Name a folder, or leave it out."],
    "-m seed=0,1 launcher=cores hydra.launcher.n_jobs=0": ["hydra.launcher.n_jobs=0 runs nothing."],
    "env.map=office.yaml": ["opens a ROS map, and env=small_room has a size of its own. Add env=map."],
    "~seed": ["~seed: a setting can be changed, not removed. Give it another value."],
    "env.name='a": ["cannot be read as key=value"],
}


@pytest.mark.parametrize("typed", TYPED)
def test_a_short_answer(cli: Cli, tmp_path: Path, typed: str) -> None:
    answer = cli("explore", *typed.split())
    assert answer.code == 2
    for piece in TYPED[typed]:
        assert piece in answer.error
    assert 1 <= len(answer.error.strip().splitlines()) <= 4
    assert answer.out == "" and not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--multrun", "--confg-dir"])
def test_an_unknown_option_is_named(cli: Cli, option: str) -> None:
    answer = cli("explore", option)
    assert answer.code == 2 and f"There is no option {option}" in answer.error


def test_showing_answers_the_same(cli: Cli) -> None:
    assert cli("explore", "--cfg", "job", "sed=1").code == 2
    answer = cli("explore", "--cfg", "job", "-p", "agnt")
    assert answer.code == 2 and "no part agnt" in answer.error


def test_a_world_that_cannot_stand_is_found_before_anything_is_written(cli: Cli, tmp_path: Path) -> None:
    answer = cli("explore", "agent=random", "env.visitable=7")
    assert answer.code == 2 and "visitable" in answer.error and not list(tmp_path.iterdir())
