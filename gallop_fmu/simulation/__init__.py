"""Simulation of one scene: options, result, energy balance, steadiness, warnings."""
