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
    """Rows of the lap in the frame of the car at its begin: x, y, heading, vx, vy."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    columns = [rows[0].index(name) for name in ("x(m)", "y(m)", "phi(rad)", "vx(m/s)", "vy(m/s)")]
    lap = [[float(row[c]) for c in columns] for row in rows[1 + first:1 + last]]
    x0, y0 = lap[0][:2]
    ahead = next(row for row in lap if math.hypot(row[0] - x0, row[1] - y0) > 3.0)
    yaw0 = math.atan2(ahead[1] - y0, ahead[0] - x0)
    c, s = math.cos(yaw0), math.sin(yaw0)
    return [[c * (x - x0) + s * (y - y0), -s * (x - x0) + c * (y - y0), wrapped(phi - yaw0), vx, vy]
            for x, y, phi, vx, vy in lap]


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


def compare(folder, lap):
    """Errors of the driven lap beside the recorded one, at the same places."""
    with open(folder / "driven.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    at = [rows[0].index(name) for name in RECORDED]
    errors = {"vx_mps": [], "sideslip_rad": [], "lateral_m": [], "heading_rad": []}
    k = 0
    for row in rows[2000:]:  # it begins at rest: 20 s to come to the speed
        x, y, yaw, vx, vy = (float(row[c]) for c in at)
        while k + 2 < len(lap) and math.hypot(lap[k + 1][0] - x, lap[k + 1][1] - y) < math.hypot(
                lap[k][0] - x, lap[k][1] - y):
            k += 1
        px, py, phi, pvx, pvy = lap[k]
        direction = math.atan2(lap[k + 1][1] - lap[max(k - 1, 0)][1],
                               lap[k + 1][0] - lap[max(k - 1, 0)][0])
        errors["vx_mps"].append(vx - pvx)
        errors["sideslip_rad"].append(math.atan2(vy, vx) - math.atan2(pvy, pvx))
        errors["lateral_m"].append(-math.sin(direction) * (x - px) + math.cos(direction) * (y - py))
        errors["heading_rad"].append(wrapped(yaw - phi))
    return {name: {"largest": max(abs(e) for e in es),
                   "rmse": math.sqrt(sum(e * e for e in es) / len(es)),
                   "mean": sum(es) / len(es)} for name, es in errors.items()}


def main(bin_folder, stack, vehicle, recording, first, last, out):
    folder = pathlib.Path(out)
    lap = read_lap(recording, int(first), int(last))
    drive(folder, bin_folder, stack, vehicle, lap)
    table = compare(folder, lap)
    (folder / "errors.json").write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")
    print(f"{'':14}{'largest':>10}{'rmse':>10}{'mean':>10}")
    for name, error in table.items():
        print(f"{name:14}{error['largest']:10.4f}{error['rmse']:10.4f}{error['mean']:10.4f}")


if __name__ == "__main__":
    if len(sys.argv) != 8:
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
