"""Random lines survive writing and reading, and every number can be changed by its path."""

from hypothesis import HealthCheck, given, settings

import gallop_fmu as gf
from gallop_fmu.foundation.text_files import parse_toml
from gallop_fmu.input.annotated_toml import annotated_toml
from support.random_lines import line_data


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(line_data())
def test_a_random_line_survives_writing_and_reading(data):
    line = gf.LineScene.from_dict(data)
    for text in (line.to_toml(), annotated_toml(line)):
        assert gf.LineScene.from_dict(parse_toml(text)) == line
    for path, (value, _, _) in line.numbers().items():
        assert line.unit_of(path) is not None
        assert value == value
    path = "section.spans.0.length"
    changed = line.with_values({path: 333.0})
    assert changed.section.spans[1:] == line.section.spans[1:]
    assert changed.with_values({path: line.section.spans[0].length}) == line
