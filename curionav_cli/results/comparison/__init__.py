"""Many runs compared: estimates, tables, plots, one page."""
