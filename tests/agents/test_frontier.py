"""The oracle against its promise: nothing reachable is left, and it takes the shortest way."""

from types import SimpleNamespace

import numpy as np

from curionav_cli.agents.frontier import Frontier
from curionav_cli.constants import FORWARD, LEFT, STEP_LENGTH
from curionav_cli.results.coverage import cover
from curionav_cli.world.motion import COS, SIN, forward


def world(plan, later=None):
    """A scene as the oracle uses it; from its second episode on the plan may be another."""
    return SimpleNamespace(plan=plan, at=lambda episode, seed: (SimpleNamespace(plan=later if episode else plan), ()))


def run(agent, plan, steps, x=0.55, y=0.55, heading=0, episode=0):
    """Perfect motion, by the world's rule for one pose."""
    pose, collided = [(x, y, heading)], False
    agent.begin()
    for _ in range(steps):
        action = agent.act({}, {"pose": (x, y, heading * np.pi / 18), "collided": collided, "episode_index": episode})
        collided = False
        if action == FORWARD:
            x, y, collided = forward(plan.visitable, plan.cell, x, y, heading)
        else:
            heading = (heading + (1 if action == LEFT else -1)) % 36
        pose.append((x, y, heading))
        assert not (collided and agent.way), "a planned move was cancelled"
    return np.array(pose)


def test_it_covers_a_room_and_never_bumps_on_its_way(a_plan):
    plan = a_plan(rows=14, columns=16, cell=0.1, hole=True)
    pose = run(Frontier(0, world(plan)), plan, 1500)
    assert cover(plan, [pose]).share > 0.97


def test_the_nearest_unvisited_cell_is_reached_by_the_fewest_actions(a_plan):
    plan = a_plan(rows=14, columns=16, cell=0.1)
    agent = Frontier(0, world(plan))
    agent.visited[:] = True
    row, column = plan.cells(0.55 + 2 * STEP_LENGTH * COS[9], 0.55 + 2 * STEP_LENGTH * SIN[9])
    agent.visited[row, column] = False  # two moves ahead, after a quarter turn to the left
    way = agent.search(0.55, 0.55, 6)
    assert way == [LEFT] * 3 + [FORWARD] * 2
    assert agent.search(0.55, 0.55, 6) == way
    agent.visited[:] = True
    assert agent.search(0.55, 0.55, 6) == []


def test_it_remembers_across_episodes_and_files(tmp_path, a_plan):
    plan = a_plan(rows=10, columns=10, cell=0.1)
    agent, other = Frontier(0, world(plan)), Frontier(1, world(plan))
    run(agent, plan, 40)
    agent.save(tmp_path)
    other.load(tmp_path)
    np.testing.assert_array_equal(other.visited, agent.visited)
    np.testing.assert_array_equal(run(agent, plan, 40), run(other, plan, 40))


def test_it_searches_the_map_of_each_episode(a_plan):
    open_room, with_a_block = a_plan(rows=14, columns=16), a_plan(rows=14, columns=16, hole=True)
    agent = Frontier(0, world(open_room, with_a_block))
    run(agent, open_room, 5)
    pose = run(agent, with_a_block, 900, episode=1)
    assert cover(with_a_block, [pose]).share > 0.9
