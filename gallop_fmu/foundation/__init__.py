"""What every layer uses: errors, outcomes, rules for texts and files, names of channels and integrators."""
