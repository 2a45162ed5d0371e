"""A folder of objects at a URL: file:///DIR, or s3://BUCKET/PREFIX on any service that speaks S3.

Endpoint and credentials come from the environment or the standard files (credentials.py) and stay inside obstore.
Nothing is relied on that some S3 servers get wrong: conditional writes, checksums of the server, metadata.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta
from functools import cached_property, partial
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from curionav_cli.errors import ConfigError, Denied, Unreachable
from curionav_cli.remote.credentials import emptied, s3_options
from curionav_cli.remote.store_errors import unreachable

EXAMPLES = "storage=file:///srv/robot or storage=s3://BUCKET/PREFIX"


class TooLarge(ValueError):
    """An object is larger than it may be; nothing of it is in memory."""


class ObjectStore:
    """Objects by key, as 'episodes/000003.json'. What cannot be answered now raises Unreachable."""

    def __init__(self, make: Callable[[], Any], root: Path | None = None):
        """make: obstore's object store, once it is needed; root: where its objects lie, if in a folder."""
        self.make, self.root = make, root

    @classmethod
    def at(cls, url: str, timeout: float) -> ObjectStore:
        """timeout: seconds that one request may take. Raises ConfigError for another kind of URL."""
        from obstore.store import LocalStore, S3Store  # loaded by who stores remotely

        scheme, place, path = parts(url)
        if scheme == "file":
            return cls(partial(LocalStore, path), Path(path))
        client: Any = {"timeout": f"{timeout:g}s", "connect_timeout": f"{min(timeout, 10):g}s", "allow_http": True}
        retry: Any = {"max_retries": 1, "retry_timeout": timedelta(seconds=timeout)}
        emptied(os.environ)
        who: Any = {**s3_options(os.environ, Path.home()), "disable_bulk_delete": True}  # which some do not know
        return cls(partial(S3Store, place, prefix=path.strip("/") or None, client_options=client, retry_config=retry,
                           **who))

    @cached_property
    def objects(self) -> Any:
        """As obstore has it."""
        return self.make()

    def create(self) -> None:
        """Make the folder; a bucket is made by who administers the service."""
        if self.root:
            with answering():
                self.root.mkdir(parents=True, exist_ok=True)
            if not self.root.is_dir():
                raise Denied("its folder cannot be made")

    def put(self, key: str, raw: bytes | Path) -> None:
        """Whole or not at all, where the service keeps what it promises."""
        import obstore

        with self.open() as found:
            found.append(obstore.put(self.objects, key, raw))
        if not found:
            raise Unreachable("it has no place for what is put there")

    def get(self, key: str, most: int) -> bytes | None:
        """None: it is not there. Raises TooLarge for more than `most` bytes, whatever its size is said to be."""
        import obstore

        with self.open() as found:
            answer = obstore.get(self.objects, key)
            if answer.meta["size"] > most:
                raise TooLarge(f"it has {answer.meta['size']} bytes, of at most {most}")
            found.append(gathered(answer.stream(min_chunk_size=1 << 20), most))
        return found[0] if found else None

    def size(self, key: str) -> int | None:
        """Bytes; None: it is not there."""
        import obstore

        with self.open() as found:
            found.append(obstore.head(self.objects, key)["size"])
        return found[0] if found else None

    def names(self, folder: str, pattern: re.Pattern[str]) -> list[str]:
        """The last parts of the keys directly below `folder` that match wholly, in order; others are no names."""
        import obstore

        seen = set()
        with self.open():
            for batch in obstore.list(self.objects, folder):
                keys = (str(entry["path"]).rpartition("/") for entry in batch)
                seen |= {name for above, _, name in keys if above == folder and pattern.fullmatch(name)}
        return sorted(seen)

    def delete(self, key: str) -> None:
        """What is not there already stays so."""
        import obstore

        with self.open():
            obstore.delete(self.objects, key)

    @contextmanager
    def open(self) -> Iterator[list[Any]]:
        """For one request. An object that is not there ends it quietly: the list that is yielded stays empty."""
        if self.root and not self.root.is_dir():
            raise Unreachable(f"there is no folder {self.root}")
        with answering() as found:
            yield found


@contextmanager
def answering() -> Iterator[list[Any]]:
    """What goes wrong becomes Unreachable, or Denied, in our words: what a service says may hold secrets."""
    from obstore.exceptions import BaseError

    told: Unreachable | None = None
    try:
        yield []
    except TooLarge:
        raise
    except (BaseError, OSError, ValueError, TimeoutError) as error:
        if isinstance(error, FileNotFoundError) and "NoSuchBucket" not in str(error):
            return
        told = unreachable(str(error))
    if told:
        raise told from None


def gathered(chunks: Any, most: int) -> bytes:
    """Raises TooLarge once they are more than was said."""
    whole = bytearray()
    for chunk in chunks:
        whole += memoryview(chunk)
        if len(whole) > most:
            raise TooLarge(f"it goes on after {most} bytes")
    return bytes(whole)


def parts(url: str) -> tuple[str, str, str]:
    """(scheme, bucket, path). Raises ConfigError, which does not repeat what may hold a password."""
    split = urlsplit(url)
    if "@" in split.netloc or split.query or split.fragment:
        raise ConfigError("storage: keys and passwords do not belong into a URL, which is written into the run's "
                          f"folder. Give them as AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, and only {EXAMPLES}.")
    path = unquote(split.path)
    if split.scheme == "s3" and split.netloc and ".." not in path.split("/"):
        return "s3", split.netloc, path
    if split.scheme == "file" and split.netloc in ("", "localhost") and path.startswith("/"):
        return "file", "", os.path.normpath(path)
    raise ConfigError(f"storage: {url} is no place that is known. Use {EXAMPLES}.")
