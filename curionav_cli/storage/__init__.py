"""What outlives a process: the run folder, its episodes and its checkpoints."""
