"""The demonstration: the transfer of energy is found from the histories, and the FMU's run shows it."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import gallop_fmu as gf
from gallop_fmu.cli.demo import find_transfer
from gallop_fmu.cli.main import app
from gallop_fmu.foundation.errors import SceneError

TIME = np.arange(0.0, 600.0, 0.05)


def _motion(wakes_at):
    """A vertical motion of 0.7 Hz that falls from 0.6 to 0.4 m when a swing of half the frequency grows to 0.2 m."""
    awake = 1.0 / (1.0 + np.exp(-(TIME - wakes_at) / 4.0))
    u2 = (0.6 - 0.2 * awake) * np.sin(2.0 * np.pi * 0.7 * TIME)
    return u2, 0.05 + 0.2 * awake * np.sin(2.0 * np.pi * 0.35 * TIME)


@pytest.mark.parametrize("wakes_at", [150.0, 311.0, 450.0])
def test_the_transfer_is_found(wakes_at):
    transfer = find_transfer(TIME, *_motion(wakes_at))
    assert transfer.time == pytest.approx(
        wakes_at, abs=4.3
    )  # half a block of three swing periods; 1.1, 2.6, 0.4 s off
    assert (
        transfer.before[1] == transfer.during[0] < wakes_at < transfer.during[1] < transfer.after[0]
    )
    assert transfer.after[1] == TIME[-1]
    assert transfer.before[1] - transfer.before[0] == pytest.approx(15.0 / 0.35, rel=0.01)


def test_no_swing_no_transfer():
    u2, _ = _motion(300.0)
    with pytest.raises(
        SceneError, match=r"no transfer found: the run ends with 0\.700 Hz vertical and 0\.700 Hz"
    ):
        find_transfer(TIME, u2, 0.1 * u2)
    with pytest.raises(SceneError, match="no transfer found"):
        find_transfer(TIME, u2, 0.0 * u2)


def test_a_swing_from_the_start_is_no_transfer():
    with pytest.raises(SceneError, match="has no part before or after it"):
        find_transfer(TIME, *_motion(-100.0))


def test_a_transfer_at_the_very_end_is_not_over():
    with pytest.raises(SceneError, match="has no part before or after it"):
        find_transfer(TIME, *_motion(580.0))


def test_demo_shows_the_transfer(tmp_path):
    result = CliRunner().invoke(app, ["demo", "--out-dir", str(tmp_path / "new")])
    assert result.exit_code == 0, result.output
    assert "frequency ratio, vertical to horizontal, after the transfer: 2.000" in result.stdout
    assert "reconstruction" in result.stdout
    assert (tmp_path / "new" / "example3.png").stat().st_size > 0
    with xr.open_dataset(tmp_path / "new" / "example3.nc", engine="h5netcdf") as data:
        assert data.u2.attrs["units"] == "m"
        assert data.attrs["fmu"] == "example3.fmu"
        assert gf.Scene.from_dict(tomllib.loads(data.attrs["scene"])) == gf.load_scene("example3")
        alone = gf.simulate(gf.load_scene("example3"), 900.0, record_every=5).midspan()
        for name in ("u2", "u3", "theta", "tension"):
            np.testing.assert_array_equal(
                data[name].values, alone[name].values
            )  # the same kernel, the same steps
        last = slice(850.0, 900.0)
        for name, expected in (("u2", 0.442), ("u3", 0.1915)):
            assert np.ptp(data[name].sel(time=last).values) / 2.0 == pytest.approx(
                expected, abs=5e-4
            )


def test_demo_writes_only_where_it_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "gallop_fmu.cli.demo._run_fmu", lambda *_: (_ for _ in ()).throw(SceneError("stop here"))
    )
    result = CliRunner().invoke(app, ["demo", "--out-dir", "there"])
    assert result.exit_code == 2
    assert result.stderr == "gallop-fmu: stop here\n"
    assert {path.name for path in Path().rglob("*")} == {"there", "example3.fmu"}
