"""Errors by exit code. The app prints the message and no traceback.

    UserError                 exit code 2: wrong use or config; the message says how to mend it
    ├── ConfigError           a setting, a group, an override
    ├── SceneError            a scene file in conf/env
    ├── MapError              a ROS map (YAML and image)
    ├── RunFolderError        not a run folder, half written, another environment or agent
    └── BagError              a bag that cannot be read, or holds nothing to learn from
    RunFailed                 exit code 1: the run began and could not go on (full disk, no memory, non-finite loss)
    Terminated                exit code 143: SIGTERM; like KeyboardInterrupt no Exception, so that nothing swallows it
    Unread                    exit code 141: the reader of the output is gone, as head -1 is; no Exception either

Errors between robot and server end no run; the one that meets them goes on with what it has:

    Unreachable               the storage gives no answer, or refuses
    └── Denied                it refuses, and waiting does not help: a wrong key, no bucket
    WeightsRefused            received weights that cannot be used
    EpisodeRefused            a received episode that cannot be used
"""


class UserError(Exception):
    """Wrong use or configuration: one to four lines that say what is wrong and how to mend it."""


class ConfigError(UserError):
    """A setting that does not exist, or has a value it cannot have."""


class SceneError(UserError):
    """A scene file that describes no world a robot can stand in."""


class MapError(UserError):
    """A ROS map that cannot be opened or explored."""


class RunFolderError(UserError):
    """A folder that holds no run, or not the run that was asked for."""


class BagError(UserError):
    """A bag (MCAP, ROS 2, ROS 1) that cannot be read, or holds nothing to learn from."""


class RunFailed(Exception):
    """The run began and could not go on; what it had saved is still there."""


class Unreachable(Exception):
    """A storage that cannot be used now. The message says why and never holds a key, a token or a password."""


class Denied(Unreachable):
    """A storage that refuses, where waiting does not help: a wrong key, no bucket, a folder without permission."""


class WeightsRefused(Exception):
    """Received weights that cannot be used."""


class EpisodeRefused(Exception):
    """A received episode that cannot be used."""


class Terminated(BaseException):
    """SIGTERM. What was saved is whole, and the run can be resumed."""


class Unread(BaseException):
    """A closed pipe: the output has no reader any more. What was saved is whole, and the run can be resumed."""


class SoundnessWarning(UserWarning):
    """A broken file on the disk; something sound is used instead."""
