"""Every way in which a return to dock can end has a colour of its own in the figure of arrivals."""

from curionav_cli.results.docking_plots import COLOURS
from curionav_cli.robot.docking.action import Code


def test_every_ending_has_a_colour() -> None:
    assert len(set(COLOURS)) == len(COLOURS) >= len(Code) + 1
