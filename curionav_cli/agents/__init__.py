"""Agents: the contract in agent.py, the table of all in registry.py, one file or folder for each agent."""
