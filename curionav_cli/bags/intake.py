"""A bag made into episodes: those that curionav wrote as they were, others cut from their odometry."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.bags import recorded
from curionav_cli.bags.cut import Piece, cut
from curionav_cli.bags.reader import DEPTHS, IMAGES, ODOMETRY, Bag, Received, opened, printable
from curionav_cli.bags.source import Source
from curionav_cli.bags.track import MOST, Tracker
from curionav_cli.constants import ACTIONS
from curionav_cli.errors import BagError
from curionav_cli.live.images import depth, picture
from curionav_cli.live.messages import stamp_of
from curionav_cli.live.safety import MessageFault
from curionav_cli.live.travel import RESTART
from curionav_cli.records import Episode

UNUSABLE = "unusable messages, such as "
NO_DEPTH = "depth images that cannot be used"
NAMED = 12  # topics in a message
BESIDE = 0.2  # seconds from a depth image to the image that it belongs to

Frame = tuple[np.ndarray, np.ndarray | None]  # image (64, 64, 3) uint8, depth (64, 64) float32 metres


def episodes(path: Path, sources: Sequence[Source], report: dict[str, Any]) -> Iterator[Episode]:
    """Yield the episodes of a bag. sources: the robots that it may be of.

    report is filled: profile, images and seconds of the bag, moves by action, what was left out. Raises BagError.
    """
    with opened(path) as bag:
        report.update(profile="curionav", images=0, seconds=0.0, moves=[0] * len(ACTIONS), left_out=Counter())
        try:
            found = iter([recorded.episode(bag)]) if recorded.is_ours(bag) else driven(bag, sources, report)
        except MessageFault as fault:
            raise BagError(f"{path}: {printable(str(fault))}.") from fault
        for episode in found:
            report["moves"] = (np.bincount(episode.action, minlength=len(ACTIONS)) + report["moves"]).tolist()
            yield episode
    if not sum(report["moves"]):
        words = "; ".join(f"{what}: {number}" for what, number in report["left_out"].items())
        raise BagError(f"{path} holds no move of 0.25 m or 10 degrees with an image ({report['images']} images in "
                       f"{report['seconds']:.0f} s{'; ' if words else ''}{words}).")


def driven(bag: Bag, sources: Sequence[Source], report: dict[str, Any]) -> Iterator[Episode]:
    """The episodes that are cut from the bag's odometry."""
    source, image = chosen(bag, sources)
    tracker, views = scanned(bag, source, image, report["left_out"])
    report.update(profile=source.profile, images=views.count)
    pieces = []
    for era, stamps, numbers in zip(tracker.eras(), views.stamps, views.numbers):
        for stretch in era:
            report["seconds"] += float(stretch.stamp[-1] - stretch.stamp[0])
            pieces += [piece._replace(image=[numbers[one] for one in piece.image])
                       for piece in cut(stretch, np.array(stamps), report["left_out"])]
    return pictured(bag, image, source, pieces, report["left_out"])


def chosen(bag: Bag, sources: Sequence[Source]) -> tuple[Source, str]:
    """The robot whose topics the bag has, and the topic of its images. Raises BagError where it is none, or several."""
    fits = [(source, image) for source in sources for image in source.images[:2]
            if bag.topics.get(image) in IMAGES and bag.topics.get(source.odom) in ODOMETRY]
    topics = {(image, source.odom, source.crop) for source, image in fits}
    if len({source.profile for source, _ in fits}) > 1 and len(topics) > 1:
        raise BagError(f"{bag.path} fits {' and '.join(dict.fromkeys(source.profile for source, _ in fits))}. "
                       "Name one: env=live robot=rosbridge robot.profile=...")
    if fits:
        return fits[0]
    wanted = ", ".join(f"{one.profile}: {one.image}, {one.odom}" for one in sources)
    seen = [f"{topic} ({kind})" for topic, kind in sorted(bag.topics.items()) if kind in (*IMAGES, *ODOMETRY)]
    there = printable(", ".join((seen or sorted(bag.topics))[:NAMED]) or "no topics")
    raise BagError(f"{bag.path} lacks the images or the odometry of a robot ({wanted}). It has {there}. Name "
                   "them: env=live robot=rosbridge robot.profile.image.name=... robot.profile.odom.name=...")


class Views:
    """When images were taken, and their numbers among all images of the bag; anew where their clock starts anew."""

    def __init__(self, left_out: Counter[str]):
        self.stamps: list[list[float]] = [[]]
        self.numbers: list[list[int]] = [[]]
        self.count, self.left_out = 0, left_out

    def add(self, at: float) -> None:
        """Take an image of this time; a late one is left out."""
        last = self.stamps[-1][-1] if self.stamps[-1] else -np.inf
        if at < last - RESTART:
            self.stamps.append([])
            self.numbers.append([])
        if at > last or not self.stamps[-1]:
            self.stamps[-1].append(at)
            self.numbers[-1].append(self.count)
        else:
            self.left_out["late images"] += 1


def scanned(bag: Bag, source: Source, image: str, left_out: Counter[str]) -> tuple[Tracker, Views]:
    """The odometry of a bag, and when its images were taken."""
    stamp = clock(bag, image, source.odom)
    tracker, views = Tracker(left_out), Views(left_out)
    for number, one in enumerate(bag.messages(source.odom, image)):
        try:
            at = stamp(one)
            if one.topic == image:
                views.add(at)
            else:
                tracker.add(one.message)
        except MessageFault as fault:
            left_out[unusable(left_out, fault)] += 1
        views.count += one.topic == image
        if number - views.count >= MOST:
            raise BagError(f"{bag.path} has more than {MOST} messages of odometry. Cut it: ros2 bag convert")
    return tracker, views


def clock(bag: Bag, *topics: str):
    """The time of a message: of its header; of its recording where a topic's headers have no time."""
    first = [next(bag.messages(topic), None) for topic in topics]
    by_header = all(one is None or stamp_of(one.message) > 0.0 for one in first)

    def at(one: Received) -> float:
        if not by_header:
            one.message["header"]["stamp"] = {"sec": int(one.recorded), "nanosec": round(1e9 * (one.recorded % 1.0))}
        return stamp_of(one.message)
    return at


def unusable(left_out: Counter[str], fault: MessageFault) -> str:
    """What messages with a fault are counted as: the first one's words stand for all."""
    return next((key for key in left_out if key.startswith(UNUSABLE)), f"{UNUSABLE}{printable(str(fault))}")


def pictured(bag: Bag, topic: str, source: Source, pieces: Sequence[Piece],
             left_out: Counter[str]) -> Iterator[Episode]:
    """Yield the pieces with their images, which are read once more; a broken image cuts its piece in two."""
    wanted = iter([(piece, index) for piece in pieces for index in range(len(piece.image))])
    piece, index = next(wanted, (None, 0))
    frames: list[Frame] = []
    for number, (one, beside) in enumerate(views(bag, topic, source.depth)):
        while piece is not None and piece.image[index] == number:
            try:
                frames.append((picture(one.message, one.kind, source.crop), measured(beside, source, left_out)))
            except MessageFault as fault:
                left_out[unusable(left_out, fault)] += 1
                yield from whole(piece, index, frames)
                frames = []
            if index + 1 == len(piece.image):
                yield from whole(piece, index + 1, frames)
                frames = []
            piece, index = next(wanted, (None, 0))


def views(bag: Bag, image: str, depth: str) -> Iterator[tuple[Received, Received | None]]:
    """Yield each image with the depth image that was recorded last before it, by BESIDE seconds at most."""
    last: Received | None = None
    for one in bag.messages(image, *([depth] if bag.topics.get(depth) == DEPTHS else [])):
        if one.topic == image:
            yield one, last if last and one.recorded - last.recorded <= BESIDE else None
        else:
            last = one


def measured(beside: Received | None, source: Source, left_out: Counter[str]) -> np.ndarray | None:
    """The depth (64, 64) of a frame; None where there is none, or none that can be used."""
    try:
        return None if beside is None else depth(beside.message, beside.kind, source.depth_crop)
    except MessageFault:
        left_out[NO_DEPTH] += 1
        return None


def whole(piece: Piece, end: int, frames: list[Frame]) -> Iterator[Episode]:
    """The episode of the frames before `end` of a piece, as many as there are images; none where it has no move.

    It has depth where every frame has.
    """
    if len(frames) > 1:
        first = end - len(frames)
        near = [metres for _, metres in frames if metres is not None]
        yield Episode(np.stack([image for image, _ in frames]), np.array(piece.action[first:end - 1], np.int64),
                      piece.pose[first:end].copy(), np.zeros(len(frames) - 1, bool),
                      depth=np.stack(near) if len(near) == len(frames) else None)
