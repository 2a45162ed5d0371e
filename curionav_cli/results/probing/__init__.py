"""World models measured on the fixed probe of their building: curves, estimates, figures."""
