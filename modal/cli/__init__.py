"""The command line of ``gallop-modal``."""
