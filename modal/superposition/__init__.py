"""Mode superposition, and its comparison with the nonlinear simulation."""
