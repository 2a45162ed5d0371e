"""Whom an S3 service takes us for: from the environment, which obstore reads itself, or the files that AWS's own
tools use, ~/.aws/credentials and ~/.aws/config with AWS_PROFILE. Nothing here is printed or saved."""

from __future__ import annotations

import configparser
import re
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from urllib.parse import urlsplit

from curionav_cli.errors import ConfigError

ELSEWHERE = ("AWS_WEB_IDENTITY_TOKEN_FILE", "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
             "AWS_CONTAINER_CREDENTIALS_FULL_URI", "AWS_SKIP_SIGNATURE")


def s3_options(environment: Mapping[str, str], home: Path) -> dict[str, str]:
    """What obstore must be told beside the environment.

    Raises ConfigError where a service of one's own has no key, or an address that is no URL.
    """
    profile = environment.get("AWS_PROFILE", "default")
    keys = section(Path(environment.get("AWS_SHARED_CREDENTIALS_FILE", home / ".aws" / "credentials")), profile)
    general = section(Path(environment.get("AWS_CONFIG_FILE", home / ".aws" / "config")),
                      profile if profile == "default" else f"profile {profile}")
    held = {**general, **keys}
    options = {}
    if "AWS_ACCESS_KEY_ID" not in environment and "aws_access_key_id" in held:
        names = ("access_key_id", "secret_access_key", "session_token")
        options = {name: held[f"aws_{name}"] for name in names if f"aws_{name}" in held}
    if not {"AWS_REGION", "AWS_DEFAULT_REGION"} & environment.keys():
        options["region"] = held.get("region", "us-east-1")
    endpoint = next((environment[name] for name in ("AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT")
                     if name in environment), held.get("endpoint_url"))
    if endpoint:
        options["endpoint"] = as_url(endpoint)
        if "AWS_ACCESS_KEY_ID" not in environment and "access_key_id" not in options \
                and not any(name in environment for name in ELSEWHERE):
            raise ConfigError("storage: no key for the S3 service. Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
                              "AWS_PROFILE for one in ~/.aws/credentials; AWS_SKIP_SIGNATURE=true for none.")
    return options


def emptied(environment: MutableMapping[str, str]) -> None:
    """Take out what is set and empty, which counts as unset: obstore would take it for an answer."""
    for name in [name for name, value in environment.items() if name.startswith("AWS_") and not value.strip()]:
        del environment[name]


def as_url(endpoint: str) -> str:
    """An S3 service's address as obstore can take it. Raises ConfigError, which does not quote what may hold a key."""
    try:
        split = urlsplit(endpoint.strip())
        fine = split.scheme in ("http", "https") and bool(split.hostname) and split.port != 0
    except ValueError:  # a port that is no number, or too large
        fine = False
    if not fine or re.search(r"[^!-~]", endpoint.strip()):
        raise ConfigError("storage: the address of the S3 service (AWS_ENDPOINT_URL, or endpoint_url in ~/.aws/config) "
                          "is no URL. Write it as http://HOST:PORT or https://HOST.")
    return endpoint.strip()


def section(path: Path, name: str) -> dict[str, str]:
    """A part of an INI file; {} where there is no such file or part. Raises ConfigError for one that is no INI."""
    parser = configparser.RawConfigParser()
    broken = False
    try:
        parser.read(path)
    except (configparser.Error, UnicodeDecodeError):
        broken = True  # the error itself quotes the file
    if broken:
        raise ConfigError(f"{path} cannot be read as AWS's tools write it.")
    return dict(parser[name]) if parser.has_section(name) else {}
