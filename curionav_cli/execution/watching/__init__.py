"""curionav watch: a page on this machine that shows runs as they go on; it reads their folders and writes nothing."""
