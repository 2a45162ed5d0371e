"""Storage: the run folder, its episodes, replay, checkpoints, metrics."""
