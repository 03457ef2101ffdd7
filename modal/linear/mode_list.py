"""The modes of a span or line as a list that prints and draws itself."""

from __future__ import annotations

from typing import Any, SupportsIndex, TypeVar, overload

from gallop_fmu import LineScene, Scene
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.notebook_table import notebook_table
from modal.linear.line_modes import LineMode

M = TypeVar("M")


class ModeList(list[M]):
    """Modes in order of frequency: a list with a picture and a table.

    Attributes
    ----------
    scene : Scene or LineScene
        Their span or line.
    """

    def __init__(self, modes: list[M], scene: Scene | LineScene) -> None:
        super().__init__(modes)
        self.scene = scene

    @overload
    def __getitem__(self, index: SupportsIndex, /) -> M: ...

    @overload
    def __getitem__(self, index: slice, /) -> ModeList[M]: ...

    def __getitem__(self, index: SupportsIndex | slice, /) -> M | ModeList[M]:
        """Return one mode, or the list of those in a slice."""
        if isinstance(index, slice):
            return ModeList(super().__getitem__(index), self.scene)
        return super().__getitem__(index)

    def __reduce__(self) -> tuple[Any, ...]:
        return ModeList, (list(self), self.scene)

    def __repr__(self) -> str:
        return "[" + ",\n ".join(map(repr, self)) + "]"

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        of_line = isinstance(self.scene, LineScene)
        columns = ("mode", "frequency [Hz]", "damping [%]", "family", "loops")
        return notebook_table(
            self.scene.title,
            (*columns, "" if of_line else "symmetry"),
            [(str(number), *_cells(mode)) for number, mode in enumerate(self, start=1)],
        )

    def plot(self) -> Any:
        """Draw the shapes by `modal.plots.mode_shapes`, of a line by `line_mode_shapes`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        if isinstance(self.scene, LineScene):
            return drawn("LineMode.plot", self.scene, self, self.scene.title)
        return drawn("Mode.plot", self, self.scene.title)


def _cells(mode: Any) -> tuple[str, ...]:
    """Cells of a mode: frequency, damping, family, loops and, of a span, symmetry."""
    if isinstance(mode, LineMode):
        last = (", ".join(map(str, mode.loops)), "")
    else:
        last = (str(mode.loops), "symmetric" if mode.symmetric else "antisymmetric")
    return f"{mode.frequency_hz:.4f}", f"{100.0 * mode.damping_ratio:.2f}", mode.family, *last
