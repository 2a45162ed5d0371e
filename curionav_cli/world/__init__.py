"""The simulated world: scenes, motion, rendering, and Gymnasium environments."""
