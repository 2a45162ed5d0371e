"""The object store: which URLs are accepted, where keys come from, and that S3 servers of others work."""

from __future__ import annotations

from pathlib import Path

import pytest
from remote.pair import Pair
from servers import Place

from curionav_cli.errors import ConfigError, Unreachable
from curionav_cli.remote.credentials import drop_empty, s3_options
from curionav_cli.remote.object_store import ObjectStore, parts
from curionav_cli.remote.protocol import LATEST, Pointer, parsed, written

SECRET = "wJalrXUtnFEMI"


@pytest.mark.parametrize(("url", "place"), [
    ("file:///srv/robot", ("file", "", "/srv/robot")), ("file:///srv/a/../b%20c", ("file", "", "/srv/b c")),
    ("file://localhost/srv", ("file", "", "/srv")), ("s3://bucket/a/b", ("s3", "bucket", "/a/b")),
    ("s3://bucket", ("s3", "bucket", "")),
])
def test_accepted_urls(url: str, place: tuple[str, str, str]) -> None:
    assert parts(url) == place


@pytest.mark.parametrize("url", [
    f"s3://AKIA:{SECRET}@bucket/x", f"s3://bucket/x?secret={SECRET}", f"file:///x#{SECRET}", "ftp://x/y",
    "file://srv/x", "s3://b/../../x", "s3:///x", "/srv/robot", "", "file:relative",
])
def test_other_urls_are_refused_without_repeating_secrets(url: str) -> None:
    with pytest.raises(ConfigError, match="storage: ") as refused:
        parts(url)
    assert SECRET not in str(refused.value)


def test_a_key_comes_from_the_environment_or_from_the_files_of_aws(tmp_path: Path) -> None:
    """The environment is read by obstore itself; a profile has its own section."""
    aws = tmp_path / ".aws"
    aws.mkdir()
    (aws / "credentials").write_text(f"[default]\naws_access_key_id = A\naws_secret_access_key = {SECRET}\n"
                                     "[lab]\naws_access_key_id = L\naws_secret_access_key = l%l\naws_session_token=t\n")
    (aws / "config").write_text("[profile lab]\nregion = eu-west-1\nendpoint_url = http://10.0.0.1:9\n")
    both = {"access_key_id": "A", "secret_access_key": SECRET, "region": "us-east-1"}
    assert s3_options({}, tmp_path) == both
    lab = {"access_key_id": "L", "secret_access_key": "l%l", "session_token": "t", "region": "eu-west-1",
           "endpoint": "http://10.0.0.1:9"}
    assert s3_options({"AWS_PROFILE": "lab"}, tmp_path) == lab
    here = {"AWS_ACCESS_KEY_ID": "E", "AWS_REGION": "x", "AWS_ENDPOINT_URL": "http://e"}
    assert s3_options(here, tmp_path) == {"endpoint": "http://e"}
    with pytest.raises(ConfigError, match="no key for the S3 service"):
        s3_options({"AWS_ENDPOINT_URL": "http://e"}, tmp_path / "empty")
    (aws / "credentials").write_text(f"aws_secret_access_key = {SECRET}")
    with pytest.raises(ConfigError, match="cannot be read as AWS's tools write it") as refused:
        s3_options({}, tmp_path)
    assert SECRET not in str(refused.value) and refused.value.__context__ is None


@pytest.mark.parametrize("address", [f"127.0.0.1:9000/{SECRET}", "localhost:9000", "s3://x", "http://", "http://:9000",
                                     "http://h:port", "http://h:99999", f"http://a b/{SECRET}", "https://h:0",
                                     "ftp://h"])
@pytest.mark.parametrize("name", ["AWS_ENDPOINT_URL", "AWS_ENDPOINT", "AWS_ENDPOINT_URL_S3"])
def test_an_address_that_is_no_url_is_answered_before_the_library_sees_it(
        tmp_path: Path, name: str, address: str) -> None:
    with pytest.raises(ConfigError, match=r"is no URL\. Write it as http://HOST:PORT or https://HOST") as refused:
        s3_options({name: address, "AWS_ACCESS_KEY_ID": "A"}, tmp_path)
    assert SECRET not in str(refused.value) and refused.value.__context__ is None
    assert s3_options({name: " https://h/x ", "AWS_ACCESS_KEY_ID": "A"}, tmp_path)["endpoint"] == "https://h/x"


def test_what_is_set_and_empty_counts_as_unset(tmp_path: Path) -> None:
    environment = {"AWS_ENDPOINT_URL": "", "AWS_ENDPOINT": " ", "AWS_REGION": "", "AWS_ACCESS_KEY_ID": "A", "HOME": ""}
    drop_empty(environment)
    assert environment == {"AWS_ACCESS_KEY_ID": "A", "HOME": ""}
    assert s3_options(environment, tmp_path) == {"region": "us-east-1"}


def test_a_folder_that_is_not_mounted_is_not_made_anew(tmp_path: Path) -> None:
    store = ObjectStore.at((tmp_path / "mnt" / "x").as_uri(), 5)
    with pytest.raises(Unreachable, match="there is no folder"):
        store.put("episodes/a", b"x")
    assert not (tmp_path / "mnt").exists()


def test_everyday_use_on_the_servers_of_others(real: Place, tmp_path: Path, an_episode) -> None:
    """A little of everything; all of it runs with -m slow."""
    with Pair(real.url, tmp_path, an_episode).at_work() as pair:
        for seq in range(3):
            pair.record(seq)
            pair.dock()
        assert pair.acting == pair.expected(0, 1, 2) and pair.said == {"robot": [], "server": []}
        pair.boot_robot()
        pair.boot_server()
        pair.record(3)
        [marker] = pair.outbox.waiting()
        pair.store().put(f"episodes/{marker.name}.npz", b"half of it")
        pair.store().put(f"episodes/{marker.name}.json", written(marker))
        pair.serve()
        assert list(pair.ledger.refused()) == [marker.name]
        pair.dock()
        assert pair.acting == pair.expected(0, 1, 2, 3)
        assert parsed(Pointer, pair.store().get(LATEST, 999)).version == 4
        with pytest.raises(Unreachable, match="it has no such bucket"):
            ObjectStore.at("s3://no-such-bucket/x", 5).get(LATEST, 999)
