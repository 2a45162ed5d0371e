"""What can go wrong by a person's doing, by name. The app prints the message and no traceback.

    UserError                 exit code 2: wrong use or config; the message says how to mend it
    ├── ConfigError           a setting, a group, an override
    ├── SceneError            a scene file in conf/env
    ├── MapError              a ROS map (YAML and image)
    └── RunFolderError        not a run folder, half written, another environment or agent
    RunFailed                 exit code 1: the run began and could not go on (full disk, no memory, non-finite loss)
    Terminated                exit code 143: SIGTERM; like KeyboardInterrupt no Exception, so that nothing swallows it
    Unread                    exit code 141: whoever read the output left, as head -1 does; no Exception either

What goes wrong between robot and server ends no run; who meets it goes on with what it has:

    Unreachable               the storage gives no answer, or refuses
    └── Denied                it refuses, and waiting mends nothing: a wrong key, no bucket
    WeightsRefused            weights that came and cannot be used
    EpisodeRefused            an episode that came and cannot be used
"""


class UserError(Exception):
    """Wrong use or configuration: one to four lines that name the fault and its cure."""


class ConfigError(UserError):
    """A setting that does not exist, or has a value it cannot have."""


class SceneError(UserError):
    """A scene file that describes no world one can stand in."""


class MapError(UserError):
    """A ROS map that cannot be opened or explored."""


class RunFolderError(UserError):
    """A folder that holds no run, or not the run that was asked for."""


class RunFailed(Exception):
    """The run began and could not go on; what it had saved is still there."""


class Unreachable(Exception):
    """The storage cannot be used now. The message says why and never holds a key, a token or a password."""


class Denied(Unreachable):
    """The storage refuses, and waiting mends nothing: a wrong key, no bucket, a folder that is not ours."""


class WeightsRefused(Exception):
    """Weights that came and cannot be used."""


class EpisodeRefused(Exception):
    """An episode that came and cannot be used."""


class Terminated(BaseException):
    """SIGTERM: somebody wants the machine. What was saved is whole, and the run can be resumed."""


class Unread(BaseException):
    """Nobody reads the output any more (a closed pipe). What was saved is whole, and the run can be resumed."""


class SoundnessWarning(UserWarning):
    """Something on the disk is broken; what is sound is used instead."""
