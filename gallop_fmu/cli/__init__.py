"""The command ``gallop-fmu``, and what ``gallop-modal`` shares with it."""
