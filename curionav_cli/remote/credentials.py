"""Credentials of an S3 service, from the environment or from the files of AWS's own tools.

obstore reads the environment itself; this reads ~/.aws/credentials and ~/.aws/config, with AWS_PROFILE. Nothing here is
printed or saved.
"""

from __future__ import annotations

import configparser
import re
from collections.abc import Mapping, MutableMapping
from pathlib import Path
from urllib.parse import urlsplit

from curionav_cli.errors import ConfigError

OTHER_SOURCES = ("AWS_WEB_IDENTITY_TOKEN_FILE", "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
             "AWS_CONTAINER_CREDENTIALS_FULL_URI", "AWS_SKIP_SIGNATURE")


def s3_options(environment: Mapping[str, str], home: Path) -> dict[str, str]:
    """Options of obstore's S3Store that the environment does not hold: key, region, endpoint.

    Raises ConfigError where an endpoint is set and no key is found, or its address is no URL.
    """
    profile = environment.get("AWS_PROFILE", "default")
    keys = section(Path(environment.get("AWS_SHARED_CREDENTIALS_FILE", home / ".aws" / "credentials")), profile)
    general = section(Path(environment.get("AWS_CONFIG_FILE", home / ".aws" / "config")),
                      profile if profile == "default" else f"profile {profile}")
    profiled = {**general, **keys}
    options = {}
    if "AWS_ACCESS_KEY_ID" not in environment and "aws_access_key_id" in profiled:
        names = ("access_key_id", "secret_access_key", "session_token")
        options = {name: profiled[f"aws_{name}"] for name in names if f"aws_{name}" in profiled}
    if not {"AWS_REGION", "AWS_DEFAULT_REGION"} & environment.keys():
        options["region"] = profiled.get("region", "us-east-1")
    endpoint = next((environment[name] for name in ("AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT")
                     if name in environment), profiled.get("endpoint_url"))
    if endpoint:
        options["endpoint"] = as_url(endpoint)
        if "AWS_ACCESS_KEY_ID" not in environment and "access_key_id" not in options \
                and not any(name in environment for name in OTHER_SOURCES):
            raise ConfigError("storage: no key for the S3 service. Set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, or "
                              "AWS_PROFILE for one in ~/.aws/credentials; AWS_SKIP_SIGNATURE=true for none.")
    return options


def drop_empty(environment: MutableMapping[str, str]) -> None:
    """Remove AWS_ variables that are empty, which count as unset: obstore would use them."""
    for name in [name for name, value in environment.items() if name.startswith("AWS_") and not value.strip()]:
        del environment[name]


def as_url(endpoint: str) -> str:
    """The address of an S3 service, stripped. Raises ConfigError, which does not quote what may hold a key."""
    try:
        split = urlsplit(endpoint.strip())
        valid = split.scheme in ("http", "https") and bool(split.hostname) and split.port != 0
    except ValueError:  # a port that is no number, or too large
        valid = False
    if not valid or re.search(r"[^!-~]", endpoint.strip()):
        raise ConfigError("storage: the address of the S3 service (AWS_ENDPOINT_URL, or endpoint_url in ~/.aws/config) "
                          "is no URL. Write it as http://HOST:PORT or https://HOST.")
    return endpoint.strip()


def section(path: Path, name: str) -> dict[str, str]:
    """A section of an INI file; {} where there is no such file or section. Raises ConfigError where it is no INI."""
    parser = configparser.RawConfigParser()
    broken = False
    try:
        parser.read(path)
    except (configparser.Error, UnicodeDecodeError):
        broken = True  # raised below, outside `except`: the error itself quotes the file
    if broken:
        raise ConfigError(f"{path} cannot be read as AWS's tools write it.")
    return dict(parser[name]) if parser.has_section(name) else {}
