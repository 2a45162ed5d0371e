"""The intrinsic reward: one file for each value of agent.curiosity. lbs.py is the paper's, curiosity.py a contract."""
