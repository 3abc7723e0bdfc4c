import json

import numpy as np
import pytest
from typer.testing import CliRunner

from cairn import plan_layered
from cairn.cli import app
from cairn.experiments import parallel
from cairn.experiments.reproduce import ALL

SMALL = [parallel.Profile("wide", 4, 30), parallel.Profile("thin", 25, 4)]


@pytest.fixture(scope="module")
def record():
    steps = []
    record = parallel.measure(SMALL, repeats=1, advance=steps.append)
    assert len(steps) == parallel.steps() * len(SMALL) / len(parallel.PROFILES)
    return record


@pytest.mark.parametrize("profile", SMALL)
def test_a_profile_gives_a_two_way_graph_of_just_those_layers(profile):
    result = plan_layered(*parallel.layered_graph(profile, seed=1), 0)
    assert (result.layers, result.greatest_rise) == (profile.layers, 1)
    assert np.bincount(result.layer).tolist() == [1] + [profile.width] * profile.layers


def test_the_study_counts_work_within_the_bounds_and_as_equation_4_does(record):
    assert len(record["studies"]) == 4
    for study in record["studies"]:
        assert study["levels"] <= study["levels_bound"] == study["layers"] * study["widest_layer"]
        assert study["operations"] <= study["operations_bound"]
        assert study["operations_equation_4"] == study["operations"] + 1
        layers, levels = study["layers"], study["levels"]
        assert study["tasks"] == sum(min(level, layers) for level in range(1, levels + 1))


def test_played_out_no_schedule_gains_more_than_it_has_workers_or_layers(record):
    for study in record["studies"]:
        for plan in study["schedules"].values():
            assert plan["played"][1] == pytest.approx(1.0)
            for workers, speed_up in plan["played"].items():
                assert 1 - 1e-9 <= speed_up <= workers + 1e-9
                assert speed_up <= study["layers"] + 1e-9  # a layer is at one level at a time
            assert min(plan["busy"]) >= 0
            assert max(plan["busy"]) <= parallel.BUSY_ON + 1e-9


def test_the_study_is_told_as_tables_and_drawn(record, tmp_path):
    reproduction = ALL["parallel"]()
    for table in reproduction.tables(record):
        assert all(len(row) == len(table.columns) for row in table.rows)
    (picture,) = reproduction.draw(record, tmp_path / "new")
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_reproduce_lists_what_there_is_and_refuses_what_there_is_not():
    listed = CliRunner().invoke(app, ["reproduce", "--list", "--json"])
    assert set(json.loads(listed.stdout)["summary"]) == set(ALL)
    refused = CliRunner().invoke(app, ["reproduce", "fig99"])
    assert refused.exit_code == 2
    assert "fig99" in refused.output


def test_reproduce_prints_the_record_it_writes(monkeypatch, tmp_path):
    monkeypatch.setattr(parallel.measure, "__defaults__", (SMALL,))
    done = CliRunner().invoke(app, ["reproduce", "parallel", "--json", "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    printed = json.loads(done.stdout)
    assert printed == json.loads((tmp_path / "parallel" / "summary.json").read_text())
    assert printed["summary"]["same_bits_as_serial"]
    assert (tmp_path / "parallel" / "parallel.png").exists()
