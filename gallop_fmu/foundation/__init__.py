"""Errors, outcomes, rules for texts and files, channels and integrators, for all layers."""
