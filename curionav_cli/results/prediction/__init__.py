"""Predicted observations beside real ones, and whether surprise separates new views from known ones."""
