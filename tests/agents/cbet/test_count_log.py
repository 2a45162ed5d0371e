"""Tables that last stand in a file beside the checkpoints: a checkpoint is its beginning, a save adds what is new."""

from __future__ import annotations

import pytest

from curionav_cli.agents.cbet.count_log import CountLog
from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.errors import RunFolderError


def made(tables=2):
    return {"states": Counts(tables, True), "changes": Counts(tables, True)}


def tables(counts):
    return [[list(table.items()) for table in one.tables] for one in counts.values()]


@pytest.fixture
def saved(tmp_path):
    """Three saves: the counts as they were, what was noted of each, and the log that wrote them."""
    path, log, counts, kept = tmp_path / "counts.log", CountLog(), made(), []
    for added in ([(0, b"aa"), (1, b"bb"), (0, b"aa")], [(0, b"cc"), (0, b"aa")], [(1, b"dd")]):
        for environment, key in added:
            counts["states"].add(environment, key)
        counts["changes"].add(0, b"wide" * 8)
        if added == [(1, b"dd")]:
            counts["changes"].clear(0)
            counts["changes"].add(0, b"late" * 8)
        noted = log.append(path, counts)
        kept.append((noted, tables(counts)))
    return path, log, counts, kept


def test_every_checkpoint_is_the_beginning_of_the_file(saved):
    path, _, _, kept = saved
    for noted, was in kept:
        found = made()
        CountLog().read(path, noted, found)
        assert tables(found) == was
    assert kept[1][0]["bytes"] - kept[0][0]["bytes"] == 4 * 12 + 2 * (2 + 8) + 32 + 8  # what is new, no more
    assert path.stat().st_size == kept[2][0]["bytes"]


def test_a_run_that_goes_on_from_an_older_one_cuts_off_what_follows(saved):
    path, _, counts, kept = saved
    content, log, again = path.read_bytes(), CountLog(), made()
    log.read(path, kept[1][0], again)
    again["states"].add(1, b"dd")
    again["changes"].add(0, b"wide" * 8)
    again["changes"].clear(0)
    again["changes"].add(0, b"late" * 8)
    assert log.append(path, again) == kept[2][0] and path.read_bytes() == content
    assert tables(again) == tables(counts)


def test_a_file_that_was_taken_away_or_harmed_is_named_or_written_anew(saved):
    path, log, counts, kept = saved
    whole = bytearray(path.read_bytes())
    whole[20] ^= 1
    path.write_bytes(whole)
    with pytest.raises(RunFolderError, match=r"counts\.log is not whole"):
        CountLog().read(path, kept[2][0], made())
    path.unlink()
    with pytest.raises(RunFolderError, match=r"counts\.log cannot be read"):
        CountLog().read(path, kept[2][0], made())
    noted, found = log.append(path, counts), made()
    CountLog().read(path, noted, found)
    assert tables(found) == tables(counts)


def test_an_agent_that_never_forgets_saves_what_an_episode_adds_and_reads_older_checkpoints(agent, room, tmp_path):
    ours, place = agent(name="cbet_lifelong", view="ego"), room(steps=20)
    sizes = []
    for index in range(3):
        place.episode(ours)
        ours.learn(place.replay, 1, int)
        (folder := tmp_path / f"{index:06d}").mkdir()
        ours.save(folder)
        sizes.append((tmp_path / "counts.log").stat().st_size)
    assert sizes[0] < sizes[1] < sizes[2]
    theirs = agent(seed=0, name="cbet_lifelong", view="ego")
    theirs.load(tmp_path / "000002")
    assert tables(theirs.learner.reward.counts) == tables(ours.learner.reward.counts)
    for one in ours.learner.reward.counts.values():  # as older versions wrote them: all in the checkpoint
        one.lasting = False
    (older := tmp_path / "older" / "000002").mkdir(parents=True)
    ours.save(older)
    assert not (older.parent / "counts.log").exists()
    again = agent(seed=0, name="cbet_lifelong", view="ego")
    again.load(older)
    assert tables(again.learner.reward.counts) == tables(ours.learner.reward.counts)
