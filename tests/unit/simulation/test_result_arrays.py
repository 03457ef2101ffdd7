"""A result has its histories as arrays, and makes its dataset when it is used."""

import copy
import pickle
import subprocess
import sys

import numpy as np

import gallop_fmu as gf

UNUSED = """
import sys
import gallop_fmu as gf
result = gf.simulate("example3", 20.0)
result.steady(), result.warnings, result.motion, result.numbers(), repr(result)
assert "xarray" not in sys.modules
result.u2
assert "xarray" in sys.modules
"""


def test_a_summary_imports_no_xarray():
    subprocess.run([sys.executable, "-P", "-c", UNUSED], check=True)


def test_arrays_and_dataset_have_the_same_values():
    result = gf.simulate("example3", 2.0, record_nodes="all")
    for again in (result, copy.copy(result), pickle.loads(pickle.dumps(result))):
        assert set(again.recorded.values) == set(again.dataset.data_vars)
        for name, values in again.recorded.values.items():
            assert np.array_equal(values, again.dataset[name].values)
        facts = {**again.recorded.facts, "scene": again.dataset.attrs["scene"]}
        assert facts == again.dataset.attrs
    of_dataset = gf.Result(result.dataset, result.scene, result.report)
    assert of_dataset.steady(0.5) == result.steady(0.5)
    window = result.midspan().sel(time=slice(1.5 - 1e-9, None))
    for name, oscillation in result.steady(0.5).items():
        assert oscillation.amplitude == 0.5 * np.ptp(window[name].values)
    assert of_dataset.numbers() == result.numbers()
