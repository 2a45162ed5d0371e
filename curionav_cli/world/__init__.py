"""The simulated world: a scene that can be stood in, its motion, its camera, its gymnasium face."""
