"""Docking when things go wrong: every end has a name, comes within its time, and leaves the wheels standing."""

from __future__ import annotations

import ast
import inspect
import math
from itertools import pairwise

import pytest
from dockside import Dockside

from curionav_cli.records import Pose
from curionav_cli.robot.docking import server
from curionav_cli.robot.docking.action import (
    AttemptFailed,
    Code,
    DockingAborted,
    DockingFailed,
    Feedback,
    Goal,
    GoalState,
    Phase,
)
from curionav_cli.robot.docking.approach import State
from curionav_cli.robot.docking_settings import Recovery
from curionav_cli.robot.navigation import NavStatus

PHASES = [Phase.staging, Phase.acquire, Phase.approach, Phase.contact, Phase.charge]
DRIVING = [State.scan, State.aligned_far, State.aligned_near]


def reached(phase: Phase, seed: int = 0) -> Dockside:
    """A robot in this phase."""
    robot = Dockside(at=(1.6, 0.2, 90.0), seed=seed).send_goal()
    feedback = robot.until(lambda feedback: feedback.phase is phase)
    assert feedback.phase is phase, (feedback, robot.server.code)
    return robot


def test_a_return_without_faults_docks_and_charges() -> None:
    robot = Dockside(at=(1.6, 0.2, 90.0)).send_goal()
    received: list[Feedback] = []
    robot.until(lambda feedback: received.append(feedback))
    assert robot.server.code is Code.docked and robot.server.state is GoalState.succeeded
    assert robot.base.charging and robot.result() == "docked"
    phases = list(dict.fromkeys(feedback.phase for feedback in received))
    assert phases[0] is Phase.staging and phases[-1] is Phase.charge and set(PHASES) <= set(phases)
    pause = [late.elapsed - early.elapsed for early, late in pairwise(received)]
    assert max(pause) <= 0.2 + 1e-9  # at least five a second


@pytest.mark.parametrize("phase", PHASES)
def test_a_cancel_stops_at_once_and_another_goal_is_taken(phase: Phase) -> None:
    robot = reached(phase)
    robot.server.cancel()
    assert robot.base.velocity == (0.0, 0.0) and robot.server.state is GoalState.preempted
    assert robot.result() == "cancelled"
    assert robot.server.request(Goal(robot.scene.dock)) is GoalState.active
    assert robot.result() in ("docked", "approach_timeout", "bump_limit")
    assert robot.server.attempts >= 1


@pytest.mark.parametrize("phase", PHASES)
def test_another_goal_preempts_the_active_one(phase: Phase) -> None:
    robot = reached(phase)
    before = robot.server.seconds
    ends: list[Code] = []
    plain = robot.server._end
    robot.server._end = lambda code, text="": (ends.append(code), plain(code, text))[1]
    assert robot.server.request(Goal(robot.scene.dock)) is GoalState.active
    assert ends == [Code.preempted] and robot.base.velocity == (0.0, 0.0)
    assert robot.server.seconds == 0.0 < before


def test_a_goal_for_an_unknown_dock_is_rejected_and_moves_nothing() -> None:
    robot = Dockside()
    assert robot.server.request(Goal(robot.scene.dock, dock_id="kitchen")) is GoalState.rejected
    assert robot.base.velocity == (0.0, 0.0) and robot.server.state is GoalState.pending


@pytest.mark.parametrize("phase", PHASES)
def test_the_battery_may_run_out_in_any_phase(phase: Phase) -> None:
    robot = reached(phase)
    robot.base.battery.left = 0.05
    began = robot.server.seconds
    assert robot.result() == "battery_empty"
    assert robot.server.seconds - began < 0.5


@pytest.mark.parametrize("phase", [Phase.staging, Phase.approach])
@pytest.mark.parametrize("sensor", ["wheel", "gyro", "lidar", "depth", "infrared"])
def test_a_silent_sensor_is_named_within_its_patience(sensor: str, phase: Phase) -> None:
    robot = reached(phase)
    began, pose = robot.server.seconds, robot.body.pose
    robot.body.silent.add(sensor)
    robot.server.tick()
    assert robot.base.velocity == (0.0, 0.0)  # it waits where it stands
    assert robot.result() == "sensor_silent" and sensor in robot.server.text
    assert robot.server.seconds - began < robot.profile.docking.patience + 0.5
    assert math.hypot(robot.body.pose.x - pose.x, robot.body.pose.y - pose.y) < 0.1


def test_a_sensor_that_comes_back_in_time_costs_nothing_but_time() -> None:
    robot = reached(Phase.approach)
    robot.body.silent.add("gyro")
    for _ in range(10):
        robot.server.tick()
    robot.body.silent.clear()
    assert robot.result() in ("docked", "approach_timeout")


@pytest.mark.parametrize("hazard", ["wheel_drop", "cliff"])
@pytest.mark.parametrize("phase", [Phase.staging, Phase.approach])
def test_a_wheel_in_the_air_stops_it(hazard: str, phase: Phase) -> None:
    robot = reached(phase)
    robot.base.hazard = hazard
    robot.server.tick()
    assert robot.result() == hazard


@pytest.mark.parametrize("state", DRIVING)
def test_light_that_goes_out_in_any_drive_state_is_a_named_end(state: State) -> None:
    robot = Dockside(at=(1.0, 0.1, 60.0), recoveries=[]).send_goal(navigate=False)
    robot.until(lambda feedback: feedback.drive == state.value and any(feedback.signals))
    began = robot.server.seconds
    robot.base.signals = lambda: (0, 0, 0)  # type: ignore[method-assign]
    assert robot.result() in ("dock_lost_in_approach", "dock_not_seen", "bump_limit", "no_charge_after_contact")
    assert robot.server.seconds - began < robot.profile.docking.attempt + 1.0


@pytest.mark.parametrize("state", [State.find_stream, State.get_stream])
def test_light_that_goes_out_on_the_way_to_the_middle(state: State) -> None:
    robot = Dockside(at=(1.4, -0.5, 0.0), recoveries=[]).send_goal(navigate=False)
    robot.until(lambda feedback: feedback.drive == state.value)
    assert robot.server.approach.state is state, robot.server.code
    robot.base.signals = lambda: (0, 0, 0)  # type: ignore[method-assign]
    assert robot.result() in ("dock_lost_in_approach", "bump_limit", "approach_timeout")


def test_flickering_light_may_cost_time_but_has_a_named_end() -> None:
    robot = Dockside(at=(1.0, 0.0, 0.0)).send_goal(navigate=False)
    robot.base.infrared.light = robot.profile.docking.infrared.__class__(
        **{**vars(robot.profile.docking.infrared), "missed": 0.5})
    assert robot.result() in ("docked", "approach_timeout", "bump_limit", "dock_lost_in_approach")


def test_a_dock_that_was_carried_away_is_not_seen() -> None:
    robot = Dockside(at=(1.0, 0.0, 0.0), recoveries=[Recovery.rescan]).send_goal(navigate=False)
    robot.base.station.emitter = Pose(-50.0, -50.0, 0.0)
    robot.base.station.dock = Pose(-50.0, -50.0, 0.0)
    assert robot.result() == "dock_not_seen"
    assert robot.server.attempts == 2 and robot.server.recoveries == ["rescan"]
    assert robot.server.seconds < 2 * (robot.profile.docking.acquire + 1.0)


def test_a_dock_that_was_moved_is_searched_for_where_recoveries_reach() -> None:
    """The estimate is off by more than half a metre sideways: only a sidestep brings the robot into the light."""
    codes = {}
    for name, recoveries in (("none", []), ("side", [Recovery.sidestep_left])):
        robot = Dockside(at=(1.4, -0.6, 0.0), estimate_error=(0.0, 0.6), recoveries=recoveries, attempt=120.0)
        codes[name] = robot.send_goal().result()
    assert codes == {"none": "dock_not_seen", "side": "docked"}


@pytest.mark.parametrize("at", [(0.0, 0.5, 0.0), (-0.2, 0.45, 90.0), (0.02, 0.0, 0.0), (0.02, 0.0, 180.0)])
def test_it_may_start_beside_or_touching_the_dock(at: tuple[float, float, float]) -> None:
    robot = Dockside(at=at, recoveries=[]).send_goal(navigate=False)
    assert robot.result() in {code.name for code in Code}
    assert robot.server.seconds < robot.profile.docking.attempt + 10.0


def test_a_bumper_that_sticks_ends_by_its_limit() -> None:
    robot = Dockside(at=(1.0, 0.0, 0.0), recoveries=[]).send_goal(navigate=False)
    plain = robot.base.drive
    robot.base.drive = lambda *move: plain(*move)._replace(bump="left")  # type: ignore[method-assign]
    assert robot.result() in ("bump_limit", "no_charge_after_contact")


def test_contact_without_current_is_named() -> None:
    robot = Dockside(at=(0.8, 0.0, 0.0), recoveries=[], attempt=300.0).send_goal(navigate=False)
    robot.base.station.charging = lambda pose: False  # type: ignore[method-assign]
    assert robot.result() == "no_charge_after_contact"


def test_current_that_stops_after_three_seconds_is_named() -> None:
    robot = Dockside(at=(0.8, 0.0, 0.0), recoveries=[], attempt=300.0).send_goal(navigate=False)
    robot.until(lambda feedback: feedback.phase is Phase.charge)
    began = robot.server.seconds
    robot.base.station.charging = lambda pose: robot.server.seconds < began + 3.0  # type: ignore[method-assign]
    assert robot.result() == "charge_dropped"
    assert robot.server.seconds - began == pytest.approx(3.0, abs=0.2)


def test_the_whole_return_to_dock_has_a_deadline() -> None:
    robot = Dockside(at=(1.6, 0.2, 90.0), action=8.0).send_goal()
    assert robot.result() == "deadline_passed" and robot.server.seconds < 8.3


def test_a_goal_inside_an_obstacle_of_the_map_is_replaced_by_a_place_beside_it() -> None:
    robot = Dockside(at=(1.6, 0.2, 90.0))
    goal = Pose(1.8, 0.45, 0.0)  # in the cabinet
    robot.navigator.set_goal(goal)
    for _ in range(3000):
        status = robot.navigator.tick()
        if status is not NavStatus.driving:
            break
    assert status in (NavStatus.blocked, NavStatus.timed_out)  # it ends, and it did not go through the wall
    assert robot.scene.plan.floor[robot.scene.plan.cells(robot.body.pose.x, robot.body.pose.y)]


def test_a_robot_that_is_walled_in_ends_as_nav_blocked() -> None:
    robot = Dockside(at=(1.6, 0.2, 90.0), recoveries=[])
    plain = robot.map.insert

    def walled(pose, scan):  # whatever is cleared, the walls are inserted again
        plain(pose, scan)
        for angle in range(0, 360, 4):
            yaw = math.radians(angle)
            robot.map.mark_occupied(0.4 + 0.5 * math.cos(yaw), 2.0 + 0.5 * math.sin(yaw))
    robot.map.insert = walled  # type: ignore[method-assign]
    robot.map.insert(robot.localiser.pose, robot.body.scan())
    assert robot.send_goal().result() == "nav_blocked"


def test_every_code_has_a_number_and_a_text() -> None:
    assert [code.name for code in Code if code.number == 904] == ["dock_not_seen"]
    assert {code.number for code in Code} == {0, 903, 904, 905, 906, 999}
    assert all(code.text for code in Code) and len({code.value for code in Code}) == len(Code)


def test_each_failure_has_the_number_of_nav2_and_each_code_is_raised() -> None:
    """Read from the server's source: `raise FailedToStage(Code.nav_timeout)` and the like."""
    numbers = {"FailedToStage": 903, "FailedToDetectDock": 904, "FailedToControl": 905, "FailedToCharge": 906}
    raised = set()
    for call in ast.walk(ast.parse(inspect.getsource(server))):
        if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id in numbers:
            names = {node.attr for node in ast.walk(call.args[0]) if isinstance(node, ast.Attribute)}
            names &= set(Code.__members__)
            assert {Code[name].number for name in names} == {numbers[call.func.id]}, names
            raised |= names
    assert raised == {code.name for code in Code if code.number in numbers.values()}
    assert issubclass(AttemptFailed, DockingFailed) and not issubclass(DockingAborted, AttemptFailed)
