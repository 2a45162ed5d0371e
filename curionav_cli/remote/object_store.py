"""Objects in a storage at a URL: file:///DIR, or s3://BUCKET/PREFIX on any service that speaks S3.

Endpoint and credentials come from the environment or the standard files (credentials.py) and stay inside obstore.
Conditional writes, server-side checksums and metadata are not used, because some S3 servers get them wrong.
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
from curionav_cli.remote.credentials import drop_empty, s3_options
from curionav_cli.remote.store_errors import unreachable

EXAMPLES = "storage=file:///srv/robot or storage=s3://BUCKET/PREFIX"


class TooLarge(ValueError):
    """An object that is larger than allowed; nothing of it is kept in memory."""


class ObjectStore:
    """Objects by key, such as 'episodes/000003.json'. All requests raise Unreachable where the storage fails.

    make: creates obstore's store, when it is first needed. root: the folder of the objects, None on a server.
    """

    def __init__(self, make: Callable[[], Any], root: Path | None = None):
        self.make, self.root = make, root

    @classmethod
    def at(cls, url: str, timeout: float) -> ObjectStore:
        """The store at a URL. timeout: seconds that one request may take. Raises ConfigError for other URLs."""
        from obstore.store import LocalStore, S3Store  # loaded only where a storage is used

        scheme, place, path = parts(url)
        if scheme == "file":
            return cls(partial(LocalStore, path), Path(path))
        client: Any = {"timeout": f"{timeout:g}s", "connect_timeout": f"{min(timeout, 10):g}s", "allow_http": True}
        retry: Any = {"max_retries": 1, "retry_timeout": timedelta(seconds=timeout)}
        drop_empty(os.environ)
        options: Any = {**s3_options(os.environ, Path.home()), "disable_bulk_delete": True}  # some servers lack it
        return cls(partial(S3Store, place, prefix=path.strip("/") or None, client_options=client, retry_config=retry,
                           **options))

    @cached_property
    def objects(self) -> Any:
        """The store of obstore."""
        return self.make()

    def create(self) -> None:
        """Make the folder; a bucket has to exist. Raises Denied where the folder cannot be made."""
        if self.root:
            with translated():
                self.root.mkdir(parents=True, exist_ok=True)
            if not self.root.is_dir():
                raise Denied("its folder cannot be made")

    def put(self, key: str, raw: bytes | Path) -> None:
        """Write an object, or upload a file, whole or not at all as far as the service guarantees it."""
        import obstore

        with self.request() as found:
            found.append(obstore.put(self.objects, key, raw))
        if not found:
            raise Unreachable("it has no place for what is put there")

    def get(self, key: str, most: int) -> bytes | None:
        """The bytes of an object; None where there is none.

        Raises TooLarge for more than `most` bytes, also where the declared size is smaller.
        """
        import obstore

        with self.request() as found:
            answer = obstore.get(self.objects, key)
            if answer.meta["size"] > most:
                raise TooLarge(f"it has {answer.meta['size']} bytes, of at most {most}")
            found.append(gathered(answer.stream(min_chunk_size=1 << 20), most))
        return found[0] if found else None

    def size(self, key: str) -> int | None:
        """The size of an object in bytes; None where there is none."""
        import obstore

        with self.request() as found:
            found.append(obstore.head(self.objects, key)["size"])
        return found[0] if found else None

    def names(self, folder: str, pattern: re.Pattern[str]) -> list[str]:
        """Names of the objects directly below `folder` that match `pattern` in full, sorted; others are left out."""
        import obstore

        matching = set()
        with self.request():
            for batch in obstore.list(self.objects, folder):
                keys = (str(entry["path"]).rpartition("/") for entry in batch)
                matching |= {name for above, _, name in keys if above == folder and pattern.fullmatch(name)}
        return sorted(matching)

    def delete(self, key: str) -> None:
        """Remove an object; nothing happens where there is none."""
        import obstore

        with self.request():
            obstore.delete(self.objects, key)

    @contextmanager
    def request(self) -> Iterator[list[Any]]:
        """Around one request, which appends its answer to the yielded list: that stays empty for a missing object."""
        if self.root and not self.root.is_dir():
            raise Unreachable(f"there is no folder {self.root}")
        with translated() as found:
            yield found


@contextmanager
def translated() -> Iterator[list[Any]]:
    """Turn errors into Unreachable or Denied in our own words, because the service's may hold secrets."""
    from obstore.exceptions import BaseError

    failure: Unreachable | None = None
    try:
        yield []
    except TooLarge:
        raise
    except (BaseError, OSError, ValueError, TimeoutError) as error:
        if isinstance(error, FileNotFoundError) and "NoSuchBucket" not in str(error):
            return
        failure = unreachable(str(error))
    if failure:
        raise failure from None


def gathered(chunks: Any, most: int) -> bytes:
    """The bytes of all chunks. Raises TooLarge once they exceed `most`."""
    whole = bytearray()
    for chunk in chunks:
        whole += memoryview(chunk)
        if len(whole) > most:
            raise TooLarge(f"it goes on after {most} bytes")
    return bytes(whole)


def parts(url: str) -> tuple[str, str, str]:
    """(scheme, bucket, path) of a URL. Raises ConfigError, which does not repeat what may hold a password."""
    split = urlsplit(url)
    if "@" in split.netloc or split.query or split.fragment:
        raise ConfigError("storage: keys and passwords do not belong into a URL, which is written into the run's "
                          f"folder. Give them as AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, and only {EXAMPLES}.")
    path = unquote(split.path)
    if split.scheme == "s3" and split.netloc and ".." not in path.split("/"):
        return "s3", split.netloc, path
    if split.scheme == "file" and split.netloc in ("", "localhost") and path.startswith("/"):
        return "file", "", os.path.normpath(path)
    raise ConfigError(f"storage: {url} is not supported. Use {EXAMPLES}.")
