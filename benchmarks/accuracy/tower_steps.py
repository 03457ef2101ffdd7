"""A span between two towers with communication steps of any size: error of the force on a tower.

    python benchmarks/accuracy/tower_steps.py

The steps are drawn at random from 1 us to 50 ms, or a shorter longest step; after three of ten the
master returns to the saved state and draws another one. The reference is the monolithic solution
with steps of 1.25 ms. "linear" is the error of the same master, steps and towers with a linear
spring of stiffness EA/L in place of the cable, which moves with the monolithic solution: the part
of the error that the cable does not cause. The second table has masters that control their step by
comparing one step with two halves. The third has the force after 20 steps of 5 ms and one shorter
one of a Jacobi master.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.fmu.cosim import Cosim
from gallop_fmu.fmu.model_bin import model_bin
from gallop_fmu.fmu.variables import fmu_variables

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples" / "towers"))
from coupling import galloping_span
from modal_tower import MODES, Mode
from monolithic import Monolith

Array = NDArray[np.float64]

ELEMENTS = 8
STOP = 2.0
SHORTEST, LONGEST = 1e-6, 0.05
REJECTED = 0.3
"""Share of the steps that the master takes back."""
AFTER_START = 0.3
"""Time [s] from which errors count: before, the start of the motion excites axial waves that the
monolithic solution does not resolve, either (77 N between steps of 1.25 and 0.625 ms)."""
TOLERANCE, MOST_ITERATIONS = 1e-9, 60
ACCEPTED = 1e-6
"""Difference [m] of the tower points between one step and two halves up to which it is accepted."""
SCHEMES = ("iterated", "gauss_seidel", "jacobi")


class Tower:
    """The tower of the examples, without an FMU."""

    def __init__(self, preload: list[float]) -> None:
        self.modes = [[Mode(*numbers) for numbers in MODES[axis]] for axis in ("x1", "x3")]
        self.preload, self.force = preload, preload

    def advance(self, force: list[float], h: float) -> None:
        for modes, begin, end, rest in zip(
            self.modes, self.force, force, self.preload, strict=True
        ):
            for mode in modes:
                mode.advance(begin - rest, end - rest, h)
        self.force = force

    def displacement(self) -> list[float]:
        return [sum(mode.shape * mode.q for mode in modes) for modes in self.modes]

    def velocity(self) -> list[float]:
        return [sum(mode.shape * mode.rate for mode in modes) for modes in self.modes]

    def save(self) -> tuple[list[tuple[float, float]], list[float]]:
        return [(mode.q, mode.rate) for modes in self.modes for mode in modes], self.force

    def restore(self, saved: tuple[list[tuple[float, float]], list[float]]) -> None:
        for mode, motion in zip(
            (mode for modes in self.modes for mode in modes), saved[0], strict=True
        ):
            mode.q, mode.rate = motion
        self.force = saved[1]


class Coupled:
    """The cable in co-simulation with its towers; `gives_velocity`: their velocities, too."""

    def __init__(self, gives_velocity: bool, time_step: float = 0.00125) -> None:
        self.scene = galloping_span(time_step).with_values({"numerics.elements": ELEMENTS})
        reference = {v.name: v.reference for v in fmu_variables(self.scene)}
        self.cosim = Cosim(model_bin(self.scene, "towers", "1"), "towers")
        self.cosim.set_up(0.0, None)
        self.cosim.enter_initialization()
        self.cosim.exit_initialization()
        ends = ("support.left", "support.right")
        self.forces, preloads, self.places, self.velocities = (
            [reference[f"{end}.{name}{k}"] for end in ends for k in (1, 3)]
            for name in ("f", "preload.f", "x", "v")
        )
        static = self.cosim.get("real", preloads)
        self.towers = [Tower(static[:2]), Tower(static[2:])]
        self.time, self.gives_velocity = 0.0, gives_velocity

    def force(self) -> list[float]:
        return self.cosim.get("real", self.forces)

    def displacement(self) -> list[float]:
        return self.towers[0].displacement() + self.towers[1].displacement()

    def velocity(self) -> list[float]:
        return self.towers[0].velocity() + self.towers[1].velocity()

    def move_towers(self, force: list[float], h: float) -> None:
        self.towers[0].advance(force[:2], h)
        self.towers[1].advance(force[2:], h)

    def move_cable(self, begin: list[float], end: list[float], h: float) -> None:
        """Make a step in which the ends move from `begin` to `end`."""
        if self.gives_velocity:
            self.cosim.set("real", self.places, begin)
            rates = [(b - a) / h for a, b in zip(begin, end, strict=True)]
            self.cosim.set("real", self.velocities, rates)
        else:
            self.cosim.set("real", self.places, end)
        self.cosim.step(self.time, h)

    def save(self) -> tuple[object, ...]:
        return self.cosim.save(), [tower.save() for tower in self.towers], self.time

    def restore(self, saved: tuple[object, ...]) -> None:
        state, towers, self.time = saved  # type: ignore[assignment]
        self.cosim.restore(state)  # type: ignore[arg-type]
        for tower, one in zip(self.towers, towers, strict=True):  # type: ignore[call-overload]
            tower.restore(one)

    def jacobi(self, h: float) -> None:
        force, place = self.force(), self.displacement()
        ahead = [x + v * h for x, v in zip(place, self.velocity(), strict=True)]
        self.move_towers(force, h)
        self.move_cable(place, ahead if self.gives_velocity else place, h)
        self.time += h

    def gauss_seidel(self, h: float) -> None:
        begin = self.displacement()
        self.move_towers(self.force(), h)
        self.move_cable(begin, self.displacement(), h)
        self.time += h

    def iterated(self, h: float) -> None:
        saved, begin = self.save(), self.displacement()
        guess = [x + v * h for x, v in zip(begin, self.velocity(), strict=True)]
        for _ in range(MOST_ITERATIONS):
            self.move_cable(begin, guess, h)
            self.time += h
            self.move_towers(self.force(), h)
            found = self.displacement()
            if max(abs(a - b) for a, b in zip(found, guess, strict=True)) < TOLERANCE:
                return
            guess = found
            self.restore(saved)
        raise RuntimeError(f"the iteration did not converge at {self.time:.4f} s, step {h:.3g} s")


class Recorded(Monolith):
    """Records the force on the left tower along the span [N]."""

    def __init__(self, step: float) -> None:
        coupled = Coupled(False)
        self.static, self.force = coupled.towers[0].preload[0], dict[float, float]()
        super().__init__(coupled.scene, MODES, step)

    def _residual(self, y: Array, v: Array, a: Array, time: float) -> Array:
        own = self._forces(y, v, a, time=time)[self.inner]
        self.force[time] = self.static - float(own)  # the last iteration remains
        return super()._residual(y, v, a, time)


def monolithic(step: float) -> tuple[Array, Array]:
    """Times [s] and force on the left tower [N]."""
    whole = Recorded(step)
    whole.run(STOP, 1000)
    times = sorted(whole.force)
    return np.array(times), np.array([whole.force[time] for time in times])


class Linear(Coupled):
    """A linear spring in place of the cable, between the left tower and the monolithic motion.

    The force is that of the monolithic solution, plus EA/L times the difference of the tower's
    place from the monolithic one. Without an error of the master there is no difference.
    """

    def __init__(self, gives_velocity: bool, reference: tuple[Array, Array]) -> None:
        super().__init__(gives_velocity)
        self.reference, self.place = reference, 0.0
        scene = self.scene
        self.stiffness = scene.conductor.axial_stiffness / scene.span.length
        self.at_rest = self.towers[0].preload + self.towers[1].preload
        alone, places = Tower(self.towers[0].preload), [0.0]
        for h, force in zip(np.diff(reference[0]), reference[1][1:], strict=True):
            alone.advance([float(force), alone.preload[1]], float(h))
            places.append(alone.displacement()[0])
        self.monolithic_place = np.array(places)

    def force(self) -> list[float]:
        times, forces = self.reference
        force, place = (np.interp(self.time, times, y) for y in (forces, self.monolithic_place))
        return [float(force - self.stiffness * (self.place - place)), *self.at_rest[1:]]

    def move_cable(self, begin: list[float], end: list[float], h: float) -> None:
        self.place = end[0]

    def save(self) -> tuple[object, ...]:
        return self.place, [tower.save() for tower in self.towers], self.time

    def restore(self, saved: tuple[object, ...]) -> None:
        self.place, towers, self.time = saved  # type: ignore[assignment]
        for tower, one in zip(self.towers, towers, strict=True):  # type: ignore[call-overload]
            tower.restore(one)


def error_of(
    times: list[float], forces: list[float], reference: tuple[Array, Array]
) -> tuple[float, float]:
    """Largest and RMS error of the force, as fractions of the largest force."""
    error = np.array(forces) - np.interp(times, *reference)
    error = error[np.array(times) > AFTER_START] / np.max(np.abs(reference[1]))
    return float(np.max(np.abs(error))), float(np.sqrt(np.mean(error**2)))


def random_steps(
    scheme: str,
    coupled: Coupled,
    seed: int,
    reference: tuple[Array, Array],
    longest: float = LONGEST,
) -> tuple[float, float]:
    """Error of the force in random steps, of which some are taken back."""
    rng = np.random.default_rng(seed)
    times, forces = [], []
    while coupled.time < STOP - longest:
        h = float(np.exp(rng.uniform(np.log(SHORTEST), np.log(longest))))
        saved = coupled.save() if rng.random() < REJECTED else None
        getattr(coupled, scheme)(h)
        if saved is not None:
            coupled.restore(saved)
            continue
        times.append(coupled.time)
        forces.append(coupled.force()[0])
    return error_of(times, forces, reference)


def controlled_steps(
    scheme: str, coupled: Coupled, reference: tuple[Array, Array], stop: float = STOP
) -> tuple[float, int, int, float]:
    """Error of the force, steps, rejected ones and the shortest one [s] of a master with control.

    As in PyFMI (Jacobi) and MasterSim (Gauss-Seidel): a step is repeated as two halves, and taken
    back if the towers are at other places then. Both methods are of first order in the step.
    """
    times, forces, h, rejected, shortest = list[float](), list[float](), 1e-3, 0, LONGEST
    while coupled.time < stop - LONGEST:
        saved = coupled.save()
        getattr(coupled, scheme)(h)
        whole = coupled.displacement()
        coupled.restore(saved)
        for _ in range(2):
            getattr(coupled, scheme)(0.5 * h)
        pairs = zip(whole, coupled.displacement(), strict=True)
        change = max(abs(a - b) for a, b in pairs) / ACCEPTED
        if change > 1.0:
            coupled.restore(saved)
            rejected += 1
        else:
            shortest = min(shortest, 0.5 * h)
            times.append(coupled.time)
            forces.append(coupled.force()[0])
        h = min(LONGEST, h * min(2.0, max(0.2, 0.9 / max(change, 1e-6) ** 0.5)))
    return error_of(times, forces, reference)[0], len(times), rejected, shortest


def after_a_shorter_step(gives_velocity: bool, h: float, time_step: float = 0.01) -> float:
    """Force on the left tower [N] after 20 Jacobi steps of 5 ms and one of `h` [s]."""
    coupled = Coupled(gives_velocity, time_step)
    for _ in range(20):
        coupled.jacobi(0.005)
    coupled.jacobi(h)
    return coupled.force()[0]


def main() -> None:
    reference = monolithic(0.00125)
    print(f"largest force {np.max(np.abs(reference[1])) / 1e3:.2f} kN; errors relative to it")
    print("scheme        longest step   velocities   largest     RMS   linear")
    for scheme in SCHEMES:
        for longest in (0.05, 0.02, 0.01, 0.005):
            for gives in (True, False):
                found = [
                    random_steps(scheme, Coupled(gives), seed, reference, longest)
                    for seed in range(5)
                ]
                linear = [
                    random_steps(scheme, Linear(gives, reference), seed, reference, longest)[0]
                    for seed in range(5)
                ]
                largest, rms = np.max(found, axis=0)
                print(
                    f"{scheme:13} {1e3 * longest:9g} ms   {'yes' if gives else 'no':10}"
                    f" {largest:8.2%} {rms:7.2%} {max(linear):8.2%}",
                    flush=True,
                )
    print("\nwith control  velocities   largest   steps  rejected  shortest")
    for scheme in SCHEMES[1:]:
        for gives in (True, False):
            error, steps, rejected, shortest = controlled_steps(scheme, Coupled(gives), reference)
            print(
                f"{scheme:13} {'yes' if gives else 'no':10} {error:8.2%} {steps:7} {rejected:9}"
                f" {1e3 * shortest:6.3f} ms",
                flush=True,
            )
    print("\nstep          force without velocities, with them [kN]")
    for h in (5e-3, 1e-3, 1e-4, 1e-5, 1e-6):
        pair = [after_a_shorter_step(gives, h) / 1e3 for gives in (False, True)]
        print(f"{h:8g} s    {pair[0]:8.2f} {pair[1]:8.2f}", flush=True)


if __name__ == "__main__":
    main()
