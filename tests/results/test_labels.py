"""Which runs are one arm, and the shortest name that cannot be mistaken."""

import pytest

from curionav_cli.results.labels import arm_settings, differences, distinct_names, labels, world_labels, world_settings

PLAIN = {"agent": {"name": "lbs_dreamer", "curiosity": "lbs", "gamma": 0.95, "steps": 3},
         "robot": {"name": "ideal"}, "loop": {"steps": 500, "iterations": 100},
         "env": {"name": "small_room", "engine": "numpy", "note": "", "walls": [[0, 0, 1, 1]]}, "seed": 0}


def changed(key, value):
    part, name = key.split(".")
    return {**PLAIN, part: {**PLAIN[part], name: value}}


def named(*runs, presets=None):
    return labels(["lbs_dreamer"] * len(runs), [arm_settings(run) for run in runs], presets or ["cpu"] * len(runs))


def test_seed_engine_and_world_make_no_other_arm():
    runs = [PLAIN, {**PLAIN, "seed": 4}, changed("env.engine", "numba"), changed("env.name", "lab")]
    assert named(*runs) == ["lbs_dreamer"] * 4
    worlds = [world_settings(run) for run in runs]
    assert worlds[0] == worlds[1] == worlds[2] != worlds[3]
    assert world_settings(changed("env.note", "nicer")) == worlds[0]
    assert world_settings({**PLAIN, "learner": "remote"}) == worlds[0], "where it learned is no part of the world"


@pytest.mark.parametrize(("key", "value", "said"), [
    ("agent.curiosity", "shuffled", ("curiosity=lbs", "curiosity=shuffled")),
    ("loop.iterations", 20, ("iterations=100", "iterations=20")),
    ("loop.steps", 100, ("loop.steps=500", "loop.steps=100")),  # agent.steps is another
    ("agent.gamma", 0.0001, ("gamma=0.95", "gamma=0.0001")),
    ("agent.gamma", None, ("gamma=0.95", "gamma=null")),
])
def test_one_setting_that_differs_is_the_name(key, value, said):
    assert named(PLAIN, changed(key, value), PLAIN) == [f"lbs_dreamer {said[0]}", f"lbs_dreamer {said[1]}",
                                                        f"lbs_dreamer {said[0]}"]


def test_no_more_settings_are_named_than_it_takes():
    one = changed("agent.gamma", 0.9)
    both = {**one, "loop": {"steps": 500, "iterations": 20}}
    third = {**one, "loop": {"steps": 500, "iterations": 30}}
    assert named(PLAIN, both, third) == [f"lbs_dreamer iterations={n}" for n in (100, 20, 30)]
    assert named(PLAIN, one, both) == ["lbs_dreamer gamma=0.95 iterations=100", "lbs_dreamer gamma=0.9 iterations=100",
                                       "lbs_dreamer gamma=0.9 iterations=20"]
    arms = dict(zip("abc", map(arm_settings, (PLAIN, both, third))))
    assert differences(arms) == {"agent.gamma": {"a": "0.95", "b": "0.9", "c": "0.9"},
                                 "loop.iterations": {"a": "100", "b": "20", "c": "30"}}


def test_a_preset_stands_for_what_it_changes_and_for_nothing_else():
    paper = {**changed("agent.gamma", 0.99), "loop": {"steps": 500, "iterations": 10}}
    shuffled = changed("agent.curiosity", "shuffled")
    assert named(PLAIN, paper, presets=["cpu", "paper"]) == ["lbs_dreamer scale=cpu", "lbs_dreamer scale=paper"]
    assert named(PLAIN, PLAIN, presets=["cpu", "paper"]) == ["lbs_dreamer"] * 2
    assert named(PLAIN, shuffled, presets=["cpu", "paper"])[1] == "lbs_dreamer curiosity=shuffled"
    assert named(PLAIN, paper, shuffled, presets=["cpu", "paper", "cpu"])[1:] == [
        "lbs_dreamer scale=paper curiosity=lbs", "lbs_dreamer scale=cpu curiosity=shuffled"]


def test_a_setting_that_an_older_version_did_not_have_and_a_long_one():
    old = {**PLAIN, "agent": {key: value for key, value in PLAIN["agent"].items() if key != "curiosity"}}
    assert named(old, PLAIN) == ["lbs_dreamer curiosity=?", "lbs_dreamer curiosity=lbs"]
    long = [changed("agent.curiosity", list(range(n))) for n in (30, 31)]
    first, second = named(*long)
    assert first != second and len(first) < 40


def test_agents_of_different_names_are_not_distinguished_by_their_settings():
    runs = [PLAIN, changed("agent.curiosity", "none"), PLAIN]
    assert labels(["a", "a", "b"], [arm_settings(run) for run in runs], ["cpu"] * 3) == [
        "a curiosity=lbs", "a curiosity=none", "b"]


def worlds_of(*paths, radius=None):
    """Worlds of these maps, a different one for each letter that a path begins with."""
    envs = [{"name": "map", "map": path and f"/data/{path}"} for path in paths]
    return world_labels(envs, [{"env.name": "map", "env.radius": radius or 0.2, "visitable cells (sha256)": path[:1]}
                               for path in paths])


@pytest.mark.parametrize(("paths", "said"), [
    (["a/office.yaml", "b/office.yaml"], ["a/office", "b/office"]),
    (["a/office/map.yaml", "b/home/map.yaml"], ["office", "home"]),
    (["a/x/office.yaml", "b/x/office.yaml", "c/office.yaml"], ["a/x/office", "b/x/office", "c/office"]),
    (["a/office/map.yaml", "b/office/map.yaml", "a/office/map.yaml"], ["a/office", "b/office", "a/office"]),
    (["a/office.yaml"] * 2, ["office", "office"]),
    (["a/office.yaml", "a_moved/office.yaml"], ["office", "office"]),  # the same cells
    (["office.yaml", "Office/office.yml"], ["data/office", "Office/office"]),
])
def test_maps_of_one_name_are_distinguished_by_the_shortest_ending_of_their_paths(paths, said):
    assert worlds_of(*paths) == said


def test_files_that_differ_in_their_extension_only_are_distinguished():
    assert distinct_names(["/d/office.yaml", "/d/office.yml"]) == {"/d/office.yaml": "office.yaml",
                                                               "/d/office.yml": "office.yml"}


def test_a_setting_that_is_a_path_is_told_by_its_ending_and_not_by_a_checksum():
    long = "/a/long/way/to/the/folder/of/overlays"
    assert labels(["room"] * 2, [{"env.overlay": f"{long}/{name}.yaml"} for name in ("north", "south")], [""] * 2) == [
        "room overlay=north", "room overlay=south"]
