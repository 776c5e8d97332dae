#!/usr/bin/python3
"""Recordings of a rigid car on roads that bank in their turns, stated flat. Shares no code with lib.

By the commands of docs/crgexplain.md:

  banked_roads.py make FOLDER --seed 1 --count 6,4,4    # of 15 to 24 degrees, of 5 to 15, flat
  banked_roads.py run FOLDER --explain build/test/tools/crgexplain/crgexplain --car vehicles/open_wheel/vehicle.yaml
  banked_roads.py score FOLDER                          # exit code 3: a row does not hold

The car moves along a given path on the road: its upright axis is the road's normal, its nose lies in
the road, turned off its course by a side slip. Places, heading and yaw rate are those of that motion.
`run` goes on where it was stopped.
"""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys

import numpy as np

STEP_M = 0.1  # of tables along the road and the path
G = 9.81


def step_up(t):
    t = np.clip(t, 0.0, 1.0)
    return t**3 * (10 - 15 * t + 6 * t * t)


def cumulative(x, step):
    """Integral by trapezia, from 0."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (x[1:] + x[:-1]) * step)])


def along(curvature):
    """Heading, x, y of a line of this curvature at steps of STEP_M."""
    heading = cumulative(curvature, STEP_M)
    middle = heading[:-1] + 0.5 * np.diff(heading)
    x = np.concatenate([[0.0], np.cumsum(np.cos(middle) * STEP_M)])
    y = np.concatenate([[0.0], np.cumsum(np.sin(middle) * STEP_M)])
    return heading, x, y


def turn_of(angle_rad, radius_m, ramp_m):
    """Curvature along a turn that begins and ends by a ramp."""
    length = abs(angle_rad) * radius_m + ramp_m
    s = np.arange(round(length / STEP_M)) * STEP_M
    k = step_up(s / ramp_m) * step_up((length - s) / ramp_m)
    return k * angle_rad / (k.sum() * STEP_M)


def closed_line(rng, oval):
    """Pieces (curvature, is it a turn) of a closed line of 1.5 to 2.5 km, to the left in all."""
    while True:
        if oval:
            count = int(rng.choice([2, 2, 3, 4]))
            angle = np.full(count, 2 * math.pi / count) if count != 3 else \
                np.array([1.0, 0.35, 0.65]) * math.pi
            radius = np.full(count, rng.uniform(110, 250))
        else:
            count = int(rng.integers(5, 9))
            angle = rng.uniform(0.5, 2.2, count)
            angle[rng.permutation(count)[: int(rng.integers(0, 3))]] *= -0.7
            angle *= 2 * math.pi / angle.sum()
            radius = rng.uniform(50, 160, count)
        if np.any(np.abs(angle) < 0.3) or angle.max() > 3.3 or angle.min() < -2:
            continue
        turns = [turn_of(a, r, min(rng.uniform(40, 90), 0.8 * abs(a) * r)) for a, r in zip(angle, radius)]
        direction, gap, heading = [], np.zeros(2), 0.0
        for k in turns:
            direction.append([math.cos(heading), math.sin(heading)])
            h, x, y = along(np.append(k, k[-1]))
            c, s = math.cos(heading), math.sin(heading)
            gap += [c * x[-1] - s * y[-1], s * x[-1] + c * y[-1]]
            heading += h[-1]
        d = np.array(direction).T
        straight = rng.uniform(80, 420, count)
        straight -= d.T @ np.linalg.lstsq(d @ d.T, d @ straight + gap, rcond=None)[0]
        length = straight.sum() + sum(len(k) for k in turns) * STEP_M
        if straight.min() < 60 or not 1500 < length < 2500:
            continue
        pieces = []
        for piece_m, k in zip(straight, turns):
            pieces += [(np.zeros(round(piece_m / STEP_M)), False), (k, True)]
        heading, x, y = along(np.concatenate([k for k, _ in pieces]))
        if math.hypot(x[-1], y[-1]) > 3:
            continue
        far = np.arange(0, len(x), 100)
        apart = np.hypot(x[far, None] - x[far], y[far, None] - y[far])
        between = np.abs(far[:, None] - far) * STEP_M
        between = np.minimum(between, length - between)
        if apart[between > 80].min() > 45:
            return pieces


class Road:
    """Tables over s at steps of STEP_M, of one closed lap: x, y, heading, curvature, bank (rise to the
    left, m/m), and z on the line."""

    def __init__(self, rng, oval, bank_deg):
        pieces = closed_line(rng, oval)
        k = np.concatenate([piece for piece, _ in pieces])
        self.n = len(k)
        self.length_m = self.n * STEP_M
        heading, x, y = along(np.append(k, k[0]))
        share = np.linspace(0, 1, self.n + 1)  # less than 3 m that are missing to the lap
        self.x, self.y = (x - share * x[-1])[:-1], (y - share * y[-1])[:-1]
        dx, dy = self.along(self.x), self.along(self.y)
        self.heading = np.unwrap(np.arctan2(dy, dx))
        self.curvature = k
        # Each turn leans into itself, about its inner edge, its middle or its outer edge.
        self.half_width_m = rng.uniform(8.5, 11)
        pivot = rng.choice(["inner", "middle", "outer"])
        lean_over_m = rng.uniform(60, 110)
        straight_deg = bank_deg * rng.uniform(0, 0.5) if oval else 0.0
        bank, lift = np.zeros(self.n), np.zeros(self.n)
        s = np.arange(self.n) * STEP_M
        begin, self.is_turn, first = 0, np.zeros(self.n, bool), True
        for piece, turn in pieces:
            if turn:
                side = np.sign(piece.sum())
                lean = bank_deg * (1.0 if oval or first else rng.uniform(0.85, 1.0))
                first = False
                end_m, begin_m = (begin + len(piece)) * STEP_M, begin * STEP_M
                shape = sum(step_up((s + w - begin_m) / lean_over_m + 0.5)
                            - step_up((s + w - end_m) / lean_over_m + 0.5)
                            for w in (-self.length_m, 0, self.length_m))
                rise = -side * shape * (math.tan(math.radians(lean)) - math.tan(math.radians(straight_deg)))
                v = {"inner": side, "middle": 0.0, "outer": -side}[pivot] * self.half_width_m
                bank += rise
                lift -= rise * v
                whole = (s > begin_m + 0.5 * lean_over_m) & (s < end_m - 0.5 * lean_over_m)
                self.is_turn |= whole & (np.abs(self.curvature) > 0.6 * np.abs(piece).max())
            begin += len(piece)
        self.bank = bank - math.tan(math.radians(straight_deg))
        self.lift = lift - lift.mean()
        self.pivot, self.bank_deg, self.straight_deg = str(pivot), bank_deg, straight_deg

    def along(self, table):
        return (np.roll(table, -1) - np.roll(table, 1)) / (2 * STEP_M)

    def write_flat(self, path):
        """The same line without heights, as OpenCRG (KDBI)."""
        every = 5
        x, y = self.x[::every], self.y[::every]
        x, y = np.append(x, x[0]), np.append(y, y[0])
        step = np.hypot(np.diff(x), np.diff(y)).mean()
        phi = np.unwrap(np.arctan2(np.diff(y), np.diff(x)))
        phi = np.append(phi[0], phi)
        v = np.linspace(-self.half_width_m, self.half_width_m, 5)
        head = ["$CT", "a flat road", "$", "$ROAD_CRG"]
        values = dict(START_U=0, START_X=x[0], START_Y=y[0], START_PHI=phi[0], END_U=step * (len(x) - 1),
                      END_X=x[-1], END_Y=y[-1], END_PHI=phi[-1], INCREMENT=step)
        head += [f"REFERENCE_LINE_{k} = {float(a)!r}" for k, a in values.items()]
        head += ["$", "$ROAD_CRG_OPTS", "REFLINE_CONTINUATION = 1"]
        head += ["$", "$KD_DEFINITION", "#:KDBI", "D:reference line phi,rad"]
        head += [f"D:long section at v = {a:.6f},m" for a in v] + ["$", "$" * 80]
        data = np.column_stack([phi, np.zeros((len(phi), len(v)))]).ravel()
        data = np.concatenate([data, np.full(-len(data) % 10, np.nan)])
        path.write_bytes("".join(f"{line:<80.80}\n"[:81] for line in head[:-1]).encode()
                         + (head[-1] + "\n").encode() + data.astype(">f8").tobytes())


def filtered(x, time_s, dt):
    """First order."""
    if time_s <= 0:
        return x
    out, a, now = np.empty_like(x), 1 - math.exp(-dt / time_s), x[0]
    for i, value in enumerate(x):
        now += (value - now) * a
        out[i] = now
    return out


def wandering(rng, n, dt, sd, time_s):
    """Noise that goes on for `time_s`."""
    a = math.exp(-dt / time_s)
    kicks, out = rng.normal(0, sd * math.sqrt(1 - a * a), n), np.empty(n)
    now = rng.normal(0, sd)
    for i in range(n):
        now = a * now + kicks[i]
        out[i] = now
    return out


def drive(rng, road, beside_m):
    """The exact motion at 500 Hz, by laps of different speed."""
    total_m = max(2.15 * road.length_m, 6500.0)
    n = int(total_m / STEP_M)
    s = rng.uniform(0, road.length_m) + np.arange(n) * STEP_M
    at = np.round(s / STEP_M).astype(int) % road.n
    lap = (np.arange(n) * STEP_M / road.length_m)

    def wave(size, length_m):
        return size * np.sin(2 * math.pi * s / length_m + rng.uniform(0, 2 * math.pi))

    v = beside_m + wave(rng.uniform(0.3, 1.2), rng.uniform(500, 900)) + wave(0.3, rng.uniform(230, 330))
    v = np.clip(v, -8, 8)
    k, bank = road.curvature[at], road.bank[at]
    # As fast as its tyres hold, up to a top speed, in laps of different haste.
    grip = rng.uniform(7, 14)
    hold = grip + G * np.abs(bank)
    top = rng.uniform(42, 68)
    haste = np.interp(lap, np.arange(12), rng.uniform(0.78, 1.0, 12))
    speed = haste * np.minimum(top, np.sqrt(hold / np.maximum(np.abs(k), 1e-5)))
    for way in (1, -1):  # accelerates and brakes within limits
        square, most = speed[::way] ** 2, (4.0 if way == 1 else 8.0)
        for i in range(1, n):
            square[i] = min(square[i], square[i - 1] + 2 * most * STEP_M)
        speed = np.sqrt(square)[::way]
    smooth = np.hanning(401) / np.hanning(401).sum()
    pad = np.pad(speed, 200, mode="edge")
    speed = np.convolve(pad, smooth, mode="valid")

    heading = road.heading[at]
    sin, cos = np.sin(heading), np.cos(heading)
    turned = road.along(np.unwrap(road.heading, period=2 * math.pi))
    wrap = 2 * math.pi / (2 * STEP_M)
    turned = np.where(np.abs(turned) > 1, turned - np.sign(turned) * wrap, turned)[at]
    place = np.stack([road.x[at] - v * sin, road.y[at] + v * cos, road.lift[at] + bank * v], 1)
    by_s = np.stack([(1 - v * turned) * cos, (1 - v * turned) * sin,
                     road.along(road.lift)[at] + road.along(road.bank)[at] * v], 1)
    by_v = np.stack([-sin, cos, bank], 1)
    up = np.cross(by_s, by_v)
    up /= np.linalg.norm(up, axis=1)[:, None]
    moved = by_s + by_v * np.gradient(v, STEP_M)[:, None]
    path_m = np.linalg.norm(moved, axis=1)  # per metre of s
    course = moved / path_m[:, None]
    lateral = speed**2 * k / np.sqrt(1 + bank**2) + G * bank / np.sqrt(1 + bank**2)
    slip = rng.uniform(-1.2e-3, -1e-4) * lateral
    left = np.cross(up, course)
    nose = np.cos(slip)[:, None] * course - np.sin(slip)[:, None] * left
    left = np.cross(up, nose)
    time = cumulative(path_m / speed, STEP_M)
    rate = np.sum(np.gradient(nose, STEP_M, axis=0) * left, 1) * speed / path_m
    dt = 0.002
    clock = np.arange(int(time[-1] / dt)) * dt
    out = {name: np.interp(clock, time, column) for name, column in
           dict(x=place[:, 0], y=place[:, 1], rate=rate, vx=speed * np.cos(slip), vy=speed * np.sin(slip),
                yaw=np.unwrap(np.arctan2(nose[:, 1], nose[:, 0])), speed=speed).items()}
    return clock, dt, out


def log_of(rng, motion, with_heading):
    """What a logger writes of it, and what is wrong with that."""
    clock, dt, m = motion
    truth = dict(gyro_filter_s=rng.uniform(0.0, 0.3), gyro_delay_s=rng.uniform(0, 0.12),
                 ax_filter_s=rng.uniform(0.3, 2.6), gyro_gain=rng.normal(0, 0.001),
                 gyro_bias_radps=rng.normal(0, 4e-4), rate_hz=float(rng.choice([20, 25, 50])))
    late = int(truth["gyro_delay_s"] / dt)
    rate = filtered(m["rate"], truth["gyro_filter_s"], dt)
    rate = np.concatenate([np.full(late, rate[0]), rate])[: len(clock)]
    ax = filtered(np.gradient(m["vx"], dt), truth["ax_filter_s"], dt)
    every = round(1 / truth["rate_hz"] / dt)
    pick = slice(int(2 / dt), None, every)
    t = clock[pick]
    n, step = len(t), every * dt
    place_sd, speed_sd = rng.uniform(0.01, 0.05), rng.uniform(0.01, 0.06)
    columns = {
        "time_s": t - t[0],
        "x_m": m["x"][pick] + rng.normal(0, place_sd, n) + wandering(rng, n, step, 0.06, 20),
        "y_m": m["y"][pick] + rng.normal(0, place_sd, n) + wandering(rng, n, step, 0.06, 20),
        "vx_mps": m["vx"][pick] + rng.normal(0, speed_sd, n),
        "yaw_rate_radps": (1 + truth["gyro_gain"]) * rate[pick] + truth["gyro_bias_radps"]
                          + rng.normal(0, rng.uniform(1e-3, 3e-3), n),
        "ax_mps2": ax[pick] + rng.normal(0, 0.02, n)}
    if with_heading:
        columns["yaw_rad"] = m["yaw"][pick] + rng.normal(0, 1e-3, n) + wandering(rng, n, step, 6e-4, 5)
        if rng.random() < 0.5:
            columns["vy_mps"] = m["vy"][pick] + rng.normal(0, speed_sd, n)
    return columns, truth


def make(options):
    rng = np.random.default_rng(options.seed)
    counts = [int(k) for k in options.count.split(",")]
    options.folder.mkdir(parents=True, exist_ok=True)
    number = 0
    for kind, count, low, high in zip(("steep", "mild", "flat"), counts, (15, 5, 0), (24, 15, 0)):
        for case in range(count):
            own = np.random.default_rng(rng.integers(2**63))
            road = Road(own, case % 2 == 0, own.uniform(low, high))
            side = own.choice([-1, 1])
            beside_m = side * own.uniform(0, 8)
            with_heading = case % 3 != 2
            columns, truth = log_of(own, drive(own, road, beside_m), with_heading)
            folder = options.folder / f"{number:03d}"
            folder.mkdir(exist_ok=True)
            number += 1
            np.savetxt(folder / "log.csv", np.column_stack(list(columns.values())), fmt="%.8f", delimiter=",",
                       header=",".join(columns), comments="")
            stated = "line" if own.random() < 0.5 else "driven"
            if stated == "line":
                road.write_flat(folder / "flat.crg")
            np.savez(folder / "truth.npz", x=road.x[::10], y=road.y[::10], bank=road.bank[::10],
                     is_turn=road.is_turn[::10])
            truth |= dict(kind=kind, oval=case % 2 == 0, bank_deg=road.bank_deg, beside_m=beside_m,
                          pivot=road.pivot, straight_deg=road.straight_deg, heading=with_heading,
                          stated=stated, length_m=road.length_m, seconds=columns["time_s"][-1])
            (folder / "truth.json").write_text(json.dumps(truth, indent=1))
    print(f"{number} recordings below {options.folder}")


def cases(folder):
    return sorted(path.parent for path in folder.glob("*/truth.json"))


def run(options):
    explain = options.explain.resolve()
    for folder in cases(options.folder):
        flat, out = folder / "flat.crg", folder / "out"
        if (out / "findings.json").exists():
            continue
        if not flat.exists():
            subprocess.run([explain, "road", folder / "log.csv", "-o", flat], check=True,
                           stdout=subprocess.DEVNULL)
        words = [explain, "run", "--road", flat, "--car", options.car, "--log", folder / "log.csv",
                 "--skip-simulation", "-o", out]
        with open(folder / "said.txt", "w", encoding="utf-8") as said:
            code = subprocess.run(words, stdout=said, stderr=said, check=False).returncode
        print(folder.name, "exit code", code, flush=True)


def line_of(path):
    """x, y and step of the reference line of an OpenCRG file in binary, by its headings."""
    raw = path.read_bytes()
    end = raw.index(b"\n$$$$") + 1
    head = raw[:end].decode("latin1")
    value = {k: float(v) for k, v in re.findall(r"REFERENCE_LINE_(\w+)\s*=\s*([-+0-9.eE]+)", head)}
    kind = ">f8" if "#:KDBI" in head else ">f4"
    names = re.findall(r"D:([^\r\n]*)", head)
    begin = raw.index(b"\n", end) + 1
    data = np.frombuffer(raw[begin:begin + (len(raw) - begin) // int(kind[2]) * int(kind[2])], kind)
    rows = round((value["END_U"] - value["START_U"]) / value["INCREMENT"]) + 1
    data = data[: rows * len(names)].reshape(rows, len(names)).astype(float)
    phi = data[1:, next(i for i, name in enumerate(names) if "phi" in name)]
    step = value["INCREMENT"]
    x = value["START_X"] + np.concatenate([[0], np.cumsum(np.cos(phi) * step)])
    y = value["START_Y"] + np.concatenate([[0], np.cumsum(np.sin(phi) * step)])
    share = np.linspace(0, 1, rows)
    x -= share * (x[-1] - value.get("END_X", x[-1]))
    y -= share * (y[-1] - value.get("END_Y", y[-1]))
    return x, y, step


def judged(folder):
    """One recording: what was said against what is."""
    truth = json.loads((folder / "truth.json").read_text())
    table = np.load(folder / "truth.npz")
    out = dict(truth=truth, name=folder.name)
    path = folder / "out" / "findings.json"
    if not path.exists():
        return out | dict(failed=(folder / "said.txt").read_text()[-300:])
    found = json.loads(path.read_text())
    out["verdict"] = found["verdict"]
    out["names"] = [f["mechanism"] + (":" + f["channel"] if f.get("channel") else "") for f in found["findings"]]
    said = " ".join(found["remarks"])
    limit = re.search(r"leans by at most ([0-9.]+) degrees", said)
    out["limit_deg"] = float(limit[1]) if limit else None
    banking = next((f for f in found["findings"] if f["mechanism"] == "road.banking"), None)
    if banking and banking.get("profile"):
        x, y, step = line_of(folder / "flat.crg")
        u = np.array([p["u_m"] for p in banking["profile"]])
        at = np.minimum(np.round(u / step).astype(int), len(x) - 1)
        near = np.argmin((x[at, None] - table["x"]) ** 2 + (y[at, None] - table["y"]) ** 2, axis=1)
        value = np.array([p["value"] for p in banking["profile"]])
        half = np.array([p["ci90"] for p in banking["profile"]])
        turn, bank = table["is_turn"][near], table["bank"][near]
        deg = lambda a: np.degrees(np.arctan(a))
        off = np.abs(deg(value) - deg(bank))
        out["right"] = float(np.mean(off[turn] < np.maximum(0.1 * np.abs(deg(bank[turn])), 2)))
        out["half_deg"] = float(np.median(0.5 * (deg(np.abs(value) + half) - deg(np.abs(value) - half))[turn]))
        out["inside"] = (np.abs(value - bank) <= half)[turn].tolist()
        out["off_deg"] = float(np.median((deg(np.abs(value)) - deg(np.abs(bank)))[turn]))
    if banking and banking["parameters"]:
        p = banking["parameters"][0]
        out["lean_deg"] = [math.degrees(math.atan(abs(p[k]))) for k in ("value", "low", "high") if k in p]
    return out


# What may be named beside the banking: what is wrong with the recording.
RIGHT = {"sensor.low_pass:ax_mps2", "sensor.delay:ax_mps2", "sensor.derived:ax_mps2",
         "sensor.low_pass:yaw_rate_radps", "sensor.delay:yaw_rate_radps"}


def score(options):
    rows = [judged(folder) for folder in cases(options.folder)]
    inside, half, good = [], [], {"steep": 0, "mild": 0, "flat": 0}
    count = dict.fromkeys(good, 0)
    gains = others = right = 0
    for row in rows:
        truth = row["truth"]
        kind = truth["kind"]
        count[kind] += 1
        text = (f"{row['name']} {kind:5} {truth['bank_deg']:4.1f} {'oval' if truth['oval'] else 'road'} "
                f"{'heading' if truth['heading'] else 'places '} {truth['stated']:6} {truth['pivot']:6} "
                f"{truth['beside_m']:+.1f} m  ")
        if "failed" in row:
            print(text + "FAILED " + row["failed"])
            continue
        names = row["names"]
        banked = "road.banking" in names
        more = [n for n in names if n != "road.banking" and n not in RIGHT]
        gains += any(n.startswith("sensor.gain:yaw_rate") for n in names)
        others += bool(more)
        if kind == "steep":
            good[kind] += banked
            right += row.get("right", 0) >= 0.8
            half.append(row.get("half_deg", 99))
        elif kind == "mild":
            held = row["limit_deg"] is not None and row["limit_deg"] >= truth["bank_deg"]
            good[kind] += (banked or held) and not more
        else:
            good[kind] += not any(n.startswith("road.") for n in names)
        inside += row.get("inside", [])
        if "right" in row:
            text += (f"off {row['off_deg']:+.1f} right {row['right']:.2f} half {row['half_deg']:.1f} "
                     f"in {np.mean(row['inside']):.2f}  ")
        elif row["limit_deg"] is not None:
            text += f"at most {row['limit_deg']:.0f}  "
        print(text + row["verdict"] + " " + ", ".join(names))
    print(f"15 to 24 degrees: named {good['steep']} of {count['steep']}, right over 80 % of the turns {right}, "
          f"half of the 90 % interval {np.median(half) if half else math.nan:.1f} degrees (median)")
    print(f"5 to 15 degrees: named, tied or a limit that holds, and nothing else: {good['mild']} of {count['mild']}")
    print(f"flat: no road named: {good['flat']} of {count['flat']}")
    print(f"places of turns inside the 90 % interval: {np.mean(inside) if inside else math.nan:.3f}")
    print(f"gain of the gyro named: {gains}; other names: {others}")
    held = (good["steep"] >= 0.9 * count["steep"] and right >= 0.9 * count["steep"] and good["mild"] == count["mild"]
            and good["flat"] == count["flat"] and gains == 0 and (not half or np.median(half) <= 3)
            and (not inside or 0.85 <= np.mean(inside) <= 0.95))
    return 0 if held else 3


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("make", "run", "score"):
        command = commands.add_parser(name)
        command.add_argument("folder", type=pathlib.Path)
        if name == "make":
            command.add_argument("--seed", type=int, required=True)
            command.add_argument("--count", default="30,15,15")
        if name == "run":
            command.add_argument("--explain", type=pathlib.Path, required=True)
            command.add_argument("--car", type=pathlib.Path, required=True)
    options = parser.parse_args()
    sys.exit({"make": make, "run": run, "score": score}[options.command](options) or 0)


if __name__ == "__main__":
    main()
