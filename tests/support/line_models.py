"""Models of packed scenes that were changed after they were packed."""

import ctypes as c

from gallop_fmu.engine.ctypes_structs import CReport
from gallop_fmu.engine.inputs import InputLayout
from gallop_fmu.engine.library import kernel
from gallop_fmu.engine.line_map import one_span_map
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.pack import unpacked
from gallop_fmu.foundation.outcome import SimulationError


class LineModel(Model):
    """A model of a packed scene that was changed after it was packed.

    Raises
    ------
    SimulationError
        The kernel refuses it.
    """

    def __init__(self, scene, packed):
        report, handle = CReport(), c.c_void_p()
        code = kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
        self._handle = None
        if code:
            raise SimulationError(unpacked(report))
        self._handle, self.scene, self._takes_inputs = handle, scene, True
        tables = packed.tables
        elements = sum(chain.elements for chain in tables["chain"])
        self.junctions = len(tables["junction"])
        at_chains = {index for chain in tables["chain"] for index in chain.junction}
        at_chains |= {station.junction for station in tables["station"]} - {-1}
        bodies = self.junctions - len(at_chains)
        self.elements, self.nodes = elements, 2 * elements + len(tables["chain"]) + bodies
        ends = (0,), (self.junctions - 1,)
        self._input_layout = InputLayout(len(tables["field"]), self.junctions, ends)
        self.map = one_span_map(
            (0, elements), (0.0, 1.0), ("rigid", "rigid"), ()
        )  # a line has no place in words
        self.devices = packed.device_junctions
        self.state_size = int(kernel.gallop_state_size(handle))
        self.saved_size = int(kernel.gallop_saved_size(handle))
