"""Results of `modal` and of runs describe themselves in a few lines, and in notebooks."""

import gallop_fmu as gf
import modal


def test_modes_and_ratio_are_one_line_each():
    scene = gf.load_scene("example3")
    first = modal.natural_modes(scene, count=2)[0]
    assert repr(first) == "Mode(0.3775 Hz, horizontal, symmetric, 1 loop, damping 1.60 %)"
    ratio = modal.frequency_ratio(scene)
    assert repr(ratio) == "FrequencyRatio(vertical 0.6954 Hz, horizontal 0.3775 Hz, ratio 1.8421)"


def test_result_shows_its_text_and_its_dataset_in_notebooks():
    result = gf.simulate(gf.load_scene("example3"), stop_time=5.0)
    html = result._repr_html_()
    assert "completed at 5 s" in html
    assert "xarray.Dataset" in html
    assert "<pre>Result of" in html
