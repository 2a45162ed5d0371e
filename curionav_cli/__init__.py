"""curionav: a robot learns to navigate from scratch with a world model and curiosity."""

__version__ = "0.1.0"
