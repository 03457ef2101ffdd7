"""Scenes from files and tables, and scenes written to files."""
