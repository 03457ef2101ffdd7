"""The demonstration: the run of the FMU shows the transfer of energy to the swing."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import gallop_fmu as gf
from gallop_fmu.cli.demo import WINDOWS
from gallop_fmu.cli.main import app
from gallop_fmu.foundation.errors import SceneError


def test_demo_shows_the_transfer(tmp_path):
    result = CliRunner().invoke(app, ["demo", "--out-dir", str(tmp_path / "new")])
    assert result.exit_code == 0, result.output
    assert "frequency ratio, vertical to horizontal, after the transfer: 2.000" in result.stdout
    assert "curve used here was reconstructed" in result.stdout
    assert (tmp_path / "new" / "example3.png").stat().st_size > 0
    with xr.open_dataset(tmp_path / "new" / "example3.nc", engine="h5netcdf") as data:
        assert data.u2.attrs["units"] == "m"
        swing = [np.ptp(data.u3.sel(time=slice(*WINDOWS[part])).values) / 2 for part in WINDOWS]
        assert swing[0] < 0.03 < 0.15 < swing[1]  # the swing grows in the window "during"
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


def test_demo_writes_only_into_the_given_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "gallop_fmu.cli.demo._run_fmu", lambda *_: (_ for _ in ()).throw(SceneError("stop here"))
    )
    result = CliRunner().invoke(app, ["demo", "--out-dir", "there"])
    assert result.exit_code == 2
    assert result.stderr == "gallop-fmu: stop here\n"
    assert {path.name for path in Path().rglob("*")} == {"there", "example3.fmu"}
