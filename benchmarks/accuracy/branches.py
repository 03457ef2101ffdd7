"""All motions of example 3 over the wind speed, and simulations that start on them.

Prints the branches, their events, and the simulated amplitudes beside those of the branches, and
draws docs/how-to/branches.png.

Usage: python benchmarks/accuracy/branches.py (about half a minute)
"""

from pathlib import Path

import gallop_fmu as gf
import modal
from gallop_fmu.plots import save_figure
from modal.motions.full_model import full_scene, run_from
from modal.motions.span_model import SpanModel
from modal.plots.branch_figure import branch_figure

WIND, PERIODS = 6.5, 1000
"""Wind speed [m/s] and duration in periods of the run that starts on the unstable one-loop motion
and settles at a beating one."""

PICTURE = Path(__file__).parents[2] / "docs" / "how-to" / "branches.png"


def main() -> None:
    """Compute, print and draw."""
    alone = modal.branches(gf.load_scene("example3"), "wind.speed", 4.5, 9.0)
    found = modal.branches(gf.load_scene("example3"), "wind.speed", 4.5, 9.0, simulate=4)
    data = found.dataset
    print(found)
    print(f"{alone.seconds:.1f} s of CPU time, {found.seconds:.1f} s with the simulations\n")
    for k in range(data.sizes["located"]):
        event = data.isel(located=k)
        print(f"{event.event_value.item():.4f} {event.event_kind.item()}")
    print("\n| from | m/s | motion: u2, u3 [m] | simulated u2, u3, two loops [m] | outcome |")
    for k in range(data.sizes["run"]):
        run = data.isel(run=k)
        number, value = run.run_branch.item(), run.run_value.item()
        of_branch = data.isel(point=data.branch_of_point.values == number)
        motion = of_branch.isel(point=abs(of_branch.value.values - value).argmin())
        simulated = ", ".join(
            f"{run[f'run_{name}_low'].item():.3f} to {run[f'run_{name}_high'].item():.3f}"
            for name in ("u2", "u3", "quarter")
        )
        print(
            f"| {number}{'' if run.run_start_is_stable.item() else ' (unstable)'} | {value:.3f}"
            f" | {motion.u2_amplitude.item():.3f}, {motion.u3_amplitude.item():.3f}"
            f" | {simulated} | {run.run_outcome.item()} |"
        )
    save_figure(branch_figure(data), PICTURE)
    print_beating(found)


def print_beating(found: modal.Branches) -> None:
    """Print the amplitudes over 60 periods at the end of a long run."""
    scene = gf.load_scene("example3")
    one_loop = found.diagram.branches[found.dataset["name"].values.tolist().index("one loop")]
    problem = one_loop.points[0].equations.problem
    model: SpanModel = problem.model
    start = one_loop.at(WIND)[0].states[0] + 0.1 * problem.scale
    end, _, _ = run_from(full_scene(scene, "wind.speed", WIND, model), model, start, PERIODS)
    amplitudes = ", ".join(f"{band.whole:.3f}" for band in (end.u2, end.u3, end.quarter))
    print(f"\n{WIND} m/s, over 60 periods: u2, u3, two loops {amplitudes} m, {end.outcome}")


if __name__ == "__main__":
    main()
