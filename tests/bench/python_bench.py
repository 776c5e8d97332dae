"""What a call from Python costs, and what of the rate of C++ is left with arrays: python_bench.py PYTHON_BENCH [ROUNDS].

PYTHON_BENCH is the program beside this script. Both ask the same road (closed, 3 km, 0.1 m, 15 m wide) at the same points, in turn.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import kerbstone
import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
LENGTH_M, STEP_M = 3000.0, 0.1


def write_road(path: Path) -> None:
    u = np.arange(0, LENGTH_M + STEP_M / 2, STEP_M)
    heading = 2 * np.pi * u / LENGTH_M + 0.12 * np.sin(5 * 2 * np.pi * u / LENGTH_M)
    middle = (heading[1:] + heading[:-1]) / 2
    x, y = np.r_[0, np.cumsum(STEP_M * np.cos(middle))], np.r_[0, np.cumsum(STEP_M * np.sin(middle))]
    v = np.linspace(-7.5, 7.5, 151)
    z = 0.01 * np.sin(7 * u)[:, None] + 0.02 * np.cos(0.9 * v)[None, :]
    kerbstone.Road.from_arrays(x, y, v, z).write(str(path))


def wheels(road: kerbstone.Road) -> tuple[Numbers, Numbers]:
    """The paths of four wheels, one after another, at 60 m/s and 1 ms."""
    u = np.arange(2.0, LENGTH_M - 2.0, 0.06)
    v = 4 * np.sin(u / 90)
    ahead, left = np.array([1.4, 1.4, -1.4, -1.4]), np.array([0.8, -0.8, 0.8, -0.8])
    x, y = road.xy((u + ahead[:, None]).ravel(), (v + left[:, None]).ravel())
    return x, y


def rate(ask: Callable[[], object], count: int) -> float:
    begin = time.process_time()  # other work of the machine does not count
    ask()
    return 1e-6 * count / (time.process_time() - begin)


def call_ns(ask: Callable[[float, float], object], a: float, b: float, calls: int = 20_000) -> float:
    begin = time.process_time()
    for _ in range(calls):
        ask(a, b)
    return 1e9 * (time.process_time() - begin) / calls


def main(program: str, rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, points = Path(folder, "road.crg"), Path(folder, "points")
        write_road(path)
        road = kerbstone.Road.read(str(path))
        x, y = wheels(road)
        np.column_stack([x, y]).tofile(points)
        heights: list[float] = []
        everything: list[float] = []
        shares: dict[str, list[float]] = {"z": [], "sample": []}
        for _ in range(rounds):
            ran = subprocess.run([program, path, points, "3"], capture_output=True, text=True, check=True)
            of_cpp = [float(word) for word in ran.stdout.split()]
            heights.append(max(rate(lambda: road.z(x, y), x.size) for _ in range(3)))
            everything.append(max(rate(lambda: road.sample(x, y), x.size) for _ in range(3)))
            shares["z"].append(heights[-1] / of_cpp[0])
            shares["sample"].append(everything[-1] / of_cpp[1])
        calls: list[tuple[str, Callable[[float, float], object], float, float]] = [
            ("z(x, y)", road.z, x[0], y[0]),
            ("z_at_uv(u, v)", road.z_at_uv, 150.0, 1.0),
            ("uv(x, y)", road.uv, x[0], y[0]),
            ("sample(x, y)", road.sample, x[0], y[0]),
            ("a function of Python that does nothing", lambda a, b: None, 150.0, 1.0),
        ]
        for name, ask, a, b in calls:
            print(f"{name}, one call: {min(call_ns(ask, float(a), float(b)) for _ in range(10 * rounds)):.0f} ns")
        for name, rates in (("z", heights), ("sample", everything)):
            print(f"{name} of {x.size} points: {np.median(rates):.1f} M/s, {np.median(shares[name]):.0%} of C++ (median of {rounds})")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 7)
