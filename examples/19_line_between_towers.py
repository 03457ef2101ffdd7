# %% [markdown]
# # Three spans between two towers that move
#
# Three spans hang between two dead-end towers, on suspension strings at the towers between them.
# The line is one FMU with ports at every tower: `tower[0]` is the left end, `tower[3]` the right
# one. The tower's FMU is the one of example 08, in two instances.
#
# What the coupled FMUs should give comes from one system of equations: all elements and strings of
# the line, from the kernel, and the modes of both towers, solved with Newmark and Newton without
# any communication step (`towers/monolithic.py`).

# %%
import tempfile
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from towers.coupling import Names, build_tower, couple, galloping_line, preload
from towers.modal_tower import MODES
from towers.monolithic import Monolith

import gallop_fmu as gf

STOP, RECORD = 4.0, 0.02
COMMUNICATION_STEPS = np.array([0.01, 0.005, 0.0025])
PORTS = Names(("tower[0]", "tower[3]"), "span[2].midspan.x2")

# %% The line's own steps are the same in all runs, so that only the coupling differs.
scene = galloping_line(cable_step=0.5 * COMMUNICATION_STEPS[-1])
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
line, tower = gf.export_fmu(scene, folder / "line.fmu"), build_tower(folder)
static = preload(scene)
print(
    f"static force of the line on the left tower {static[0]:.0f} N, on the right {static[2]:.0f} N"
)

# %% The reference: Newmark's error is proportional to the square of the step, so a third of the
# difference of two runs takes most of it away.
middle = gf.Model(scene).map.chain(span=2).middle
coarse, fine = (
    Monolith(scene, MODES, step).run(STOP, round(RECORD / step), middle) for step in (0.005, 0.0025)
)
reference = fine + (fine - coarse) / 3.0


def relative(found):
    """RMS of the error in u2 at the middle of span 2 and in the left tower's x1, relative."""
    error = np.asarray(found) - reference
    return np.sqrt(np.mean(error**2, axis=0) / np.mean(reference**2, axis=0))


u2, x1 = relative(fine)
print(f"monolithic with 2.5 ms: error {u2:.1e} in u2, {x1:.1e} in x1")

# %% The runs. Gauss-Seidel: first the towers step, then the line with their new places. Iterated:
# the step is taken back and repeated until it fits.
errors = {}
table = Table(title=f"Error against the monolithic solution, RMS over {STOP:g} s")
for heading in ("scheme", "step (ms)", "middle of span 2, u2", "tower 0, x1", "iterations"):
    table.add_column(heading, justify="left" if heading == "scheme" else "right")
for scheme in ("Gauss-Seidel", "iterated"):
    for step in COMMUNICATION_STEPS:
        history = couple(line, tower, scheme, step, STOP, RECORD, static, PORTS)
        error = relative(history.values)
        errors.setdefault(scheme, []).append(error)
        mean = np.mean(history.iterations)
        table.add_row(scheme, f"{1000 * step:g}", *(f"{part:.3%}" for part in error), f"{mean:.2f}")
    table.add_section()
Console(width=100).print(table)

# %% Gauss-Seidel is of first order in both. Iteration is many times better in u2; in x1 the limit
# is that of example 08: the ends of the line move linearly during a step.
sequential, repeated = (np.array(errors[scheme]) for scheme in ("Gauss-Seidel", "iterated"))
print(
    f"u2 with 5 ms: error {sequential[1, 0]:.1e} with Gauss-Seidel, {repeated[1, 0]:.1e} iterated"
)

# %%
assert np.all(relative(fine) < 2e-3)  # 1.0e-4 and 1.6e-3 before the extrapolation
orders = np.log2(sequential[:-1] / sequential[1:])
assert np.all(np.abs(orders - 1.0) < 0.12)  # 1.01, 1.00 in u2; 1.10, 0.95 in x1
assert abs(sequential[1, 0] - 7.85e-3) < 0.1e-3
assert abs(repeated[1, 0] - 4.67e-4) < 0.1e-4
assert abs(repeated[1, 1] - 3.69e-2) < 0.05e-2
