"""Texts and identity of an FMU, which all versions of FMI share."""

from __future__ import annotations

import hashlib
import re
import uuid
from dataclasses import dataclass

from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

SCENE_FILE = "scene.toml"
"""The scene in the FMU's resources."""

MAX_NAME = 40
"""Most characters of the title in the model identifier: some systems limit the length of paths."""

LOG_CATEGORIES = {
    "logStatusError": "calls that were refused, or could not be carried out",
    "logStatusDiscard": "questions without an answer",
}

SEMANTICS = (
    "The inputs of the host replace the scene's wind, attack angle and {motion} motion;"
    " concentrated loads keep their laws of time. wind_speed and attack_angle hold their values"
    " over a communication step, or change at the rate that the host gives where it can; the"
    " {points} move linearly to their new places, which they reach at its end, or at the given"
    " velocity. A communication step"
    " is carried out in equal steps no longer than numerics.time_step, or in steps that keep"
    " numerics.tolerance where it is given. Outputs do not react to inputs before the next step,"
    " except while initialising."
)
LINE_SEMANTICS = (
    "Spans, phases and stations count from 1, towers from 0 (left end) to the number of spans"
    " (right end). tower[1].f1 to f3 are the force of conductors and strings on the tower, static"
    " force included."
)


def describe(scene: Scene | LineScene, remarks: str = "") -> str:
    """Return the description of a scene, and how its FMU behaves, as one paragraph.

    Parameters
    ----------
    scene
        The scene.
    remarks
        Further remarks for the host; may be empty.
    """
    semantics = [SEMANTICS.format(motion="support", points="tower points")]
    if isinstance(scene, LineScene):
        semantics = [SEMANTICS.format(motion="tower", points="towers"), LINE_SEMANTICS]
    return " ".join([*scene.description.split(), *semantics, remarks]).strip()


@dataclass(frozen=True, slots=True)
class Identity:
    """Identity of an FMU, derived from its content: equal scenes give equal FMUs.

    Attributes
    ----------
    content
        SHA-256 of run-time, version and scene, in hexadecimal digits.
    title
        Title of the scene, from which the model identifier begins.
    """

    content: str
    title: str = ""

    @property
    def model_identifier(self) -> str:
        """Return the name of the binary and of the Python module."""
        name = "gallop"
        for word in re.findall(r"[A-Za-z0-9]+", self.title):
            if len(name) + len(word) >= MAX_NAME:
                break
            name += f"_{word}"
        return f"{name}_{self.content[:16]}"

    @property
    def guid(self) -> str:
        """Return the GUID of the model description."""
        return f"{{{uuid.UUID(self.content[:32])}}}"


def identify(
    scene_text: str, version: str, runtime: str, chosen: str = "", title: str = ""
) -> Identity:
    """Return the identity of the FMU of a scene, given as its TOML text, and what is chosen."""
    parts = [runtime, version, scene_text, *([chosen] if chosen else [])]
    return Identity(hashlib.sha256("\0".join(parts).encode()).hexdigest(), title)
