"""explain beside `crgexplain run`: the same files, the same words."""

import csv
import json
import os
from pathlib import Path

import kerbstone
import numpy as np
import pytest
from beside_commands import command, framed_page, same_folders, same_values

VEHICLE = Path(os.environ["KERBSTONE_SOURCE"]) / "vehicles/open_wheel/vehicle.yaml"

LOGGED = (
    "time_s x_m y_m yaw_rad vx_mps vy_mps yaw_rate_radps ax_mps2 ay_mps2 steer_rad throttle brake_fl_pa brake_fr_pa brake_rl_pa "
    "brake_rr_pa wheel_fl_radps wheel_fr_radps wheel_rl_radps wheel_rr_radps engine_radps gear"
).split()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Three laps of a car 100 kg heavier than its file says, with noise, on an oval."""
    folder = tmp_path_factory.mktemp("recorded")
    straight, radius = 60.0, 40.0
    s = np.arange(0, 2 * straight + 2 * np.pi * radius + 1e-9, (2 * straight + 2 * np.pi * radius) / 742)
    heading = np.interp(s, np.cumsum([0, straight, np.pi * radius, straight, np.pi * radius]), [0, 0, np.pi, np.pi, 2 * np.pi])
    dx, dy = np.cos((heading[1:] + heading[:-1]) / 2), np.sin((heading[1:] + heading[:-1]) / 2)
    step = s[1]
    x, y = np.r_[0, np.cumsum(dx * step)], np.r_[0, np.cumsum(dy * step)]
    v = np.linspace(-6, 6, 13)
    road = kerbstone.Road.from_arrays(x, y, v, np.zeros((x.size, v.size)), closed=True)
    road.write(str(folder / "oval.crg"))
    laps = kerbstone.Car.read(str(VEHICLE), settings=["chassis.mass_kg=820"]).lap(road, laps=3, record_every=20)
    assert laps.complete
    random = np.random.default_rng(3)
    scatter = {"x_m": 0.03, "y_m": 0.03, "vx_mps": 0.04, "vy_mps": 0.06, "yaw_rate_radps": 5e-3, "ax_mps2": 0.25, "ay_mps2": 0.25}
    with open(folder / "log.csv", "w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(LOGGED)
        columns = [laps.telemetry[name] + scatter.get(name, 0) * random.standard_normal(laps.telemetry[name].size) for name in LOGGED]
        rows.writerows([[f"{value:.9g}" for value in row] for row in np.column_stack(columns)])
    return folder


@pytest.mark.parametrize(("flags", "options"), [(["--skip-simulation"], {"skip_simulation": True}), (["--hold-out", "0,2"], {"hold_out": [0, 2]})])
def test_explain_writes_what_the_command_writes(here, recorded, flags, options):
    log, road = recorded / "log.csv", recorded / "oval.crg"
    here.enter("command")
    printed = command("crgexplain", "run", "--log", log, "--car", VEHICLE, "--road", road, "--fuel-kg", 30, "--nulls", 200, "-o", "out", *flags).stdout
    here.enter("python")
    found = kerbstone.explain(log, VEHICLE, road, "out", fuel_kg=30, nulls=200, **options)
    same_folders(here.command / "out", here.python / "out")
    assert f"verdict: {found.verdict}" in printed
    data = json.loads(Path("out/findings.json").read_text("utf-8"))
    same_values(found.report, data)
    same_values(found.findings, data["findings"])
    assert [f"  {remark}" for remark in found.remarks] == [line for line in printed.splitlines() if line[2:] in found.remarks]
    assert framed_page(found._repr_html_()) == Path("out/report.html").read_bytes()
    assert Path(found.corrected.road_path).exists() and Path(found.corrected.car_path).exists()
    # 820 kg drove; found are 840 and 846.
    (mass,) = [finding.parameters[0].value for finding in found.findings if finding.mechanism == "parameter.mass"]
    assert mass == pytest.approx(820, abs=40)
    assert found.corrected.car_path == "out/vehicle.yaml" and found.corrected.road_path == str(road)


def test_explain_refuses(here, recorded):
    here.enter("python")
    log, road = recorded / "log.csv", recorded / "oval.crg"
    ran = command("crgexplain", "run", "--log", log, log, "--car", VEHICLE, "--road", road, "-o", "out", code=1)
    with pytest.raises(kerbstone.Error) as refused:
        kerbstone.explain([log, log], VEHICLE, road, "out")
    assert str(refused.value) in ran.stderr
    for wrong, words in (
        ({"hold_out": [99]}, "no such lap"),
        ({"nulls": 5}, "100 to 100000 wanted"),
        ({"fuel_kg": -1}, "0 to 500 wanted"),
        ({"fuel_kg": float("nan")}, "no number"),
        ({"mapping": "missing.yaml"}, "missing.yaml"),
    ):
        with pytest.raises(kerbstone.Error, match=words):
            kerbstone.explain(log, VEHICLE, road, "out", **wrong)
    with pytest.raises(kerbstone.Error, match="no recording"):
        kerbstone.explain([], VEHICLE, road, "out")
    with pytest.raises(TypeError):
        kerbstone.explain(log, VEHICLE, road, "out", hold_out="all")
    assert not Path("out").exists()
