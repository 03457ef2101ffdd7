"""Figures of the modal toolkit."""
