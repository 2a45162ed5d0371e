"""Robot and training server, which meet at an object store."""
