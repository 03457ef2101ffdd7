"""The page that makes a section from a table of towers shows what the command writes."""

import re
import shlex
from pathlib import Path

import gallop_fmu as gf

PAGE = (Path(__file__).parents[3] / "docs/how-to/section_from_table.md").read_text(encoding="utf-8")


def test_the_commands_of_the_page_write_what_it_shows(invoke, tmp_path):
    (tmp_path / "towers.csv").write_text(re.search(r"```csv\n(.*?)```", PAGE, re.DOTALL)[1])
    first, bundle, _ = (
        shlex.split(line)[1:]
        for line in PAGE.replace("\\\n", " ").splitlines()
        if line.startswith("    gallop-fmu new")
    )
    for words in (first, bundle):
        done = invoke(*words)
        assert (done.exit_code, done.stderr) == (0, "")
        assumed = done.stdout.count("warning: the coefficient curve is ASSUMED")
        assert done.stdout.count("warning") == assumed == ("--wind-speed" in words)
    shown = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1]
    assert shown in (tmp_path / "section.toml").read_text(encoding="utf-8")
    assert gf.load_scene(tmp_path / "bundle.toml").bundle.spacers == 6
