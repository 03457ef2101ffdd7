"""Random lines survive writing and reading, and every number can be changed by its path."""

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import gallop_fmu as gf
from gallop_fmu.foundation.text_files import parse_toml
from gallop_fmu.input.annotated_toml import annotated_toml
from support.random_lines import line_data


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(line_data(), st.randoms())
def test_a_random_line_survives_writing_and_reading(data, random):
    line = gf.LineScene.from_dict(data)
    for text in (line.to_toml(), annotated_toml(line)):
        assert gf.LineScene.from_dict(parse_toml(text)) == line
    numbers = line.numbers()
    for path in random.sample(sorted(numbers), 5):
        assert line.with_values({path: numbers[path][0]}) == line
    path = "section.spans.0.length"
    changed = line.with_values({path: 333.0})
    assert changed.section.spans[1:] == line.section.spans[1:]
    assert changed.with_values({path: line.section.spans[0].length}) == line
