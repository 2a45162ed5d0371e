"""What is compared where two runs must be the same run."""

import json

from curionav_cli.storage.run_folder import RunFolder


def repeatable(rows):
    """Rows of metrics.jsonl without what was measured of the process: seconds and memory."""
    return [{key: value for key, value in row.items() if "seconds_" not in key and key != "peak_memory"}
            for row in rows]


def leftovers(run):
    """All that a run leaves behind, without what was measured of the process."""
    files = {}
    for folder in ("episodes", "predictions", "figures", "checkpoint"):
        for path in sorted((run / folder).rglob("*")):
            if path.is_file():
                files[str(path.relative_to(run))] = path.read_bytes()
    rows = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    files["metrics"] = repeatable(rows)
    files["status"] = RunFolder(run).status
    files["replay"] = files["status"].pop("replay", None)
    return files
