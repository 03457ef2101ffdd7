"""Definitions for all other packages: errors, outcomes of runs, files, channels, integrators."""
