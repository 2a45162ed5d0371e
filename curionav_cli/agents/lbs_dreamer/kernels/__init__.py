"""Fast forms of the agent's functions, with gradients written out by hand."""
