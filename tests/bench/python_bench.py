"""What a call from Python costs, and what of the rate of C++ is left with arrays: python_bench.py PYTHON_BENCH [ROUNDS].

PYTHON_BENCH is the program beside this script. Both ask the same road (closed, 3 km, 0.1 m, 15 m wide) at the same points, in turn.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import kerbstone
import numpy as np

LENGTH_M, STEP_M = 3000.0, 0.1


def write_road(path: Path) -> None:
    u = np.arange(0, LENGTH_M + STEP_M / 2, STEP_M)
    heading = 2 * np.pi * u / LENGTH_M + 0.12 * np.sin(5 * 2 * np.pi * u / LENGTH_M)
    middle = (heading[1:] + heading[:-1]) / 2
    x, y = (np.r_[0, np.cumsum(STEP_M * of(middle))] for of in (np.cos, np.sin))
    v = np.linspace(-7.5, 7.5, 151)
    z = 0.01 * np.sin(7 * u)[:, None] + 0.02 * np.cos(0.9 * v)[None, :]
    kerbstone.Road.from_arrays(x, y, v, z).write(str(path))


def wheels(road: kerbstone.Road) -> tuple[np.ndarray, np.ndarray]:
    """Four wheels at 60 m/s and 1 ms."""
    u = np.arange(2.0, LENGTH_M - 2.0, 0.06)
    v = 4 * np.sin(u / 90)
    ahead, left = np.array([1.4, 1.4, -1.4, -1.4]), np.array([0.8, -0.8, 0.8, -0.8])
    x, y = road.xy((u[:, None] + ahead).ravel(), (v[:, None] + left).ravel())
    return x, y


def rate(ask, count: int) -> float:
    begin = time.perf_counter()
    ask()
    return 1e-6 * count / (time.perf_counter() - begin)


def call_ns(ask, calls: int = 200_000) -> float:
    begin = time.perf_counter()
    for _ in range(calls):
        ask(150.0, 20.0)
    return 1e9 * (time.perf_counter() - begin) / calls


def main(program: str, rounds: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path, points = Path(folder, "road.crg"), Path(folder, "points")
        write_road(path)
        road = kerbstone.Road.read(str(path))
        x, y = wheels(road)
        np.column_stack([x, y]).tofile(points)
        heights, everything, shares = [], [], {"z": [], "sample": []}
        for _ in range(rounds):
            ran = subprocess.run([program, path, points, "3"], capture_output=True, text=True, check=True)
            of_cpp = [float(word) for word in ran.stdout.split()]
            heights.append(max(rate(lambda: road.z(x, y), x.size) for _ in range(3)))
            everything.append(max(rate(lambda: road.sample(x, y), x.size) for _ in range(3)))
            shares["z"].append(heights[-1] / of_cpp[0])
            shares["sample"].append(everything[-1] / of_cpp[1])
        empty = min(call_ns(lambda a, b: None) for _ in range(rounds))
        for name, ask in (("z", road.z), ("z_at_uv", road.z_at_uv), ("sample", road.sample)):
            print(f"{name}(x, y), one call: {min(call_ns(ask) for _ in range(rounds)):.0f} ns; a function of Python that does nothing: {empty:.0f}")
        for name, rates in (("z", heights), ("sample", everything)):
            print(f"{name} of {x.size} points: {np.median(rates):.1f} M/s, {np.median(shares[name]):.0%} of C++ (median of {rounds})")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    main(sys.argv[1], int(sys.argv[2]) if len(sys.argv) == 3 else 7)
