"""The validated description of one span, section by section."""
