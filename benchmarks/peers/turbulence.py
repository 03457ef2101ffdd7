"""Compare realisations of turbulence with those of PyConTurb.

Kaimal spectrum, Davenport coherence.

Usage: python benchmarks/peers/turbulence.py (about a minute; needs pip install pyconturb)

PyConTurb factorises the matrix of coherences of each frequency (Veers' method), with amplitudes
that are not random. Both ensembles are compared with the target: mean spectrum over all frequencies
and stations, and mean coherence of two stations in bands of frequency.
"""

import time

import numpy as np
import pyconturb

from gallop_fmu.scene.gusts import gusts
from gallop_fmu.scene.turbulence import Turbulence

SPEED, DURATION, STEP, SPACING, STATIONS = 8.0, 256.0, 0.5, 5.0, 9
REALISATIONS = 100
GIVEN = {"spectrum": "kaimal", "intensity": 0.2, "length_scale": 60.0, "decay": 10.0}
BANDS = ((0.004, 0.02), (0.02, 0.05), (0.05, 0.1), (0.1, 0.2))


def turbulence(seed: int) -> Turbulence:
    return Turbulence(**GIVEN, seed=seed, time_step=STEP, spacing=SPACING)


def ours(seed: int) -> np.ndarray:
    found = gusts(turbulence(seed), SPEED, 0.0, SPACING * (STATIONS - 1), DURATION)
    return found.values[:-1, :, 0]


def theirs(seed: int) -> np.ndarray:
    places = pyconturb.gen_spat_grid(SPACING * np.arange(STATIONS), [10.0], comps=[0])
    target = turbulence(0)

    def coherence(component, frequency, distance, **_):
        return np.exp(-target.decay * frequency * distance / SPEED)

    def spectrum(frequency, spat, **_):
        density = target.spectral_density(target.components[0], frequency, SPEED)
        return np.asarray(density).reshape(-1, 1) * np.ones((1, spat.shape[1]))

    found = pyconturb.gen_turb(
        places,
        T=DURATION,
        nt=round(DURATION / STEP),
        coh_model=coherence,
        spec_func=spectrum,
        sig_func=lambda spat, **_: np.full(spat.shape[1], GIVEN["intensity"]),
        wsp_func=lambda spat, **_: np.zeros(spat.shape[1]),
        seed=seed,
    )
    return np.asarray(found)


def main() -> None:
    f = np.arange(1, 256) / DURATION
    target = turbulence(0)
    density = target.spectral_density(target.components[0], f, SPEED)
    print("| quantity | target | ours | PyConTurb |\n| --- | ---: | ---: | ---: |")
    rows: dict[str, list[float]] = {}
    seconds = []
    for function in (ours, theirs):
        began = time.process_time()
        z = np.fft.rfft(np.stack([function(seed) for seed in range(REALISATIONS)]), axis=1)[:, 1:-1]
        seconds.append((time.process_time() - began) / REALISATIONS)
        power = np.mean(np.abs(z) ** 2, axis=0)
        spectra = power * 2.0 / (512**2 / DURATION)
        rows.setdefault("variance", [np.sum(density) / DURATION]).append(
            float(np.mean(np.sum(spectra, axis=0)) / DURATION)
        )
        cross = np.mean(z[:, :, :-1] * np.conj(z[:, :, 1:]), axis=0)
        found = np.real(cross) / np.sqrt(power[:, :-1] * power[:, 1:])
        for low, high in BANDS:
            inside = (f >= low) & (f < high)
            expected = np.mean(np.exp(-target.decay * f[inside] * SPACING / SPEED))
            name = f"coherence at {SPACING:g} m, {low:g} to {high:g} Hz"
            rows.setdefault(name, [float(expected)]).append(float(found[inside].mean()))
    for name, values in rows.items():
        print(f"| {name} | {' | '.join(f'{value:.4f}' for value in values)} |")
    print(f"| CPU time of a realisation [s] | | {seconds[0]:.4f} | {seconds[1]:.4f} |")


if __name__ == "__main__":
    main()
