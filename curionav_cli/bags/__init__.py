"""Bags: episodes written as MCAP for ROS tools, and episodes read from anybody's bags (MCAP, ROS 2, ROS 1)."""
