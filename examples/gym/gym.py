"""Cars to learn on: many of one kind on one road, with reset and step.

    python3 gym.py vehicle.yaml          # an example and its speed
    python3 gym.py vehicle.yaml road.crg

Stepping releases the interpreter's lock: a Gym in each thread uses all cores.
"""

import sys
import time

import kerbstone
import numpy as np

# steer_rad, throttle, brake_pa of each wheel
ACTIONS = 6
OBSERVATIONS = ("u_m", "v_m", "yaw_rad", "vx_mps", "vy_mps", "yaw_rate_radps")


class Gym:
    """`cars` cars on a road. `begin` is what Car.start_many takes: u_m, speed_mps, gear ..."""

    def __init__(self, car, road, cars=1, steps=10, observations=OBSERVATIONS, **begin):
        self._drives = car.start_many(road, cars=cars, **begin)
        self.cars, self.steps = cars, steps
        self.observation_names = tuple(observations)
        self.failed = []  # cars that cannot go on: they stand until reset() or load()

    def step(self, actions, gears):
        """Actions, cars x ACTIONS, and a gear of each; observations, cars x observation_names.

        A car that rolled over, or has no road under a wheel, stands and is in `failed`; the others
        drive on. Beside the road its edge goes on: compare v_m with its width."""
        actions = np.asarray(actions, dtype=float).reshape(self.cars, ACTIONS)
        self._drives.step(steer_rad=actions[:, 0], throttle=actions[:, 1], brake_pa=actions[:, 2:],
                          gear=gears, steps=self.steps)
        self.failed = [car for car, why in enumerate(self._drives.problems) if why]
        return np.stack([self._drives[name] for name in self.observation_names], axis=1)

    def save(self, car):
        """The state of a car: any car of this Gym takes it."""
        return self._drives.state(car)

    def load(self, car, state):
        self._drives.set_state(car, state)

    def reset(self, car):
        """Back to how it began."""
        self._drives.reset(car)


def flat_road(length_m=3000.0):
    """Flat, 24 m wide; from 20 m before its end there is nothing."""
    u_m = np.arange(0.0, length_m + 1.0)
    z_m = np.zeros((u_m.size, 3))
    z_m[-20:] = np.nan
    return kerbstone.Road.from_arrays(u_m, 0 * u_m, [-12.0, 0.0, 12.0], z_m)


def check_failing(car):
    """One that comes to the end of the road stands until it is reset; the other drives on."""
    gym = Gym(car, flat_road(200.0), cars=2, u_m=[160.0, 20.0], speed_mps=40.0, gear=3)
    for _ in range(50):
        seen = gym.step(np.zeros((2, ACTIONS)), 3)
    failed = gym.failed
    gym.reset(0)
    gym.step(np.zeros((2, ACTIONS)), 3)
    if failed != [0] or gym.failed or not seen[1, 0] > 30.0:
        raise SystemExit("one car that fails is not what stops, or it does not begin again")


def main(vehicle, road=None, cars=100, decisions=100):
    car = kerbstone.Car.read(vehicle)
    gym = Gym(car, kerbstone.Road.read(road) if road else flat_road(), cars, u_m=20.0,
              speed_mps=30.0, gear=3)
    speed = gym.observation_names.index("vx_mps")
    # Each car turns and brakes a little more than the one before.
    more = np.arange(cars)
    actions = np.column_stack([0.0005 * more, np.full(cars, 0.3), *[5e3 * more] * 4])
    begin = time.perf_counter()
    for _ in range(decisions):
        seen = gym.step(actions, 3)
    took_s = time.perf_counter() - begin
    if not (np.diff(seen[:, speed]) < 0).all():
        raise SystemExit("more brakes, more speed: something is wrong")
    # From one state the same actions lead to the same place, bit for bit, in any car.
    middle = gym.save(cars // 2)
    for k in range(cars):
        gym.load(k, middle)
    seen = gym.step(np.tile(actions[0], (cars, 1)), 3)
    if (seen != seen[0]).any():
        raise SystemExit("one state went on in two ways")
    for k in range(cars):
        gym.reset(k)
    if abs(gym.step(actions, 3)[0, speed] - 30.0) > 1.0:
        raise SystemExit("a reset did not begin anew")
    check_failing(car)
    steps = cars * decisions * gym.steps
    print(f"{cars} cars, {steps} steps of 1 ms in {took_s:.2f} s: "
          f"{steps / took_s:.0f} steps per second, {steps / took_s / 1000:.0f} times real time")


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    main(*sys.argv[1:])
