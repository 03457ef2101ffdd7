"""One self-contained HTML page about a span: what it is, how it rests, swings and gallops, and how that was computed.

It is part of `modal` because it needs both packages, and `gallop_fmu` does not import `modal`.
"""
