"""Cars to learn on: many of one unit in one process, with reset and step.

    cc -O2 -shared -fPIC -o libgym.so gym.c
    python3 gym.py ./libgym.so car.fmu          # an example and its speed

The unit is one of `crgdrive fmu`. Actions and observations are numbers of it by their names.
"""

import ctypes
import pathlib
import sys
import tempfile
import time
import xml.etree.ElementTree
import zipfile

ACTIONS = ("input.steering", "input.throttle", "input.brake.fl", "input.brake.fr",
           "input.brake.rl", "input.brake.rr")
OBSERVATIONS = ("car.u", "car.v", "car.yaw", "car.vx", "car.vy", "car.yaw_rate")


def _array(kind, values):
    return (kind * len(values))(*values)


class Gym:
    """`cars` cars of a unit. `start` holds parameters by name, set before the initialisation."""

    def __init__(self, library, unit, cars=1, steps=10, step_s=0.001, start=None,
                 actions=ACTIONS, observations=OBSERVATIONS):
        self._folder = tempfile.TemporaryDirectory()
        folder = pathlib.Path(self._folder.name)
        with zipfile.ZipFile(unit) as archive:
            archive.extractall(folder)
        description = xml.etree.ElementTree.parse(folder / "modelDescription.xml").getroot()
        if description.get("fmiVersion") != "2.0":
            raise ValueError(f"{unit}: a unit of FMI 2.0 is wanted")
        name = description.find("CoSimulation").get("modelIdentifier")
        known = {variable.get("name"): int(variable.get("valueReference"))
                 for variable in description.iter("ScalarVariable")}
        self._refs = {key: _array(ctypes.c_uint, [known[name] for name in names])
                      for key, names in (("start", start or {}), ("action", actions),
                                         ("observation", observations))}
        self._gear = known["input.gear"]
        self.cars, self.steps = cars, steps
        self.observation_names = tuple(observations)
        lib = self._lib = ctypes.CDLL(str(library))
        lib.gym_make.restype = ctypes.c_void_p
        lib.gym_make.argtypes = [ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_int,
                                 ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int]
        lib.gym_step.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p,
                                 ctypes.c_int, ctypes.c_uint, ctypes.c_void_p, ctypes.c_void_p,
                                 ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p]
        lib.gym_state_size.restype = ctypes.c_size_t
        lib.gym_state_size.argtypes = [ctypes.c_void_p, ctypes.c_int]
        lib.gym_save.argtypes = lib.gym_load.argtypes = [ctypes.c_void_p, ctypes.c_int,
                                                         ctypes.c_char_p, ctypes.c_size_t]
        lib.gym_free.argtypes = [ctypes.c_void_p]
        values = _array(ctypes.c_double, list((start or {}).values()))
        self._gym = lib.gym_make(
            str(folder / "binaries/linux64" / f"{name}.so").encode(),
            description.get("guid").encode(), (folder / "resources").as_uri().encode(), cars,
            step_s, self._refs["start"], values, len(values))
        if not self._gym:
            raise RuntimeError(f"{unit}: the unit cannot be made; what it says stands above")
        self._seen = (ctypes.c_double * (cars * len(observations)))()
        self._refused = (ctypes.c_int * cars)()
        self.failed = []  # cars that refused the last step: they stand until reset() or load()
        self._begin = self.save(0)

    def step(self, actions, gears):
        """Actions of all cars, car after car, and their gears; all observations, car after car.

        A car that left the road or rolled over stands, and is in `failed`; the others drive on."""
        self._lib.gym_step(
            self._gym, self.steps, self._refs["action"], _array(ctypes.c_double, actions),
            len(self._refs["action"]), self._gear, _array(ctypes.c_int, gears),
            self._refs["observation"], self._seen, len(self._refs["observation"]), self._refused)
        self.failed = [car for car in range(self.cars) if self._refused[car]]
        return list(self._seen)

    def save(self, car):
        """The state of a car: bytes that any car of the same unit takes."""
        bytes_ = ctypes.create_string_buffer(self._lib.gym_state_size(self._gym, car))
        if len(bytes_) == 0 or self._lib.gym_save(self._gym, car, bytes_, len(bytes_)) != 0:
            raise RuntimeError("the unit does not give its state")
        return bytes_.raw

    def load(self, car, state):
        if self._lib.gym_load(self._gym, car, state, len(state)) != 0:
            raise RuntimeError("the unit does not take this state")

    def reset(self, car):
        """Back to how it was made."""
        self.load(car, self._begin)

    def close(self):
        self._lib.gym_free(self._gym)
        self._gym = None
        self._folder.cleanup()


def main(library, unit, cars=100, decisions=100):
    gym = Gym(library, unit, cars, start={"start.speed": 30.0})
    speed = gym.observation_names.index("car.vx")
    width = len(gym.observation_names)
    # Each car turns and brakes a little more than the one before.
    actions = [x for i in range(cars) for x in (0.0005 * i, 0.3, *[5e3 * i] * 4)]
    gears = [3] * cars
    begin = time.perf_counter()
    for _ in range(decisions):
        seen = gym.step(actions, gears)
    took_s = time.perf_counter() - begin
    if not all(seen[width * i + speed] > seen[width * (i + 1) + speed] for i in range(cars - 1)):
        raise SystemExit("more brakes, more speed: something is wrong")
    # From one state the same actions lead to the same place, bit for bit, in any car.
    middle = gym.save(cars // 2)
    same = actions[:6] * cars
    for car in range(cars):
        gym.load(car, middle)
    seen = gym.step(same, gears)
    if any(seen[width * i:width * (i + 1)] != seen[:width] for i in range(cars)):
        raise SystemExit("one state went on in two ways")
    for car in range(cars):
        gym.reset(car)
    again = gym.step(actions, gears)
    if abs(again[speed] - 30.0) > 1.0:
        raise SystemExit("a reset did not begin anew")
    # One that refuses its gear stands until it is reset; the others drive on.
    gym.step(actions, [11] + gears[1:])
    failed = gym.failed
    gym.reset(0)
    gym.step(actions, gears)
    if failed != [0] or gym.failed:
        raise SystemExit("one car that refuses is not what stops, or it does not begin again")
    gym.close()
    steps = cars * decisions * gym.steps
    print(f"{cars} cars, {steps} steps of 1 ms in {took_s:.2f} s: "
          f"{steps / took_s:.0f} steps per second, {steps / took_s / 1000:.0f} times real time")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        raise SystemExit(__doc__)
    main(sys.argv[1], sys.argv[2])
