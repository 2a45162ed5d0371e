#!/usr/bin/env bash
# One would guess that a reader made for streams gives the messages of all finished chunks of a recording that still goes on.
# NonSeekingReader sorts by time unless asked otherwise: it reads to the end, raises EndOfFile there, and gives none of the 96
# messages that are on disk; with log_time_order=False it gives all of them first. mcap 1.6.0, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check mcap==1.6.0

env/bin/python - <<'EOF'
from importlib.metadata import version

from mcap.exceptions import EndOfFile
from mcap.reader import NonSeekingReader
from mcap.writer import Writer

print("mcap", version("mcap"))
file = open("growing.mcap", "wb")
writer = Writer(file, chunk_size=1000)
writer.start()
channel = writer.register_channel("/a", "json", writer.register_schema("S", "jsonschema", b"{}"))
for time in range(100):
    writer.add_message(channel, log_time=time, publish_time=time, data=b"x" * 100)
file.flush()  # and the recording goes on
seen = {}
for by_time in (True, False):
    seen[by_time] = []
    with open("growing.mcap", "rb") as stream:
        try:
            for _, _, message in NonSeekingReader(stream).iter_messages(log_time_order=by_time):
                seen[by_time].append(message.log_time)
        except EndOfFile:
            print(f"log_time_order={by_time}: {len(seen[by_time])} of 100 messages, then EndOfFile")
assert seen == {True: [], False: list(range(96))}
writer.finish()
file.close()
with open("growing.mcap", "rb") as stream:
    whole = [message.log_time for _, _, message in NonSeekingReader(stream).iter_messages()]
print("finished:", len(whole), "messages in the default order")
assert whole == list(range(100))
EOF
