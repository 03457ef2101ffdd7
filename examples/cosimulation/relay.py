"""A protection relay as an FMU: it trips once the clearance stays below a limit for some time."""

import atexit
import ctypes
from pathlib import Path

from pythonfmu import (
    Boolean,
    Fmi2Causality,
    Fmi2Initial,
    Fmi2Slave,
    Fmi2Variability,
    Real,
)

# pythonfmu 0.7.0 releases a reference to this namespace that it does not own, for every instance.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class Relay(Fmi2Slave):
    """The input holds over a step; the delay is that of the breaker."""

    description = "Trips when the clearance [m] has been below its limit for the delay."

    def __init__(self, **settings):
        super().__init__(**settings)
        for library in Path(self.resources).parent.glob("binaries/linux64/*.so"):
            atexit.register(ctypes.CDLL(str(library)).finalizePythonInterpreter)
        self.clearance, self.limit, self.delay = 10.0, 0.5, 0.02
        self.below, self.tripped = 0.0, False
        fixed, exact = Fmi2Variability.fixed, Fmi2Initial.exact
        self.register_variable(Real("clearance", causality=Fmi2Causality.input))
        for name in ("limit", "delay"):
            self.register_variable(
                Real(name, causality=Fmi2Causality.parameter, variability=fixed, initial=exact)
            )
        self.register_variable(Real("below", causality=Fmi2Causality.output, initial=exact))
        discrete = Fmi2Variability.discrete
        self.register_variable(
            Boolean("tripped", causality=Fmi2Causality.output, variability=discrete, initial=exact)
        )

    def do_step(self, current_time, step_size):
        self.below = self.below + step_size if self.clearance < self.limit else 0.0
        self.tripped = self.tripped or self.below > self.delay
        return True
