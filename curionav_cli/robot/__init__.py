"""A simulated robot with odometry drift: true state, measurements, estimate, navigation, docking."""
