"""Reads run folders; counts, estimates, draws. Imports no agent, no world and no torch."""
