"""A probe on disk is made once, and made anew to the byte where it is missing or broken."""

from pathlib import Path

import numpy as np
import pytest

from curionav_cli.errors import RunFolderError
from curionav_cli.probe import Probe
from curionav_cli.storage.probe_cache import kept


@pytest.fixture
def made():
    """made(): a small probe, and a list with an entry for each time that it was made."""
    times: list[int] = []

    def make() -> Probe:
        times.append(1)
        image = np.random.default_rng(0).integers(0, 256, (2, 4, 64, 64, 3), np.uint8)
        return Probe(image, np.ones((2, 3), np.int64), np.zeros((2, 4, 3)), 1)
    make.times = times
    return make


def test_it_is_made_once_and_again_where_it_is_gone_or_broken(tmp_path: Path, made) -> None:
    path = tmp_path / "probes" / "room.npz"
    first = kept(path, made)
    whole = path.read_bytes()
    assert kept(path, made).checksum == first.checksum and len(made.times) == 1
    path.write_bytes(whole[:-200])
    assert kept(path, made).checksum == first.checksum and path.read_bytes() == whole and len(made.times) == 2
    path.unlink()
    kept(path, made)
    assert path.read_bytes() == whole and [file.name for file in path.parent.iterdir()] == ["room.npz"]


def test_another_file_is_no_probe(tmp_path: Path, an_episode) -> None:
    an_episode().save(tmp_path / "episode.npz")
    with pytest.raises(RunFolderError):
        Probe.load(tmp_path / "episode.npz")
    odd = Probe(np.zeros((2, 4, 64, 64, 3), np.uint8), np.zeros((2, 5), np.int64), np.zeros((2, 4, 3)), 1)
    odd.save(tmp_path / "odd.npz")
    with pytest.raises(RunFolderError, match="holds no probe"):
        Probe.load(tmp_path / "odd.npz")
