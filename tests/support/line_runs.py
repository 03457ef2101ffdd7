"""Runs of stored line cases through the kernel's states, without the layers above."""

from dataclasses import dataclass

import numpy as np

from gallop_fmu.engine.model import Model

INTERVAL = 0.06
"""Time [s] between records of a galloping run: 30 or more in a period."""

WINDOW = 50.0
"""Length [s] of the windows of the stored half peak-to-peak values."""


def clamp_nodes(model):
    """Nodes at the clamps of all suspensions, by tower."""
    line = model.map
    towers = [line.tower(k) for k in range(1, line.spans)]
    return [int(line.node_of_junction[j]) for tower in towers for j in tower.junctions]


def mid_span_nodes(model):
    """Nodes at mid-span: by subconductor and phase, then span."""
    line = model.map
    return [
        line.chain(span, phase, subconductor).middle
        for phase in range(1, line.phases + 1)
        for subconductor in range(1, line.subconductors + 1)
        for span in range(1, line.spans + 1)
    ]


def record(scene, nodes, duration, interval):
    """Return times and u1, u2, u3, theta: arrays (record) and (record, 4, node)."""
    model = scene if isinstance(scene, Model) else Model(scene)
    every = round(interval / model.scene.numerics.time_step)
    run = model.start().run(round(duration / interval), every, range(4), nodes)
    assert len(run.node_values) == round(duration / interval), run.report
    return interval * np.arange(1, len(run.node_values) + 1), run.node_values


@dataclass(frozen=True)
class Galloping:
    """Half peak-to-peak of u1, u2, u3, theta by windows that end at `ends` [s].

    `mid_spans` (window, 4, span) is of the mean of all conductors, `clamps` (window, 4, clamp).
    Histories: `time`, `centre_u2` (record, span), `clamps_u3` (record, clamp).
    """

    ends: np.ndarray
    mid_spans: np.ndarray
    clamps: np.ndarray
    time: np.ndarray
    centre_u2: np.ndarray
    clamps_u3: np.ndarray


def galloping(scene, duration):
    """Run a scene and return its `Galloping`."""
    model = Model(scene)
    middle = mid_span_nodes(model)
    time, moved = record(model, middle + clamp_nodes(model), duration, INTERVAL)
    mid_spans, clamps = np.split(moved, [len(middle)], axis=2)
    centre = mid_spans.reshape(len(time), 4, -1, model.map.spans).mean(axis=2)
    ends = np.arange(2.0 * WINDOW, duration + 1.0, WINDOW)
    parts = [(time > end - WINDOW) & (time <= end + 1e-9) for end in ends]
    sizes = [
        np.array([0.5 * np.ptp(values[part], axis=0) for part in parts])
        for values in (centre, clamps)
    ]
    return Galloping(ends, *sizes, time, centre[:, 1], clamps[:, 2])


def strongest_frequency(time, values):
    """Frequency [Hz] of the largest peak of the spectrum (Hann window, padded to 1 mHz)."""
    window = np.hanning(len(values)) * (values - values.mean())
    step = time[1] - time[0]
    count = round(1e3 / step)
    return float(np.fft.rfftfreq(count, step)[np.argmax(np.abs(np.fft.rfft(window, count)))])


def relative_rms(found, expected):
    """Root mean square of the difference relative to that of the expected values."""
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)))
