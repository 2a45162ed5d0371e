"""Results: read run folders, count, estimate, draw. Imports no agent, no world and no torch."""
