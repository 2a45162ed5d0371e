"""Which topics of a bag are read: those of a robot's profile, conf/robot/profile/*.yaml."""

from __future__ import annotations

from dataclasses import dataclass

import yaml

from curionav_cli.live.sensors import full
from curionav_cli.live.settings import Profile
from curionav_cli.places import conf_dir
from curionav_cli.safe_yaml import LOADER

COMPRESSED = "/compressed"  # the end of a topic of compressed images, whose raw ones have the name before it
FOLDER = conf_dir() / "robot" / "profile"


@dataclass(frozen=True)
class Source:
    """The topics of a kind of robot. image: the compressed or the raw one; crop, depth_crop: see live.settings.View."""

    profile: str
    image: str
    odom: str
    depth: str = ""
    crop: float = 1.0
    depth_crop: float = 1.0

    @property
    def images(self) -> tuple[str, ...]:
        """The topics that may hold its images: the profile's first, then the same uncompressed or compressed."""
        plain = self.image.removesuffix(COMPRESSED)
        return self.image, plain if plain != self.image else self.image + COMPRESSED


def names() -> tuple[str, ...]:
    """The profiles that come with curionav."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def known() -> list[Source]:
    """The topics of every profile that comes with curionav."""
    return [named(name) for name in names()]


def named(name: str) -> Source:
    """The topics of a profile that comes with curionav."""
    raw = yaml.load((FOLDER / f"{name}.yaml").read_text(), LOADER)["robot"]["profile"]
    image = raw["image"]
    depth = raw.get("depth", {})
    return Source(name, image["name"], raw["odom"]["name"], depth.get("name", ""), float(image.get("crop", 1.0)),
                  float(depth.get("crop", 1.0)))


def of(profile: Profile, namespace: str) -> Source:
    """The topics of these settings of a robot."""
    depth = full(namespace, profile.depth.name) if profile.depth.name else ""
    return Source(profile.name, full(namespace, profile.image.name), full(namespace, profile.odom.name), depth,
                  profile.image.crop, profile.depth.crop)
