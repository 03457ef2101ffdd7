"""The command ``gallop-modal``."""
