"""Drives the line of a recorded lap at its speed, closed loop, and compares with the recording.

    python3 recorded_lap.py BIN_FOLDER STACK VEHICLE.yaml RECORDING.csv FIRST_ROW LAST_ROW OUT_FOLDER

BIN_FOLDER holds crgdrive and crgsim (or folders with them), STACK is examples/stack built. The recording
has time(s), x(m), y(m), vx(m/s), vy(m/s), phi(rad), as logs of the Indy Autonomous Challenge have;
the rows are those of one lap. The road is a level plane.
"""

import csv
import json
import math
import pathlib
import subprocess
import sys
import time

DEVICES = """sensors:
  gnss.x: {signal: car.x, rate_hz: 100}
  gnss.y: {signal: car.y, rate_hz: 100}
  imu.yaw_rate: {signal: car.yaw_rate}
  wheels.vx: {signal: car.vx}
"""
COMMANDS = ["input.steering", "input.throttle", "input.brake.fl", "input.brake.fr",
            "input.brake.rl", "input.brake.rr", "input.gear"]
MEASURED = ["gnss.x", "gnss.y", "gnss.x.age_s", "imu.yaw_rate", "wheels.vx"]
RECORDED = ["car.x", "car.y", "car.yaw", "car.vx", "car.vy"]


def wrapped(angle_rad):
    return math.remainder(angle_rad, 2.0 * math.pi)


def read_lap(path, first, last):
    """Rows of the lap in the frame of the car at its begin: x, y, heading, vx, vy; rows a second."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    columns = [rows[0].index(name) for name in ("x(m)", "y(m)", "phi(rad)", "vx(m/s)", "vy(m/s)")]
    lap = [[float(row[c]) for c in columns] for row in rows[1 + first:1 + last]]
    x0, y0 = lap[0][:2]
    ahead = next(row for row in lap if math.hypot(row[0] - x0, row[1] - y0) > 3.0)
    yaw0 = math.atan2(ahead[1] - y0, ahead[0] - x0)
    c, s = math.cos(yaw0), math.sin(yaw0)
    time_column = rows[0].index("time(s)")
    rate_hz = (last - first - 1) / (float(rows[last][time_column]) - float(rows[1 + first][time_column]))
    return [[c * (x - x0) + s * (y - y0), -s * (x - x0) + c * (y - y0), wrapped(phi - yaw0), vx, vy]
            for x, y, phi, vx, vy in lap], rate_hz


def tool(folder, name):
    path = pathlib.Path(folder) / name
    return str(path / name if path.is_dir() else path)


def drive(folder, bin_folder, stack, vehicle, lap):
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "line.csv", "w", encoding="utf-8") as file:
        file.write("x_m,y_m,speed_mps\n")
        file.writelines(f"{x:.4f},{y:.4f},{vx:.4f}\n" for x, y, _, vx, _ in lap)
    (folder / "devices.yaml").write_text(DEVICES, encoding="utf-8")
    unit = str(folder / "car.fmu")
    subprocess.run([tool(bin_folder, "crgdrive"), "fmu", vehicle, "-o", unit, "--quiet"], check=True)
    socket = str(folder / "s")
    command = [tool(bin_folder, "crgsim"), "serve", unit, "--socket", socket, "--lockstep",
               "--every", "10", "--stop-s", "600",
               "--devices", str(folder / "devices.yaml"), "-o", str(folder / "driven.csv"), "--quiet"]
    for option, names in (("--command", COMMANDS), ("--measure", MEASURED), ("--record", RECORDED)):
        for name in names:
            command += [option, name]
    with subprocess.Popen(command) as server:
        while not pathlib.Path(socket).exists() and server.poll() is None:
            time.sleep(0.02)
        driven = subprocess.run([stack, socket, str(folder / "line.csv"), "binary"])
        if driven.returncode != 0:
            raise SystemExit("the stack did not drive the lap")


def direction_at(lap, k):
    """Of the recorded way."""
    before, after = lap[max(k - 1, 0)], lap[min(k + 1, len(lap) - 1)]
    return math.atan2(after[1] - before[1], after[0] - before[0])


def add_errors(errors, is_row, lap, k):
    """What differs from row k of the lap."""
    (x, y, yaw, vx, vy), (px, py, phi, pvx, pvy) = is_row, lap[k]
    direction = direction_at(lap, k)
    errors["vx_mps"].append(vx - pvx)
    errors["sideslip_rad"].append(math.atan2(vy, vx) - math.atan2(pvy, pvx))
    errors["lateral_m"].append(-math.sin(direction) * (x - px) + math.cos(direction) * (y - py))
    errors["heading_rad"].append(wrapped(yaw - phi))


def no_errors():
    return {name: [] for name in ("vx_mps", "sideslip_rad", "lateral_m", "heading_rad")}


def summed(errors):
    return {name: {"largest": max(abs(e) for e in es),
                   "rmse": math.sqrt(sum(e * e for e in es) / len(es)),
                   "mean": sum(es) / len(es)} for name, es in errors.items()}


def compare(folder, lap):
    """Errors of the driven lap beside the recorded one, at the same places."""
    with open(folder / "driven.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    at = [rows[0].index(name) for name in RECORDED]
    errors = no_errors()
    k = 0
    for row in rows[2000:]:  # it begins at rest: 20 s to come to the speed
        is_row = [float(row[c]) for c in at]
        x, y = is_row[:2]
        while k + 2 < len(lap) and math.hypot(lap[k + 1][0] - x, lap[k + 1][1] - y) < math.hypot(
                lap[k][0] - x, lap[k][1] - y):
            k += 1
        add_errors(errors, is_row, lap, k)
    return summed(errors)


def predict(lap, rate_hz, goes_on):
    """Errors of a predictor that knows the lap up to the begin of each window of 2 s: everything stays
    (`hold`), or goes on along its last 0.2 s (`trend`), as in crgdrive replay."""
    window, back = round(2.0 * rate_hz), round(0.2 * rate_hz)
    errors = no_errors()
    for begin in range(back, len(lap) - window, window):
        now, before = lap[begin], lap[begin - back]
        change = [0.0] * 5
        if goes_on:
            change = [a - b for a, b in zip(now, before)]
            change[2] = wrapped(change[2])
        for k in range(begin + 1, begin + window + 1):
            share = (k - begin) / back
            add_errors(errors, [value + share * by for value, by in zip(now, change)], lap, k)
    return summed(errors)


def main(bin_folder, stack, vehicle, recording, first, last, out):
    folder = pathlib.Path(out)
    lap, rate_hz = read_lap(recording, int(first), int(last))
    drive(folder, bin_folder, stack, vehicle, lap)
    table = compare(folder, lap)
    hold, trend = predict(lap, rate_hz, False), predict(lap, rate_hz, True)
    told = {name: {**error, "hold_rmse": hold[name]["rmse"], "trend_rmse": trend[name]["rmse"]}
            for name, error in table.items()}
    (folder / "errors.json").write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    words = ("largest", "rmse", "mean", "hold_rmse", "trend_rmse")
    print(" " * 14 + "".join(f"{word:>12}" for word in words))
    for name, error in told.items():
        print(f"{name:14}" + "".join(f"{error[word]:12.4f}" for word in words))


if __name__ == "__main__":
    if len(sys.argv) != 8:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
