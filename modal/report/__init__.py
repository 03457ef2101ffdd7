"""One self-contained HTML page about a span: what it is, how it rests, swings and gallops, and how that was computed.

It stands in `modal` because it needs what both packages know, and `gallop_fmu` does not import `modal`. The command
``gallop-fmu report`` therefore comes in through the entry points ``gallop_fmu.commands`` of the distribution.
"""
