"""Frontier-based exploration on the robot's own map, without privileges and without learning."""
