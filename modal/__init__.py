"""Modes, frequency ratios and stability of an iced span, seen from outside the simulation."""
