"""Screening for the 2:1 swing: reduced model, harmonic balance, Floquet multipliers, verdict."""
