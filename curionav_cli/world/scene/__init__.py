"""A scene: its file or ROS map, the boxes it is built of, the cells that can be reached."""
