"""LBS Dreamer, the agent of the paper: a world model that is surprised, and an actor that seeks it."""
