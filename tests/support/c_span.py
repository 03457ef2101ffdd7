"""A span as a C caller has it, with all arguments of every exported function."""

import ctypes as c
import math

import numpy as np

from gallop_fmu.engine.ctypes_structs import (
    CInputs,
    CProbe,
    CReport,
    Pointer,
)
from gallop_fmu.engine.library import library_path
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import Object
from gallop_fmu.foundation.outcome import Outcome

BAD_CALL = Outcome.BAD_CALL.code
UNTOUCHED = -12345.5
NODE, JUNCTION, FIELD, SYSTEM, *_ = Object
ROWS = [(NODE, 3, 0), (NODE, 4, 13), (JUNCTION, 1, 2), (FIELD, 0, 0), (SYSTEM, 0, 1)]
PROBES = np.array([(*row, 0, 0.0) for row in ROWS], dtype=np.dtype(CProbe))

kernel = c.CDLL(
    str(library_path())
)  # without the types of engine.library, which would refuse some arguments
for name in ("gallop_state_size", "gallop_saved_size"):
    getattr(kernel, name).restype = c.c_size_t
kernel.gallop_state_time.restype = c.c_double
kernel.gallop_arithmetic_fault.restype = c.c_char_p


class Span:
    """A model, its state, and all arguments of a call, each to be replaced by a wrong one."""

    def __init__(self, scene, *, inputs=True):
        self.model = Model(scene, inputs=inputs)
        self.handle = self.model.handle
        self.block = np.zeros(self.model.state_size // 8 + 2)
        self.state = c.c_void_p(self.block.ctypes.data)
        self.wind, self.moves = np.array([5.0, 0.0]), np.zeros((2, 2, 3))
        self.inputs = CInputs(0.0, math.pi, 0.0, 1, 2)
        self.inputs.wind = self.wind.ctypes.data_as(Pointer)
        self.inputs.motion = self.moves.ctypes.data_as(Pointer)
        self.report = CReport()
        self.values = np.full(4 * self.model.nodes, UNTOUCHED)
        self.motion = [np.zeros(4 * self.model.nodes) for _ in range(3)]
        self.out = np.full(144 * self.model.elements, UNTOUCHED)

    def started(self):
        assert self.init() == 0
        return self

    def init(self, **change):
        return self.call(
            "gallop_state_init", ("model", "state", "time", "inputs", "report"), change
        )

    def call(self, name, wanted, change):
        given = {
            "model": self.handle,
            "state": self.state,
            "time": c.c_double(0.0),
            "until": c.c_double(0.1),
            "inputs": c.byref(self.inputs),
            "report": c.byref(self.report),
            "probe": c.c_void_p(PROBES.ctypes.data),
            "probes": c.c_int32(len(PROBES)),
            "values": c.c_void_p(self.values.ctypes.data),
            "u": c.c_void_p(self.motion[0].ctypes.data),
            "v": c.c_void_p(self.motion[1].ctypes.data),
            "a": c.c_void_p(self.motion[2].ctypes.data),
            "k": c.c_double(1.0),
            "c": c.c_double(0.0),
            "m": c.c_double(0.0),
            "out": c.c_void_p(self.out.ctypes.data),
            "sharpness": c.c_double(1.0),
            "element": c.c_int32(0),
            "angle": c.c_double(3.0),
            "count": c.c_int32(2),
            "slopes": c.c_void_p(self.out.ctypes.data + 24 * 8),
            "more": c.c_void_p(self.out.ctypes.data + 48 * 8),
            "most": c.c_void_p(self.out.ctypes.data + 72 * 8),
        } | change
        self.report = (
            CReport(outcome=77, element=77, steps=-77) if "report" not in change else self.report
        )
        if "report" in wanted and "report" not in change:
            given["report"] = c.byref(self.report)
        return getattr(kernel, name)(*(given[argument] for argument in wanted))

    def run(self, **change):
        """gallop_run with two records; ``done`` and the report are kept."""
        self.records = np.full((2, len(PROBES)), UNTOUCHED)
        self.done, self.report = c.c_int64(-7), CReport(outcome=77, element=77, steps=-77)
        given = {
            "first": c.c_int64(0),
            "records": c.c_int64(2),
            "every": c.c_int64(1),
            "probe": c.c_void_p(PROBES.ctypes.data),
            "probes": c.c_int32(len(PROBES)),
            "values": c.c_void_p(self.records.ctypes.data),
            "done": c.byref(self.done),
            "report": c.byref(self.report),
        } | change
        return kernel.gallop_run(self.handle, self.state, *given.values())

    @property
    def saved(self):
        return self.block.tobytes()


ADVANCE = ("model", "state", "inputs", "until", "report")
START = ("model", "state", "time", "inputs", "report")
FUNCTIONS = {
    "gallop_state_init": START,
    "gallop_equilibrium": START,
    "gallop_state_place": ("model", "state", "time", "inputs", "u", "v", "report"),
    "gallop_advance": ADVANCE,
    "gallop_rewind": ("model", "state", "sharpness"),
    "gallop_state_check": ("model", "state"),
    "gallop_observe": ("model", "state", "probe", "probes", "values"),
    "gallop_observe_equilibrium": ("model", "probe", "probes", "values"),
    "gallop_residual": ("model", "state", "time", "inputs", "u", "v", "a", "out"),
    "gallop_tangent": ("model", "state", "time", "inputs", "u", "v", "a", "k", "c", "m", "out"),
    "gallop_device_force": (
        *("model", "state", "time", "inputs", "u", "v", "a"),
        *("element", "out", "slopes"),
    ),
    "gallop_device_tangent": (
        *("model", "state", "time", "inputs", "u", "v", "a"),
        *("k", "c", "m", "element", "out"),
    ),
    "gallop_device_load": ("model", "element", "count", "u", "v", "out", "slopes", "most"),
    "gallop_model_derived": ("model", "values"),
    "gallop_chain_derived": ("model", "element", "values"),
    "gallop_model_nodes": ("model", "values"),
    "gallop_sections": ("model", "values", "out", "more"),
    "gallop_strain_points": ("model", "out", "more", "most"),
    "gallop_node_normals": ("model", "values"),
    "gallop_seed": ("model", "values"),
    "gallop_aero_load": (
        "model",
        "element",
        "angle",
        "count",
        "u",
        "out",
        "slopes",
        "more",
        "most",
    ),
}
"""Arguments of the kernel's functions, by the names that `Span.call` knows."""
