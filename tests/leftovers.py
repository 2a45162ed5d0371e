"""What is compared where two runs must be the same run."""

import json

from curionav_cli.storage.run_folder import RunFolder


def leftovers(run):
    """All that a run leaves behind, without what a clock wrote."""
    files = {}
    for folder in ("episodes", "predictions", "figures", "checkpoint"):
        for path in sorted((run / folder).rglob("*")):
            if path.is_file():
                files[str(path.relative_to(run))] = path.read_bytes()
    rows = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    files["metrics"] = [{k: v for k, v in row.items() if "seconds_" not in k} for row in rows]
    files["status"] = RunFolder(run).status
    files["replay"] = files["status"].pop("replay", None)
    return files
