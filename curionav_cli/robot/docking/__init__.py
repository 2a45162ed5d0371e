"""Docking as an action server: goal, feedback, result, cancel and preemption (ROS actionlib's names and states)."""
