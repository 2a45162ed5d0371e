"""The agent in the loop: turns of environments, its own schedule, same seed same bytes, and going on after a save."""

import json

import numpy as np
import pytest
import torch

from curionav_cli.errors import RunFailed, RunFolderError


def ignore(done):
    pass


def saved(agent, folder):
    folder.mkdir()
    agent.save(folder)
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def without_seconds(rows):
    return [{key: value for key, value in row.items() if not key.startswith("seconds_")} for row in rows]


OPTIONS = [{"reward": name} for name in ("cbet", "count", "rnd", "icm", "ride", "motion", "count_oracle")] + [
    {"name": "cbet_lifelong"}, {"view": "ego"}, {"difference": "signed"}, {"tables": "shared"}, {"reset": "episode"},
    {"reset": "never"}, {"count_teleport": False}, {"normalise": True}, {"view": "ego", "reward": "motion"},
    {"key": "grey_16", "difference": "signed", "key_bits": 16}, {"key": "grey_8", "difference": "signed"}]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_every_option_acts_learns_and_goes_on_to_the_same_bytes(agent, room, tmp_path, options):
    """Three episodes of four unrolls, five an update: unrolls are left over wherever it stops."""
    options = {"batch_size": 5, **options}
    straight, place = agent(**options), room(steps=20)
    rows = place.run(straight, 1)
    saved(straight, tmp_path / "one")
    rows += place.run(straight, 2)
    assert all(np.isfinite(list(row.values())).all() for row in rows)
    assert [row["updates"] for row in rows] == [0, 1, 2] and len(straight.waiting) == 2
    resumed, later = agent(**options), room(steps=20, first=1)
    resumed.rng.random()
    resumed.load(tmp_path / "one")
    later.replay.add(place.replay.episode(0))
    assert without_seconds(later.run(resumed, 2)) == without_seconds(rows[1:])
    for index in (1, 2):
        assert (later.replay.episode(index).action == place.replay.episode(index).action).all()
    assert saved(resumed, tmp_path / "resumed") == saved(straight, tmp_path / "straight")


def test_same_seed_same_bytes_other_seed_other_bytes(agent, room, tmp_path):
    left = []
    for number, seed in enumerate((0, 0, 1)):
        torch.manual_seed(number)  # the global generator must not matter
        made, place = agent(seed), room(steps=20)
        rows = without_seconds(place.run(made, 3))
        actions = [place.replay.episode(index).action.tolist() for index in range(3)]
        left.append((saved(made, tmp_path / str(number)), actions, rows))
    assert left[0] == left[1]
    assert left[0][1] != left[2][1] and left[0][0]["weights.safetensors"] != left[2][0]["weights.safetensors"]


def test_it_learns_by_its_own_schedule(agent, room):
    """updates = frames // (B T), whatever the loop's K; K = 0 is no learning."""
    made, place, ticks = agent(view="ego", batch_size=3, unroll=5), room(steps=20), []
    for episode in range(1, 6):
        place.episode(made)
        row = made.learn(place.replay, 100, ticks.append)
        assert row["updates"] == episode * 20 // 15 and row["frames_replayed"] == row["updates"] * 15
        assert row["unrolls_waiting"] == (episode * 4) % 3
    assert ticks == [1, 1, 1, 2, 1, 1] and len(ticks) == row["updates"]
    place.episode(made)
    before = [weight.clone() for weight in made.learner.networks.parameters()]
    assert made.learn(place.replay, 0, ignore) == {}
    assert all((a == b).all() for a, b in zip(before, made.learner.networks.parameters(), strict=True))


def test_environments_take_turns(agent, room):
    made, place = agent(view="ego", environments=3, reset="never"), room(steps=10)
    place.run(made, 4)
    tables = made.learner.reward.counts["states"].tables
    assert [sum(table.values()) for table in tables] == [20, 10, 10]
    assert (made.visited.sum(axis=1) > 0).all() and made.visited.shape[0] == 3


def test_coverage_of_one_environment(agent, room, small_room):
    made, place = agent(view="ego", environments=2), room(steps=40)
    rows, cells = place.run(made, 5), [set(), set()]
    for index in range(5):
        pose = place.replay.episode(index).pose[1:]
        cells[index % 2] |= set(zip(*(part.tolist() for part in small_room.plan.cells(*pose[:, :2].T)), strict=True))
        assert rows[index]["most_cells_of_one_environment"] == max(map(len, cells))
    assert len(cells[0] | cells[1]) >= max(map(len, cells)) == made.visited.sum(axis=1).max()
    assert not (made.visited & ~small_room.plan.visitable.ravel()).any()


def test_forgetting_counts_forgets_no_coverage(agent, room):
    made, place = agent(view="ego", reset="random", reset_prob=1.0), room(steps=20)
    rows = place.run(made, 3)
    assert not any(made.learner.reward.counts["states"].tables)
    seen = [row["most_cells_of_one_environment"] for row in rows]
    assert seen == sorted(seen) and seen[0] > 0


def test_an_episode_that_it_did_not_act_in_is_refused(agent, room):
    made, place = agent(view="ego"), room(steps=20)
    place.episode(made)
    made.begin()
    with pytest.raises(RunFailed, match="on-policy"):
        made.learn(place.replay, 1, ignore)


def test_a_loss_that_is_not_finite_ends_the_run(agent, room):
    made, place = agent(view="ego", reward="motion"), room(steps=20)
    object.__setattr__(made.learner.hyper, "lr", 1e30)  # the schema refuses it
    with pytest.raises(RunFailed, match=r"training diverged: .* not finite"):
        place.run(made, 3)


def test_broken_files_and_other_networks_are_named(agent, tmp_path):
    made = agent(view="ego")
    saved(made, tmp_path / "whole")
    with pytest.raises(RunFolderError, match=r"weights\.safetensors does not fit this agent: policy\.lstm"):
        agent(view="ego", lstm_units=8).load(tmp_path / "whole")
    with pytest.raises(RunFolderError, match="another seed"):
        agent(seed=1, view="ego").load(tmp_path / "whole")
    for name in ("memory.safetensors", "memory.json", "training.safetensors", "weights.safetensors"):
        saved(made, tmp_path / name)
        (tmp_path / name / name).write_bytes(b"{")
        with pytest.raises(RunFolderError, match=f"{name} cannot be read"):
            agent(view="ego").load(tmp_path / name)
    assert json.loads((tmp_path / "whole" / "memory.json").read_text())["updates"] == 0
