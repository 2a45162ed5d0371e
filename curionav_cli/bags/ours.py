"""The topics of a bag that curionav wrote, beside those of the robot's profile.

ACTION: std_msgs/Float64MultiArray of one number, 0 forward, 1 left, 2 right; at the time of the image that it was
chosen on.
STATE: the same type: x, y (metres), yaw (radians) of the true pose, and whether the step that led there collided.
ESTIMATE: x, y, yaw that the robot estimated, of a robot whose odometry drifts. EPISODE: std_msgs/String, JSON, once.
"""

from __future__ import annotations

ACTION, STATE, ESTIMATE, EPISODE = "/action", "/state", "/estimate", "/episode"
TF, TF_STATIC, MAP = "/tf", "/tf_static", "/map"
NUMBERS, TEXT = "std_msgs/msg/Float64MultiArray", "std_msgs/msg/String"
MARK = "curionav"  # a key of EPISODE's JSON; its value: the version of this layout
LAYOUT = 1
