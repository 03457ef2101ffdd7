"""A master in under 100 lines: a line between two towers, wind from a table, a relay, rollback.

Each step the towers move first, with the last known forces; then the line moves at the towers' mean
velocities. A step in which the relay would trip is taken back and halved, until the time of the
trip is known to `SHORTEST`.
"""

from pathlib import Path

import numpy as np
from pythonfmu.builder import FmuBuilder
from towers.coupling import Component, Log, Names, build_tower

import gallop_fmu as gf

SHORTEST = 1e-4
"""Uncertainty [s] of the time of the trip."""
OF_TOWER = ["x1", "x3"]


class Master:
    """The instances, and what connects them."""

    def __init__(self, scene, ports, folder, wind):
        line = gf.export_fmu(scene, folder / "line.fmu")
        tower, options = build_tower(folder), {"canGetAndSetFMUstate": True}
        relay = FmuBuilder.build_FMU(
            Path(__file__).with_name("relay.py"), dest=folder / "relay.fmu", **options
        )
        self.log, self.ports, self.wind, self.time = Log(), ports, wind, 0.0
        self.line, self.relay = (
            Component(fmu, name, self.log) for fmu, name in ((line, "line"), (relay, "relay"))
        )
        self.towers = [Component(tower, end, self.log) for end in ports.ends]
        self.parts = [self.line, self.relay, *self.towers]
        self.start()

    def start(self):
        for part in self.parts:
            part.fmu.enterInitializationMode()
        self.line.set(["wind_speed"], [np.interp(0.0, *self.wind)])
        for tower, end in zip(self.towers, self.ports.ends, strict=True):
            static = self.line.get([f"{end}.preload.f1", f"{end}.preload.f3"])
            tower.set(["preload.f1", "preload.f3"], static)
            tower.set(["f1", "f3"], self.line.get([f"{end}.f1", f"{end}.f3"]))
        for part in self.parts:
            part.fmu.exitInitializationMode()

    def places(self):
        return np.concatenate([tower.get(OF_TOWER) for tower in self.towers])

    def step(self, h, clearance):
        """Make one step; `clearance` gives that of the displacements of the recorded output."""
        begin = self.places()
        for tower, force in zip(
            self.towers, np.split(self.line.get(self.ports.forces), 2), strict=True
        ):
            tower.set(["f1", "f3"], force)
            tower.fmu.doStep(self.time, h)
        velocities = (self.places() - begin) / h
        self.line.set(self.ports.displacements, begin)
        self.line.set([name.replace(".x", ".v") for name in self.ports.displacements], velocities)
        self.line.set(["wind_speed"], [np.interp(self.time + 0.5 * h, *self.wind)])
        self.line.fmu.doStep(self.time, h)
        self.relay.set(["clearance"], [clearance(self.line.get([self.ports.recorded])[0])])
        self.relay.fmu.doStep(self.time, h)
        self.time += h

    def run_until_trip(self, stop, h, clearance):
        """Return times, recorded values, and the time of the trip (None: there was none)."""
        history, size = [(0.0, self.line.get([self.ports.recorded])[0])], h
        while self.time < stop - 0.5 * SHORTEST:
            states, before = [part.fmu.getFMUstate() for part in self.parts], self.time
            self.step(min(size, stop - self.time), clearance)
            below = self.relay.fmu.getBoolean([self.relay.reference("tripped")])[0]
            if below and size > SHORTEST:  # take the step back, and look closer
                for part, state in zip(self.parts, states, strict=True):
                    part.fmu.setFMUstate(state)
                self.time, size = before, 0.5 * size
            else:
                history.append((self.time, self.line.get([self.ports.recorded])[0]))
            for part, state in zip(self.parts, states, strict=True):
                part.fmu.freeFMUstate(state)
            if below and size <= SHORTEST:
                return np.array(history), self.time
        return np.array(history), None

    def close(self):
        for part in self.parts:
            part.close()


PORTS = Names(("tower[0]", "tower[3]"), "span[2].midspan.x2")
