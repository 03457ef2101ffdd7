"""Modes, frequency ratios and stability of an iced span, seen from outside the simulation.

Examples
--------
>>> import gallop_fmu as gf, modal
>>> scene = gf.load_scene("example3")
>>> [(mode.family, mode.loops) for mode in modal.natural_modes(scene, count=2)]
[('horizontal', 1), ('vertical', 1)]
>>> round(modal.frequency_ratio(scene).ratio, 2)
1.84
"""

from modal.modes import Mode, natural_modes
from modal.resonance import FrequencyRatio, frequency_ratio

__all__ = ["FrequencyRatio", "Mode", "frequency_ratio", "natural_modes"]
