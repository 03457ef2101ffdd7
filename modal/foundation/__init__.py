"""Shared by all layers: scenes with one number changed, root finding, change of state."""
