"""curionav robot check: what of a profile is there, how old its data is, and whether moves do what they should."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from difflib import get_close_matches
from typing import NamedTuple

from curionav_cli.constants import STEP_LENGTH, TURN_ANGLE
from curionav_cli.live.base import LiveBase
from curionav_cli.live.safety import Fault
from curionav_cli.live.sensors import SILENT_ON_DOCK, Sensors, full
from curionav_cli.live.settings import Rosbridge, Topic
from curionav_cli.live.transport import Transport
from curionav_cli.robot.corridor import occupied
from curionav_cli.robot.measurements import Signals

LISTENING = 3.0  # seconds
OK, ABSENT, WRONG, SILENT, UNKNOWN, LEFT_OUT = "ok", "MISSING", "WRONG", "SILENT", "not known", "left out"
BAD = (ABSENT, WRONG, SILENT)
RARE = 4.0  # messages a second of images or odometry below which steps take long


class Finding(NamedTuple):
    """A line of the report. cure: what to mend, where the state is bad."""

    what: str
    name: str
    state: str
    about: str
    cure: str = ""


def findings(base: LiveBase, move: bool) -> Iterator[Finding]:
    """Check a connected robot. move: also make a short turn and a short move."""
    listen(base)
    offered = base.transport.topics()
    if not offered:
        yield Finding("rosapi", "/rosapi/topics", UNKNOWN, "the bridge does not list topics; types are not compared")
    for key in base.sensors.topics:
        yield topic(base, key, offered)
    yield velocity(base.settings, offered)
    yield from actions(base.transport, base.settings)
    yield from contents(base)
    if move:
        yield from moves(base)


def listen(base: LiveBase) -> None:
    """Let messages arrive: for LISTENING seconds, once every needed topic has been heard or `robot.connect` is over."""
    heard = base.sensors.received
    pass_time(base, base.settings.connect, lambda: all(heard[key] for key in base.sensors.needed))
    for key in base.sensors.needed:
        heard[key] = 0  # so that it counts what comes in LISTENING seconds
    pass_time(base, LISTENING, lambda: False)


def pass_time(base: LiveBase, seconds: float, ready: Callable[[], bool]) -> None:
    """Wait for `seconds`, or until it is ready or the connection is lost."""
    until = base.clock.now() + seconds
    while base.clock.now() < until and base.transport.is_alive() and not ready():
        base.clock.sleep(0.05)


def topic(base: LiveBase, key: str, offered: dict[str, str]) -> Finding:
    """Whether a topic is there, of the right type, and how often and how recently it was heard."""
    sensors, expected = base.sensors, base.sensors.topics[key]
    name = full(base.settings.namespace, expected.name)
    wrong = compared(key, name, expected, offered)
    count, age = sensors.received[key], sensors.age(key)
    heard = f"{count / LISTENING:.1f} a second, the last {age:.2f} s ago" if count else f"nothing in {LISTENING:g} s"
    if wrong:
        return wrong
    if count:
        rare = key in sensors.needed and count / LISTENING < RARE
        return Finding(key, name, OK, heard + (", which makes steps slow" if rare else ""))
    if key not in sensors.needed:
        return Finding(key, name, OK if key.startswith("contact") else UNKNOWN, heard + " (it may send changes only)")
    if key in SILENT_ON_DOCK and sensors.docked():
        return Finding(key, name, UNKNOWN, f"{heard}: the robot is docked, where some cameras are off")
    if sensors.complaint(key):
        return Finding(key, name, WRONG, heard + sensors.complaint(key), f"robot.profile.{setting(key)}.type=...")
    return Finding(key, name, SILENT, heard, f"{name} is announced and sends nothing: start what publishes it, and "
                                             "look whether its type is right")


def compared(key: str, name: str, expected: Topic, offered: dict[str, str]) -> Finding | None:
    """What is wrong with a topic's name or type by the bridge's list; None where nothing is, or it has no list."""
    if not offered or offered.get(name) == expected.type:
        return None
    if name not in offered:
        near = next(iter(get_close_matches(name, offered, n=1, cutoff=0.5)), "")
        same = [other for other, kind in offered.items() if kind == expected.type]
        guess = near or (same[0] if same else "")
        cure = f"robot.profile.{setting(key)}.name={guess}" if guess and setting(key) else f"nothing offers {name}"
        about = f"the nearest is {guess} ({offered[guess]})" if guess else "nothing has a similar name"
        return Finding(key, name, ABSENT, about, cure)
    cure = f"robot.profile.{setting(key)}.type={offered[name]}" if setting(key) else f"name its type {offered[name]}"
    return Finding(key, name, WRONG, f"is {offered[name]}, expected {expected.type}", cure)


def setting(key: str) -> str:
    """The key of a topic among the profile's settings; empty for contacts, whose keys are their names."""
    return "" if key.startswith("contact") else key


def velocity(settings: Rosbridge, offered: dict[str, str]) -> Finding:
    """Whether somebody listens to velocity commands, of which type."""
    expected = settings.profile.velocity
    name = full(settings.namespace, expected.name)
    if not offered:
        return Finding("velocity", name, UNKNOWN, expected.type)
    kind = offered.get(name, "")
    if not kind:
        found = compared("velocity", name, expected, offered)
        assert found is not None
        return found
    if not kind.endswith(("/Twist", "/TwistStamped")):
        return Finding("velocity", name, WRONG, f"is {kind}", "robot.profile.velocity.name=... of a Twist")
    return Finding("velocity", name, OK, f"{kind} (robot.twist=auto follows it)")


def actions(transport: Transport, settings: Rosbridge) -> Iterator[Finding]:
    """Whether the profile's actions are there."""
    offered = transport.actions()
    for key, action in settings.profile.actions().items():
        name = full(settings.namespace, action.name)
        if offered is None:
            yield Finding(f"action {key}", name, UNKNOWN, "the bridge does not list actions")
        elif name in offered:
            yield Finding(f"action {key}", name, OK, action.type)
        else:
            near = next(iter(get_close_matches(name, offered, n=1, cutoff=0.5)), "")
            yield Finding(f"action {key}", name, ABSENT, f"the nearest is {near}" if near else "no similar name",
                          f"robot.profile.{key}.name={near or '...'}")


def contents(base: LiveBase) -> Iterator[Finding]:
    """What the newest messages say, or why they cannot be used."""
    sensors = base.sensors
    for key, read in (("image", lambda: f"mean {sensors.image().mean():.0f} of 255 after cropping to 64 x 64"),
                      ("depth", lambda: f"nearest {sensors.depth().min():.2f} m"),
                      ("scan", lambda: f"{len(sensors.around().range)} beams"),
                      ("battery", lambda: in_percent(sensors.charge())),
                      ("docked", lambda: "yes" if sensors.docked() else "no"),
                      ("dock_ir", lambda: in_bits(sensors.signals()))):
        if sensors.received[key]:
            yield understood(key, read)
    yield understood("all", lambda: unbroken(sensors))


def understood(key: str, read: Callable[[], str]) -> Finding:
    """What a message says, or the fault in it."""
    try:
        return Finding(f"content {key}", "", OK, read())
    except Fault as fault:
        return Finding(f"content {key}", "", WRONG, str(fault), f"{fault}")


def unbroken(sensors: Sensors) -> str:
    """Raises MessageFault for a message that could not be used."""
    sensors.check(sensors.needed)
    return "no message is broken"


def in_bits(signals: Signals) -> str:
    """What the infrared receivers see, in the Kobuki's bits."""
    return "right {}, centre {}, left {}".format(*signals) if any(signals) else "no light of a dock"


def in_percent(share: float | None) -> str:
    return "does not say" if share is None else f"{share:.0%}"


def moves(base: LiveBase) -> Iterator[Finding]:
    """A turn to the left, back to the right, and a move ahead where depth shows room; measured by odometry."""
    try:
        yield turned(base, TURN_ANGLE)
        yield turned(base, -TURN_ANGLE)
        if occupied(base.depth(), 0.25, 2 * STEP_LENGTH):
            yield Finding("move ahead", "", LEFT_OUT, "something stands within half a metre")
            return
        start, began = base.sensors.travel.forward, base.clock.now()
        base.mover.forward(STEP_LENGTH, base.pause)
        base.wait_for_view()
        yield measured("move ahead", base.sensors.travel.forward - start, STEP_LENGTH, 0.05, "m", base, began)
    except (Fault, KeyError) as fault:
        base.halt()
        yield Finding("moves", "", WRONG, f"stopped: {fault}", str(fault))


def turned(base: LiveBase, angle: float) -> Finding:
    """Turn by an angle, radians, and measure it."""
    start, began = base.sensors.travel.turned, base.clock.now()
    base.mover.turn(angle, base.pause)
    base.wait_for_view()
    by_odometry = math.degrees(base.sensors.travel.turned - start)
    side = "left" if angle > 0.0 else "right"
    return measured(f"turn {side}", by_odometry, math.degrees(angle), 3.0, "degrees", base, began)


def measured(what: str, found: float, wanted: float, within: float, unit: str, base: LiveBase, began: float) -> Finding:
    """A move's measure beside its command, and how long it took until there was an image of it."""
    about = f"{found:.2f} of {wanted:.2f} {unit} in {base.clock.now() - began:.1f} s with its image"
    good = abs(found - wanted) <= within
    return Finding(what, "", OK if good else WRONG, about, "" if good else f"{what}: {about}; is another node driving, "
                                                           "or robot.twist of the wrong type?")
