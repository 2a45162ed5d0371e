"""The intrinsic reward: one file for each value of agent.reward. cbet.py is the paper's, reward.py the contract."""
