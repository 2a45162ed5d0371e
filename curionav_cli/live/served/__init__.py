"""A scene or ROS map as a robot for others: the simulated robot behind the topics and actions of a profile."""
