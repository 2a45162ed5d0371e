"""What wandb and trackio hold of a run, read from their files."""

from __future__ import annotations

import json
import sqlite3
from typing import Any, NamedTuple

from curionav_cli.storage.loggers.wandb_file import records
from curionav_cli.storage.run_folder import RunFolder


class Held(NamedTuple):
    """id, name and group of a run, its rows in the order written, and the names of its figures."""

    id: str
    name: str
    group: str | None
    rows: list[dict[str, Any]]
    figures: set[str]


def in_wandb(run: RunFolder) -> Held:
    from wandb.proto import wandb_internal_pb2

    (path,) = run.path.glob("wandb/offline-run-*/*.wandb")
    about, rows = None, []
    for raw in records(path):
        record = wandb_internal_pb2.Record()
        record.ParseFromString(raw)
        if record.WhichOneof("record_type") == "run" and about is None:
            about = record.run
        if record.WhichOneof("record_type") == "history":
            rows.append({item.key or "/".join(item.nested_key): json.loads(item.value_json)
                         for item in record.history.item})
    assert about is not None
    plain = [{key: value for key, value in row.items() if key[0] != "_"} for row in rows]
    return split(about.run_id, about.display_name, about.run_group or None, plain)


def in_trackio(run: RunFolder) -> Held:
    (path,) = (run.path.parent / "trackio").glob("*.db")
    with sqlite3.connect(path) as base:
        found = base.execute("SELECT run_id, metrics FROM metrics WHERE run_name = ? ORDER BY id", (run.path.name,))
        ids, rows = zip(*found.fetchall())
        config = base.execute("SELECT config FROM configs WHERE run_name = ?", (run.path.name,)).fetchone()
    base.close()
    assert len(set(ids)) == 1
    return split(ids[0], run.path.name, json.loads(config[0])["_Group"], [json.loads(row) for row in rows])


def split(name: str, label: str, group: str | None, rows: list[dict[str, Any]]) -> Held:
    drawn = [key for row in rows for key in {"/".join(key.split("/")[:2]) for key in row if key.startswith("figures/")}]
    assert len(drawn) == len(set(drawn)), "a figure was logged twice"
    return Held(name, label, group, [row for row in rows if "episode" in row or "iterations" in row], set(drawn))


HELD = {"wandb": in_wandb, "trackio": in_trackio}
