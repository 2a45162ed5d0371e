"""Runs from their beginning to their end: launching, recording, interrupting, resuming."""
