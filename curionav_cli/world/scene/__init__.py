"""Scenes: reading files and ROS maps, building boxes, reachable cells, changes between episodes."""
