"""Those who live in the world: the contract in agent.py, one file or folder for each agent."""
