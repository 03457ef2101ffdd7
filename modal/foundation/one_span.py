"""What to use for a line in place of functions that take one span."""

SCREENING = "use modal.screen, which takes lines"
ESTIMATE = "leave it out: the full screening takes lines"
REPORT = "use modal.write_report, which takes lines"
VARIATION = "call natural_modes or frequency_ratio for each value of LineScene.with_values"
CRITERIA = "use modal.line_criteria, which has the criteria of each span"
CLOSED_FORM = "use natural_modes"
"""Imperatives for `gallop_fmu.scene.line_scene.one_span`."""
