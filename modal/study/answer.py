"""An answer of a study, with its evidence."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    """A question, its answer in one sentence, and the evidence.

    Attributes
    ----------
    question, answer : str
        One sentence each.
    evidence : tuple of str
        Sentences.
    level : str
        ``"bad"``, ``"good"`` or ``"open"``, for the mark beside the answer.
    """

    question: str
    answer: str
    evidence: tuple[str, ...]
    level: str = "open"
