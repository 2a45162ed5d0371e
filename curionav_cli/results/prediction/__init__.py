"""Predicted observations beside the real ones."""
