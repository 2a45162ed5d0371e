"""What the page of `curionav watch` shows of runs that go on: read from their folders, and only what is new."""
