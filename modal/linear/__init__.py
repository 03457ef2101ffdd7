"""Small motion about an equilibrium: matrices, modes, mode tracking, state-space model."""
