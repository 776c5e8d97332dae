"""The module kerbstone: the simulated car, beside the program crgdrive and Newton."""

import collections.abc
import csv
import math
import os
import pathlib
import pickle
import sys
import threading
import time
import types
import subprocess

import kerbstone
import numpy as np
import pytest

VEHICLE = os.path.join(os.environ["KERBSTONE_SOURCE"], "vehicles/open_wheel/vehicle.yaml")


@pytest.fixture(scope="module")
def car():
    return kerbstone.Car.read(VEHICLE)


@pytest.fixture(scope="module")
def circle():
    """A flat closed road of 60 m radius, 10 m wide."""
    rows = 754
    angle = np.linspace(0, 2 * math.pi, rows)
    v_m = np.linspace(-5, 5, 11)
    return kerbstone.Road.from_arrays(60 * np.sin(angle), 60 * (1 - np.cos(angle)), v_m, np.zeros((rows, 11)), closed=True)


@pytest.fixture(scope="module")
def straight():
    u_m = np.arange(0, 801.0)
    return kerbstone.Road.from_arrays(u_m, 0 * u_m, [-8.0, 0.0, 8.0], np.zeros((u_m.size, 3)))


def test_a_lap_is_that_of_the_program(car, circle, tmp_path):
    circle.write(str(tmp_path / "circle.crg"))
    subprocess.run(
        [os.environ["CRGDRIVE"], "lap", "--car", VEHICLE, "--road", str(tmp_path / "circle.crg"), "-o", str(tmp_path / "lap.csv"), "--quiet"],
        check=True,
    )
    with open(tmp_path / "lap.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    laps = car.lap(kerbstone.Road.read(str(tmp_path / "circle.crg")))
    assert laps.complete and len(laps.lap_s) == 1
    for channel in ("time_s", "x_m", "vx_mps", "fz_rl_n"):
        assert laps.telemetry[channel] == pytest.approx([float(row[channel]) for row in rows], rel=1e-6, abs=1e-6)


def test_a_car_that_is_driven_step_by_step_obeys_newton(car, straight):
    drive = car.start(straight, u_m=20.0, speed_mps=30.0, gear=2)
    assert math.isnan(drive["vx_mps"])
    speeds = []
    for _ in range(50):
        drive.step(throttle=1.0, gear=2, steps=20)
        speeds.append(drive["vx_mps"])
    assert drive.time_s == pytest.approx(0.999, abs=2e-3)
    assert speeds[-1] > speeds[0] + 2
    # On a flat straight the accelerometer shows the change of the speed.
    gained = speeds[-1] - speeds[-2]
    assert drive["ax_mps2"] * 0.02 == pytest.approx(gained, rel=0.1)
    assert drive["u_m"] == pytest.approx(20 + np.mean(speeds), rel=0.02)
    drive.step(brake_pa=[4e6, 4e6, 2e6, 2e6], gear=2, steps=500)
    assert drive["ax_mps2"] < -3
    assert set(drive.telemetry) >= {"time_s", "x_m", "fz_fl_n"}


def test_a_car_of_eight_gears_drives_in_the_last(straight, tmp_path):
    sheet = subprocess.run([os.environ["CRGDRIVE"], "new", "--example"], check=True, capture_output=True, text=True).stdout
    (tmp_path / "car.yaml").write_text(sheet + "gears: 8\n", encoding="utf-8")
    subprocess.run([os.environ["CRGDRIVE"], "new", tmp_path / "car.yaml", "-o", tmp_path / "car", "--quiet"], check=True)
    drive = kerbstone.Car.read(tmp_path / "car" / "vehicle.yaml").start(straight, u_m=20.0, speed_mps=50.0, gear=7)
    drive.step(throttle=0.5, gear=7, steps=10)
    seventh = drive["engine_radps"]
    drive.step(throttle=0.5, gear=8, steps=1000)
    assert drive["gear"] == 8
    assert drive["engine_radps"] < 0.95 * seventh


def test_the_same_steps_give_the_same_numbers(car, straight):
    def run():
        drive = car.start(straight, u_m=20.0, speed_mps=40.0, gear=3)
        for k in range(100):
            drive.step(steer_rad=0.05 * math.sin(0.1 * k), throttle=0.5, gear=3, steps=5)
        return drive.telemetry

    assert run() == run()


@pytest.fixture(scope="module")
def rough():
    """A straight with waves and kerbs of 4 cm, and from 150 m a hole over its whole width."""
    u_m, v_m = np.arange(0, 200.25, 0.25), np.arange(-6.0, 6.25, 0.25)
    z_m = 0.01 * np.sin(0.7 * u_m)[:, None] * np.cos(0.9 * v_m) + np.where(abs(v_m) > 4.5, 0.04, 0.0)
    z_m[(u_m > 150) & (u_m < 156)] = math.nan
    return kerbstone.Road.from_arrays(u_m, 0 * u_m, v_m, z_m)


# Eleven cars: more than a pack, and cars that are left over. The last two come to the hole, the one before to a kerb.
MANY = 11
BEGINS = {
    "u_m": [10.0 + 4 * i for i in range(MANY - 2)] + [130.0, 137.0],
    "v_m": [3.6 if i == 8 else 0.3 * (i - 5) for i in range(MANY)],
    "speed_mps": [3.0 * i for i in range(MANY - 2)] + [40.0, 40.0],
    "gear": [1 + i % 4 for i in range(MANY)],
    "fuel_kg": [5.0 + i for i in range(MANY)],
}


def asked_of(i, k):
    """Something else for each car and decision."""
    return {
        "steer_rad": 0.8 * math.sin(0.5 * k + i) + (0.5 if i == 8 else 0.0),
        "throttle": (0.1 * i + 0.05 * k) % 1.0,
        "brake_pa": [1e6 if (i + k) % 4 == 3 else 0.0, 0.0, 5e4 * i, 1e5],
        "gear": 1 + (i + k // 5) % 4,
        "clutch": 0.4 if (i + k) % 7 == 0 else 0.0,
    }


def step_many(drives, k, cars=range(MANY), steps=30):
    asked = [asked_of(i, k) for i in cars]
    drives.step(**{name: [one[name] for one in asked] for name in asked[0]}, steps=steps)


def test_many_cars_go_bit_for_bit_as_each_alone(car, rough):
    drives = car.start_many(rough, cars=MANY, tyre_k=350.0, **BEGINS)
    alone = [car.start(rough, tyre_k=350.0, **{name: values[i] for name, values in BEGINS.items()}) for i in range(MANY)]
    names = list(alone[0].telemetry)
    assert len(drives) == MANY and np.isnan(drives["vx_mps"]).all() and (drives.time_s == 0).all()
    said = [None] * MANY
    for k in range(30):
        step_many(drives, k)
        for i, drive in enumerate(alone):
            try:
                if said[i] is None:
                    drive.step(**asked_of(i, k), steps=30)
            except kerbstone.Error as error:
                said[i] = str(error)
        assert drives.problems == said
        together = np.array([drives[name] for name in names]).T
        assert np.array_equal(together, [list(drive.telemetry.values()) for drive in alone], equal_nan=True)  # no load without a road
        assert np.array_equal(drives.time_s, [drive.time_s for drive in alone])
    assert [one is not None and "no road" in one for one in said] == [False] * (MANY - 2) + [True] * 2
    assert drives["u_m"][:-2].max() < 150 and drives["v_m"][8] > 4.5  # on the kerb


def test_states_of_many_cars_go_on_in_any_of_them(car, rough):
    drives = car.start_many(rough, cars=MANY, **BEGINS)
    names = ("time_s", "x_m", "y_m", "vx_mps", "fz_rl_n", "yaw_rate_radps")

    def seen(i):
        return [drives[name][i] for name in names]

    for k in range(10):
        step_many(drives, k)
    failed, middle = drives.state(MANY - 1), drives.state(3)
    assert drives.problems[MANY - 1] and drives.problems[3] is None
    there = seen(3)
    step_many(drives, 10)
    wanted = seen(3)
    for i in range(MANY):
        drives.set_state(i, middle)
        assert seen(i) == there and drives.problems[i] is None
    step_many(drives, 10, cars=[3] * MANY)
    assert all(seen(i) == wanted for i in range(MANY))
    # One that failed takes its problem along, and stands until it begins again.
    drives.set_state(0, failed)
    why = drives.problems[0]
    step_many(drives, 11)
    assert "no road" in why and drives.problems[0] == why and drives.problems[1] is None
    first = car.start(rough, **{name: values[0] for name, values in BEGINS.items()})
    first.step(throttle=1.0)
    drives.reset(0)
    assert drives.problems[0] is None and math.isnan(drives["vx_mps"][0]) and drives.time_s[0] == 0
    drives.step(throttle=1.0)
    assert seen(0) == [first[name] for name in names]


def test_many_cars_refuse_what_one_refuses_in_the_same_words(car, straight):
    def words(call):
        with pytest.raises((ValueError, KeyError, IndexError, kerbstone.Error)) as error:
            call()
        return type(error.value), str(error.value)

    one = car.start(straight, u_m=20.0)
    drives = car.start_many(straight, cars=3, u_m=20.0)
    odd = [{"throttle": x} for x in (math.nan, 5.0, -0.1)] + [{"clutch": 2.0}, {"gear": 9}, {"brake_pa": [-1.0, 0, 0, 0]}, {"steps": 0}]
    for asked in odd:
        assert words(lambda: drives.step(**asked)) == words(lambda: one.step(**asked))
        if "steps" not in asked:  # of one car alone
            (name, value), = asked.items()
            assert words(lambda: drives.step(**{name: [np.zeros_like(value), value, np.zeros_like(value)]})) == words(lambda: one.step(**asked))
    for begin in ({"u_m": 30000.0}, {"speed_mps": -1.0}, {"gear": 9}, {"fuel_kg": math.nan}, {"tyre_k": 1e9}, {"disc_k": 0.0}, {"step_s": 0.02}):
        assert words(lambda: car.start_many(straight, cars=3, **begin)) == words(lambda: car.start(straight, **begin))
    assert words(lambda: drives["no_such_channel"]) == words(lambda: one["no_such_channel"])
    assert "gear: -1 to 6 wanted" in words(lambda: drives.step(gear=[1, 2.5, 1]))
    assert "steer_rad: a number or 3 of them wanted" in words(lambda: drives.step(steer_rad=[0.0, 0.0]))
    assert "brake_pa: a number, 4 of them or 3 x 4 wanted" in words(lambda: drives.step(brake_pa=[0.0] * 3))
    for cars in (0, 2 * 10**9):
        assert "cars: 1 to 10000 wanted" in words(lambda: car.start_many(straight, cars=cars))
    assert "car 3: 0 to 2 wanted" in words(lambda: drives.reset(3))
    assert "state: one of these cars wanted" in words(lambda: drives.set_state(0, car.start_many(straight, cars=3).state(0)))
    assert (drives.time_s == 0).all()  # nothing refused has moved them
    drives.step(throttle=1.0 + 1e-10, brake_pa=1e5)  # what rounding leaves
    assert drives["throttle_command"].tolist() == [1.0] * 3 and drives["brake_rr_command_pa"].tolist() == [1e5] * 3


def test_other_threads_run_while_many_cars_step(car, straight):
    drives = car.start_many(straight, cars=64, u_m=20.0, speed_mps=30.0, gear=3)
    ran, done = [], threading.Event()

    def other():
        while not done.is_set():
            time.sleep(0.001)
            ran.append(time.perf_counter())

    thread = threading.Thread(target=other)
    thread.start()
    begin = time.perf_counter()
    drives.step(gear=3, steps=1000)
    end = time.perf_counter()
    done.set()
    thread.join()
    assert sum(begin < at < end for at in ran) >= 5


def test_a_replay_is_that_of_the_program(car, circle, tmp_path):
    track, log, out = (str(tmp_path / name) for name in ("circle.crg", "lap.csv", "out"))
    circle.write(track)
    crgdrive = os.environ["CRGDRIVE"]
    subprocess.run([crgdrive, "lap", "--car", VEHICLE, "--road", track, "-o", log, "--quiet"], check=True)
    recording = kerbstone.Recording.read(log)
    assert "vx_mps" in recording.channels and recording.step_s == pytest.approx(0.01)
    assert len(recording["vx_mps"]) == len(recording["time_s"])
    replay = car.replay(kerbstone.Road.read(track), recording)
    subprocess.run([crgdrive, "replay", "--log", log, "--car", VEHICLE, "--road", track, "-o", out, "--quiet"], check=True)
    with open(tmp_path / "out" / "errors.csv", encoding="utf-8") as file:
        wanted = {row["channel"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    assert set(replay.errors) == set(wanted)
    for channel, error in replay.errors.items():
        for name in ("samples", "max", "rmse", "hold_rmse", "trend_rmse"):
            assert getattr(error, name) == pytest.approx(float(wanted[channel][name]), rel=1e-4, abs=1e-9)
    # Its own car comes out where it was: far nearer than where nothing changes.
    assert replay.errors["vx_mps"].rmse < 0.1 * replay.errors["vx_mps"].hold_rmse
    assert replay.windows >= 2 and not replay.problems
    assert replay.telemetry["window"][-1] == replay.windows


def test_a_recording_is_a_mapping_and_a_table(circle, car, tmp_path, monkeypatch):
    log = tmp_path / "lap.csv"
    log.write_text("time_s,vx_mps\n" + "".join(f"{k / 10},{20 + k}\n" for k in range(30)))
    recording = kerbstone.Recording.read(log)
    assert set(recording) == set(recording.keys()) == set(recording.channels) >= {"time_s", "vx_mps"}
    assert "vx_mps" in recording and "ay_mps2" not in recording
    assert len(recording) == len(recording.channels)
    assert dict(recording)["vx_mps"].tolist() == dict(recording.items())["vx_mps"].tolist() == [20.0 + k for k in range(30)]
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=lambda columns: ("frame", columns)))
    assert isinstance(recording, collections.abc.Mapping)
    assert recording.get("ay_mps2") is None and recording.get("vx_mps")[3] == list(recording.values())[1][3] == 23.0
    again = pickle.loads(pickle.dumps(recording))
    assert list(again) == list(recording) and again["vx_mps"].tolist() == recording["vx_mps"].tolist()
    assert again.step_s == recording.step_s and repr(again) == "Recording(2 channels, 30 rows)"
    kind, columns = recording.to_dataframe()
    assert kind == "frame" and columns["vx_mps"][3] == 23.0


def test_any_log_opens_as_its_channels(tmp_path, monkeypatch):
    path = tmp_path / "logger.csv"
    rows = [f"{k / 10},{20 + k % 7},3.5,{k if k % 5 == 0 else ''}" for k in range(100) if not 40 <= k < 70]
    path.write_text("Time,Speed,Stuck,Slow\ns,km/h,bar,\n" + "\n".join(rows) + "\n")
    log = kerbstone.open(path)
    assert log.format == "CSV" and len(log) == 4 and list(log) == log.keys() and repr(log) == "Log(CSV, 4 channels)"
    speed = log["Speed"]
    assert (speed.name, speed.unit, speed.samples, speed.words, speed.dead) == ("Speed", "km/h", 70, 0, False)
    assert speed.rate_hz == pytest.approx(10, rel=0.01) and (speed.least, speed.greatest) == (20, 26)
    assert speed.longest_gap_s == pytest.approx(3.1) and speed.values[3] == 23 and speed.time_s[3] == pytest.approx(0.3)
    assert log["Stuck"].dead and not speed.dead
    assert log["Slow"].samples == 14 and log["Slow"].longest_gap_s == pytest.approx(3.5) and math.isnan(log["Slow"].values[1])
    assert [channel.name for channel in log.channels] == list(log)
    monkeypatch.setitem(sys.modules, "pandas", types.SimpleNamespace(DataFrame=lambda columns: ("frame", columns)))
    assert log.to_dataframe()[1]["Speed"][3] == 23
    assert "<td>Speed<td>km/h<td>" in log._repr_html_() and "<td>dead" in log._repr_html_()
    with pytest.raises(KeyError):
        log["speed"]
    measured = tmp_path / "log.mf4"
    measured.write_bytes(b"MDF     4.10    test" + bytes(200))
    with pytest.raises(kerbstone.Error, match="MDF"):
        kerbstone.open(measured)


def test_parts_of_a_car_are_found_in_a_drive(car, tmp_path):
    u = np.arange(0, 9000.5, 0.5)
    flat = kerbstone.Road.from_arrays(u, 0 * u, [-6.0, 6.0], np.zeros((u.size, 2)))
    drive = car.start(flat, u_m=20, speed_mps=30, gear=3, fuel_kg=20)
    channels = ["time_s", "vx_mps", "ax_mps2", "az_mps2", "throttle", "gear", *(f"fz_{wheel}_n" for wheel in ("fl", "fr", "rl", "rr"))]
    rows = []
    for k in range(4000):  # up and down between 25 and 60 m/s
        slow = k % 500 >= 300
        drive.step(gear=3 if drive["vx_mps"] < 40 else 5, throttle=0.0 if slow else 0.8, brake_pa=[2.5e6 if slow and drive["vx_mps"] > 25 else 0.0] * 4, steps=20)
        rows.append(",".join(f"{drive[channel]:.9g}" for channel in channels))
    log = tmp_path / "drive.csv"
    log.write_text(",".join(channels) + "\n" + "\n".join(rows[50:]) + "\n")
    mass = kerbstone.identify("mass", log, VEHICLE, fuel_kg=20.0)
    found = mass.found["mass_kg"]
    assert found.value == pytest.approx(740, abs=max(2.0, found.within)) and found.within < 20 and found.stated == 740 and found.unseen == ""
    assert "chassis.mass_kg = " in mass.sheet and mass.fuel_kg == 20 and mass.doubts == [] and mass.remarks
    assert repr(mass).startswith("Identified(mass,") and "mass_kg" in repr(found) and mass.map == []
    brakes = kerbstone.identify("brakes", log, VEHICLE)
    assert "pressures" in brakes.found["torque"].unseen and brakes.found["torque"].stated == 1
    with pytest.raises(kerbstone.Error, match="wanted mass, aero"):
        kerbstone.identify("wings", log, VEHICLE)
    with pytest.raises(kerbstone.NotUsable, match="the loads weigh") as refused:
        kerbstone.identify("mass", log, VEHICLE, settings=["chassis.mass_kg=400"])
    assert refused.value.result.found["mass_kg"].value == pytest.approx(740, rel=0.05)


def test_errors_of_recordings(car, circle, tmp_path):
    with pytest.raises(kerbstone.Error, match="no_log.csv"):
        kerbstone.Recording.read("no_log.csv")
    log = tmp_path / "log.csv"
    log.write_text("time_s,x_m\n" + "".join(f"{0.1 * k:.1f},{k}\n" for k in range(20)))
    recording = kerbstone.Recording.read(str(log))
    with pytest.raises(KeyError):
        recording["vx_mps"]
    with pytest.raises(kerbstone.Error, match="steer_rad"):
        car.replay(circle, recording)
    with pytest.raises(ValueError, match="window_s"):
        car.replay(circle, recording, window_s=-1.0)


def test_errors_say_what_was_wanted(car, straight):
    with pytest.raises(kerbstone.Error, match="missing.yaml"):
        kerbstone.Car.read("missing.yaml")
    with pytest.raises(kerbstone.Error, match="Car.read"):
        kerbstone.Car.read(VEHICLE, settings=["chassis.wings=3"])
    assert kerbstone.Car.read(VEHICLE, settings=["chassis.mass_kg=800"]).name == car.name
    with pytest.raises(kerbstone.Error, match="no road at u 300"):
        car.start(straight, u_m=30000.0)
    with pytest.raises(ValueError, match="no number"):
        car.start(straight, u_m=20.0).step(throttle=math.nan)
    for odd in ({"throttle": 5.0}, {"throttle": -0.1}, {"clutch": 2.0}, {"gear": 9}, {"brake_pa": [-1.0, 0, 0, 0]}):
        with pytest.raises(ValueError, match="wanted"):
            car.start(straight, u_m=20.0).step(**odd)
    with pytest.raises(ValueError, match="gear: -1 to 6 wanted"):
        car.start(straight, u_m=20.0, gear=9)
    car.start(straight, u_m=20.0).step(throttle=1.0 + 1e-10)  # what rounding leaves
    assert kerbstone.Car.read(pathlib.Path(VEHICLE)).name == car.name
    with pytest.raises(KeyError):
        car.start(straight, u_m=20.0)["no_such_channel"]
    with pytest.raises(kerbstone.Error):
        car.lap(straight, laps=2)
