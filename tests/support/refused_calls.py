"""Calls of an FMU that it refuses."""

H = 0.02
"""Communication step [s]."""

ERROR = 3
"""fmi2Error."""


def refused(fmu, call, match):
    """The call is refused with a message; inputs, outputs, parameters and steps are the same."""
    before, said = fmu.to_bytes(fmu.save()), len(fmu.log)
    assert call() == ERROR
    assert len(fmu.log) == said + 1
    assert match in fmu.log[-1]
    assert fmu.to_bytes(fmu.save()) == before
