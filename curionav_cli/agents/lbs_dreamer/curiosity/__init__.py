"""Curiosity is one small file and one setting, agent.curiosity: what makes a state worth reaching."""
