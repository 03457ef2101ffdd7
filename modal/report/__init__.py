"""Self-contained HTML report on a span: data, statics, modes, galloping, simulation, clearance.

It is part of `modal` because it needs both packages, and `gallop_fmu` does not import `modal`.
"""
