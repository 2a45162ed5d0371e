"""The docking diagram: the phases in the feedback of the docking server, counted over returns to dock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from curionav_cli import build
from curionav_cli.config.schema import Config
from curionav_cli.loop import Callbacks, NoLearning, run_episodes
from curionav_cli.results import docking_diagram, plots
from curionav_cli.results.docking_diagram import Moves
from curionav_cli.robot.docking.action import NOT_IN_NAV2, Code, Feedback, Goal, GoalState, Phase
from curionav_cli.robot.docking.recoveries import attempts
from curionav_cli.robot.docking.server import DockingServer

REQUESTS, STEPS = 30, 100  # returns to dock in each room, actions before each
ROOMS = ("small_room", "large_lab")
NAME = "docking_diagram.png"


class Watched:
    """A docking server (client.ActionServer) whose phases are counted as they change."""

    def __init__(self, server: DockingServer, moves: Moves):
        self.server, self.moves, self.phase = server, moves, Phase.idle
        self.code, self.text = server.code, server.text

    def request(self, goal: Goal) -> GoalState:
        state = self.server.request(goal)
        self.code, self.text = self.server.code, self.server.text
        return state

    def cancel(self) -> None:
        self.server.cancel()

    def tick(self) -> Feedback:
        feedback = self.server.tick()
        self.code, self.text = self.server.code, self.server.text
        if feedback.phase is not self.phase:
            self.moves[self.phase.value, feedback.phase.value] += 1
            self.phase = feedback.phase
        return feedback


def watched(settings: Config, requests: int) -> Moves:
    """Count how often one phase follows another in `requests` returns to dock."""
    world, moves = build.scene(settings), Moves()
    env = build.robot_env(settings, world, False, lambda server: Watched(server, moves))
    agent = build.agent(settings, world)
    run_episodes(env, agent, NoLearning(), episodes=requests, steps=STEPS, seed=settings.seed, watch=Callbacks(),
                 return_after_last=True)
    return moves


def draw(rooms: Sequence[Config], folder: Path, requests: int = REQUESTS) -> str:
    """Draw one diagram over these rooms; returns its name in the folder."""
    moves: Moves = sum((watched(room, requests) for room in rooms), Counter())
    names = dict.fromkeys(name for name, _ in attempts(rooms[0].robot.docking))
    recoveries = [name for name in names if name != "staging"]
    where = " and ".join(room.env.name for room in rooms)
    title = f"Auto docking: {requests * len(rooms)} returns to dock in {where}, {STEPS} actions after each start"
    final = [code.name for code in Code if code.number == NOT_IN_NAV2]
    plots.save(docking_diagram.diagram(moves, recoveries, final, title), folder / NAME)
    return NAME
