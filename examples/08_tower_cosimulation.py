# %% [markdown]
# # Co-simulation: the galloping span between two towers that move
#
# The span of example 3 hangs between two towers. The cable's FMU takes the motion of its ends and
# gives the forces on the towers; the tower's FMU takes forces and gives its motion. A master
# couples them step by step:
#
# - Jacobi: all step side by side with the last known values; both directions are one step late. -
# Gauss-Seidel: first the towers, then the cable with their new places; one direction is late. -
# iterated: the step is taken back and repeated until it fits, with fmi2GetFMUstate and
# fmi2SetFMUstate.
#
# What they should give comes from one system of equations for the cable and both towers, solved
# with Newmark and Newton without any communication step (`towers/monolithic.py`), at two time steps
# and extrapolated to none.

# %%
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table
from towers.coupling import SCHEMES, UnstableError, build_tower, couple, galloping_span, preload
from towers.modal_tower import MODES
from towers.monolithic import Monolith

import gallop_fmu as gf
from gallop_fmu.plots import save_figure

STOP, RECORD = 8.0, 0.02
COMMUNICATION_STEPS = np.array([0.02, 0.01, 0.005, 0.0025, 0.00125])

# %% The cable's own steps are the same in all runs, half the shortest communication step, so that
# only the coupling differs. The towers take the cable's static reaction as preload: without wind
# and seed nothing would move.
scene = galloping_span(cable_step=0.5 * COMMUNICATION_STEPS[-1])
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
cable, tower = gf.export_fmu(scene, folder / "cable.fmu"), build_tower(folder)
static = preload(scene)
print(
    f"static force of the cable on the left tower {static[0]:.0f} N, on the right tower"
    f" {static[2]:.0f} N"
)


# %% The reference. Newmark's error is proportional to the square of the step, so two runs show how
# large it is, and a third of their difference takes most of it away. (With steps half as long the
# reference changes by 2e-7 in u2, 1e-4 in x1.)
def relative(error, reference):
    """Root mean square of mid-span u2 and the left tower's x1, relative to the reference's."""
    return np.sqrt(np.mean(error**2, axis=0) / np.mean(reference**2, axis=0))


coarse, fine = (
    Monolith(scene, MODES, step).run(STOP, round(RECORD / step)) for step in (0.005, 0.0025)
)
reference = fine + (fine - coarse) / 3.0
monolithic_error = relative(fine - reference, reference)
print(
    f"monolithic with 2.5 ms: error {monolithic_error[0]:.1e} in u2, {monolithic_error[1]:.1e}"
    " in x1"
)

# %% What to expect. An end of the cable that moves a time t late pulls with k x - k t v: the delay
# drives the tower. Once k t exceeds the tower's own damping, the coupled run grows. It is two steps
# in all with Jacobi, one with Gauss-Seidel.
mass, frequency, ratio, _ = MODES["x1"][0]
damping = 2.0 * ratio * 2.0 * np.pi * frequency * mass
delay = 1000.0 * damping * scene.span.length / scene.conductor.axial_stiffness
print(f"should be stable up to about {delay / 2.0:.1f} ms (Jacobi), {delay:.1f} ms (Gauss-Seidel)")

# %% The runs.
errors = {scheme: np.full((len(COMMUNICATION_STEPS), 2), np.nan) for scheme in SCHEMES}
iterations = {scheme: np.full(len(COMMUNICATION_STEPS), np.nan) for scheme in SCHEMES}
for scheme in SCHEMES:
    for k, step in enumerate(COMMUNICATION_STEPS):
        try:
            history = couple(cable, tower, scheme, step, STOP, RECORD, static)
        except UnstableError as problem:
            print(f"{scheme}, {1000 * step:g} ms: {problem}")
            continue
        errors[scheme][k] = relative(np.array(history.values) - reference, reference)
        iterations[scheme][k] = np.mean(history.iterations)

# %% The order is that between a step and the one above it, twice as long.
orders = {scheme: np.log2(error[:-1] / error[1:]) for scheme, error in errors.items()}


def cell(number, form):
    """A number as text; nothing where there is none."""
    return "" if np.isnan(number) else format(number, form)


table = Table(title=f"Error against the monolithic solution, RMS over {STOP:g} s")
for heading in ("scheme", "step (ms)", "mid-span u2", "order", "tower x1", "order", "iterations"):
    table.add_column(heading, justify="left" if heading == "scheme" else "right")
for scheme, error in errors.items():
    for k, step in enumerate(COMMUNICATION_STEPS):
        u2, x1 = (cell(value, ".3%") or "stopped" for value in error[k])
        order_u2, order_x1 = (
            cell(value, ".2f") for value in (orders[scheme][k - 1] if k else (np.nan, np.nan))
        )
        row = (scheme if k == 0 else "", f"{1000 * step:g}", u2, order_u2, x1, order_x1)
        table.add_row(*row, cell(iterations[scheme][k], ".2f"))
    table.add_section()
Console(width=100).print(table)

# %% Gauss-Seidel is as good as Jacobi with half the step. Iteration is many times better than both,
# but in x1 it is not of second order: the ends of the cable move linearly during a step, so their
# velocity is half a step late and jumps between steps, which the stiffness-proportional damping of
# the cable answers with a force.
figure = Figure(figsize=(7.1, 3.4), layout="constrained")
panels = figure.subplots(1, 2, sharex=True)
steps = 1000.0 * COMMUNICATION_STEPS
for column, (axes, title) in enumerate(
    zip(panels, ("mid-span $u_2$", "left tower $x_1$"), strict=True)
):
    for (scheme, error), colour, marker in zip(
        errors.items(), ("#D55E00", "#E69F00", "#0072B2"), "s^o", strict=True
    ):
        axes.loglog(steps, error[:, column], color=colour, marker=marker, label=scheme)
    axes.loglog(
        steps,
        errors["Gauss-Seidel"][-1, column] * steps / steps[-1],
        ":",
        color="0.6",
        label="first order",
    )
    axes.set(
        title=title,
        xlabel="communication step (ms)",
        xticks=steps,
        xticklabels=[f"{step:g}" for step in steps],
    )
    axes.minorticks_off()
panels[0].set_ylabel("relative RMS error")
figure.legend(
    *panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False
)
print("wrote", save_figure(figure, folder / "coupling_error.png"))

# %%
assert np.all(monolithic_error < 2e-3)  # 1.6e-4 and 1.3e-3 before the extrapolation
assert np.isnan(errors["Jacobi"][0, 0])  # the cable goes slack
assert np.min(errors["Jacobi"][1, 1]) > 1.0  # 4.3: growing, beyond 7.7 ms
assert (
    abs(errors["Jacobi"][2, 0] / errors["Gauss-Seidel"][2, 0] - 2.0) < 0.2
)  # 1.89: two delays against one
assert np.all(np.abs(orders["Gauss-Seidel"][-1] - 1.0) < 0.05)  # 1.00 and 0.98
assert abs(errors["iterated"][2, 0] - 5.0e-4) < 0.3e-4  # 4.98e-4, against 3.0e-2 with Gauss-Seidel
assert abs(errors["iterated"][2, 1] - 2.4e-2) < 0.1e-2  # 2.39e-2, against 1.5e-1
assert np.nanmax(iterations["iterated"]) < 4.0  # 3.25
