"""campaign.yaml to the jobs of a campaign. A job is one command of one tool, with one set of inputs and
one of outputs; plan.json, which this writes, is all that Snakefile, job.py and `kerbstone collect` know.

Paths of what jobs write are relative to the campaign's folder, where every job runs, so that the bytes do
not depend on where that folder lies. All others are absolute."""
import itertools
import json
import os
import re
import subprocess
import sys

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,99}")
OPTION = re.compile(r"--[a-z][a-z0-9-]*")
# What says where a result goes or how it is printed is the plan's own matter.
OWN_OPTIONS = {"--output", "--out", "--json", "--quiet", "--threads", "--name", "--help", "--version", "--tiles",
               "--step"}
# Of `lidar2mesh map`: what it writes, which is the business of `merge` where there are tiles.
MAP_OUTPUTS = {"--format", "--stl", "--pcd", "--doubles", "--no-report"}
MAP_STEPS = 4
# MB a job needs whatever its inputs, and MB per MB of input: guesses, but for roads, which were seen to take 910.
# What a job of the same folder took before stands in its cost.json and comes first.
MEMORY = {"mesh": (400, 0), "road": (1000, 60), "lap": (200, 3), "lap-page": (200, 3), "replay": (300, 5),
          "explain": (800, 20), "summary": (800, 20), "fleet": (1000, 0),
          "scan": (500, 3), "map": (800, 8), "split": (500, 8), "tile": (500, 8), "merge": (800, 8), "trials-make": (300, 0),
          "trials-run": (1500, 0), "trials-score": (200, 0)}
MOST_JOBS = 100000


class Refusal(Exception):
    """What campaign.yaml has wrong, in one line."""


def _read_yaml(path):
    import yaml  # here, because job.py, which imports this file, runs where it may be missing
    try:
        with open(path, encoding="utf-8") as file:
            text = file.read(4 << 20)
        # Anchors can make a few lines into gigabytes, and no campaign needs them.
        for token in yaml.scan(text):
            if isinstance(token, (yaml.AliasToken, yaml.AnchorToken)):
                raise Refusal(f"{path}:{token.start_mark.line + 1}: anchors (& and *) are not read")
        return yaml.safe_load(text)
    except OSError as error:
        raise Refusal(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise Refusal(f"{path}: no UTF-8 text") from None
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        raise Refusal(f"{path}: " + " ".join(str(error).split())) from None


class _Section:
    """A mapping of campaign.yaml that refuses keys nobody asked for."""

    def __init__(self, where, value, keys):
        if not isinstance(value, dict):
            raise Refusal(f"{where}: {_seen(value)} seen, keys wanted: {', '.join(keys)}")
        for key in value:
            if key not in keys:
                raise Refusal(f"{where}: no key {key!r} is known; {', '.join(keys)} are")
        self.where, self.value = where, value

    def get(self, key, kind, wanted, default=None):
        value = self.value.get(key, default)
        if value is None:
            return value
        if not isinstance(value, kind) or isinstance(value, bool) and kind is not bool:
            raise Refusal(f"{self.where}: {key}: {_seen(value)} seen, {wanted} wanted")
        return value

    def need(self, key, kind, wanted):
        value = self.get(key, kind, wanted)
        if value is None:
            raise Refusal(f"{self.where}: {key} is missing; {wanted} wanted")
        return value

    def count(self, key, default, most):
        value = self.get(key, int, "a number", default)
        if not 1 <= value <= most:
            raise Refusal(f"{self.where}: {key}: {value} seen, 1 to {most} wanted")
        return value

    def options(self):
        """Flags for the command: {"--u-step-m": 0.2, "--friction": true}."""
        words = []
        options = self.get("options", dict, "flags and their values") or {}
        for flag, value in options.items():
            if not isinstance(flag, str) or not OPTION.fullmatch(flag) or flag in OWN_OPTIONS:
                raise Refusal(f"{self.where}: options: {flag!r} seen, a flag of the command wanted, "
                              f"none of {', '.join(sorted(OWN_OPTIONS))}")
            values = value if isinstance(value, list) else [value]
            if value is True:
                words.append(flag)
            elif not values or any(isinstance(v, (bool, dict, list)) or v is None for v in values):
                raise Refusal(f"{self.where}: options: {flag}: {_seen(value)} seen, true, a number, a word "
                              "or a list of them wanted")
            else:
                # "=" keeps a value that begins with a dash a value.
                words += [f"{flag}={values[0]}", *map(str, values[1:])]
        return words


def _seen(value):
    return "nothing" if value is None else repr(value)[:60]


def _named(where, value):
    """The entries of a mapping from names, in the order of the file."""
    if value is None:
        return []
    if not isinstance(value, dict):
        raise Refusal(f"{where}: {_seen(value)} seen, names and what they are wanted")
    for name in value:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise Refusal(f"{where}: name {name!r} seen; letters, digits, '.', '_' and '-' wanted, the first "
                          "a letter or digit")
    return list(value.items())


class _Planner:
    def __init__(self, path):
        self.path, self.folder = path, os.path.dirname(os.path.abspath(path))
        self.jobs, self.roads, self.cars, self.recordings = {}, {}, {}, {}

    def file(self, where, value):
        """A file of the user's: absolute, and there."""
        if not isinstance(value, str) or not value:
            raise Refusal(f"{where}: {_seen(value)} seen, a file wanted")
        path = os.path.normpath(os.path.join(self.folder, value))
        if not os.path.exists(path):
            raise Refusal(f"{where}: {path}: no such file")
        return path

    def add(self, kind, subject, command, inputs=(), after=(), clears=None, page=None, outputs=None):
        job = f"{kind}/{subject}"
        self.jobs[job] = {
            "id": job, "kind": kind, "subject": subject, "command": command + ["--json"],
            "inputs": sorted(set(inputs)), "after": list(after), "clears": [job] if clears is None else clears,
            "outputs": [job] if outputs is None else outputs, "page": page or ""}
        if len(self.jobs) > MOST_JOBS:
            raise Refusal(f"{self.path}: more than {MOST_JOBS} jobs")
        return job

    def track(self, name, value, threads):
        where = f"{self.path}: tracks: {name}"
        track = _Section(where, value, ("circuit", "mesh", "recipe", "road", "scans", "options", "facet_m", "tiles"))
        sources = [key for key in ("circuit", "mesh", "recipe", "road", "scans") if key in track.value]
        if len(sources) != 1:
            raise Refusal(f"{where}: {' and '.join(sources) or 'nothing'} seen, one of circuit, mesh, recipe, "
                          "road, scans wanted")
        source = sources[0]
        if source == "scans":
            return self.scans(where, name, track, threads)
        if "tiles" in track.value:
            raise Refusal(f"{where}: tiles: they are of scans, not of a {source}")
        path, after = self.file(f"{where}: {source}", track.value[source]), []
        inputs = [path]
        if source == "road":
            self.roads[name] = (path, [])
            return None
        if source == "circuit":
            circuit = _read_yaml(path)
            drawn = circuit.get("name") if isinstance(circuit, dict) else None
            if not isinstance(drawn, str) or not NAME.fullmatch(drawn):
                raise Refusal(f"{path}: name: {_seen(drawn)} seen, a plain name wanted")
            facet = [f"--step-m={track.get('facet_m', (int, float), 'metres')}"] if "facet_m" in track.value else []
            after = [self.add("mesh", name, ["crgbuild", "synth", path, "-o", f"mesh/{name}", *facet], [path])]
            path, inputs = f"mesh/{name}/{drawn}.obj", []
        self.add("road", name, ["crgbuild", "build", path, "-o", f"road/{name}", f"--name={name}",
                                *track.options(), f"--threads={threads}"],
                 inputs, after, page=f"road/{name}/report.html")
        self.roads[name] = (f"road/{name}/{name}.crg", [f"road/{name}"])
        return None

    def scans(self, where, name, track, threads):
        """LiDAR: scans of a circuit, made here, or those of a folder with a trajectory and a base."""
        scans = _Section(f"{where}: scans", track.value["scans"],
                         ("circuit", "folder", "trajectory", "base", "options"))
        if "circuit" in scans.value:
            path = self.file(f"{where}: scans: circuit", scans.value["circuit"])
            folder, inputs = f"scan/{name}", []
            after = [self.add("scan", name, ["lidar2mesh", "synth", path, "-o", folder, *scans.options(),
                                             f"--threads={threads}"], [path])]
            trajectory, base = f"{folder}/trajectory.csv", f"{folder}/base.crg"
        else:
            folder = self.file(f"{where}: scans: folder", scans.need("folder", str, "a folder of clouds"))
            trajectory = self.file(f"{where}: scans: trajectory", scans.need("trajectory", str, "a CSV"))
            base = self.file(f"{where}: scans: base", scans.need("base", str, "a road or a mesh"))
            clouds = sorted(entry.path for entry in os.scandir(folder) if entry.is_file())
            inputs, after = clouds + [trajectory, base], []
        scanned = [folder, "--trajectory", trajectory, "--road", base]
        if "tiles" in track.value:
            self.tiles(name, track, scanned, threads, inputs, after)
        else:
            self.add("map", name, ["lidar2mesh", "map", *scanned, "-o", f"map/{name}", *track.options(),
                                   f"--threads={threads}"], inputs, after, page=f"map/{name}/report.html")
        self.roads[name] = (f"map/{name}/refined.crg", [f"map/{name}"])

    def tiles(self, name, track, scanned, threads, inputs, after):
        """The same map by stretches of the road: every step reads each tile by a job, and joins what they say."""
        count, folder = track.count("tiles", 1, 1000), f"split/{name}"
        outputs = [word for word in track.options() if word in MAP_OUTPUTS]
        cut = [word for word in track.options() if word not in MAP_OUTPUTS]
        split = self.add("split", name, ["lidar2mesh", "split", *scanned, f"--tiles={count}", "-o", folder, *cut],
                         inputs, after)
        # What a job needs grows with the road, which the user's files tell, if they are there already.
        road = [path for path in (scanned[2], scanned[4]) if os.path.isabs(path)]
        before = [split]
        for step in range(1, MAP_STEPS + 1):
            words = [folder, f"--step={step}"]
            read = []
            for tile in range(1, count + 1):
                file = f"{folder}/step-{step}.tile-{tile}"
                read.append(self.add("tile", f"{name}+{step}+{tile}",
                                     ["lidar2mesh", "map-tile", *words, f"--tile={tile}", f"--threads={threads}"],
                                     road, before, clears=[file], outputs=[file]))
            if step == MAP_STEPS:
                self.add("map", name, ["lidar2mesh", "merge", *words, "-o", f"map/{name}", *outputs,
                                       f"--threads={threads}"], road, read, page=f"map/{name}/report.html")
            else:
                file = f"{folder}/step-{step}.joined"
                before = [split, self.add("merge", f"{name}+{step}",
                                          ["lidar2mesh", "merge", *words, f"--threads={threads}"], road, read,
                                          clears=[file], outputs=[file])]

    def car(self, name, value):
        where = f"{self.path}: cars: {name}"
        car = _Section(where, value if isinstance(value, dict) else {"vehicle": value}, ("vehicle", "set"))
        path = self.file(f"{where}: vehicle", car.need("vehicle", str, "a vehicle.yaml"))
        # A vehicle.yaml names other files of its folder: a change of any of them is a change of the car.
        folder = os.path.dirname(path)
        files = sorted(entry.path for entry in os.scandir(folder) if entry.is_file())
        self.cars[name] = (path, files, [f"--set={word}" for word in self.settings(where, car)])

    @staticmethod
    def settings(where, section):
        words = []
        for key, value in (section.get("set", dict, "parameters and their values") or {}).items():
            if not isinstance(key, str) or isinstance(value, (bool, list, dict)) or value is None:
                raise Refusal(f"{where}: set: {key}: {_seen(value)} seen, a number or a word wanted")
            words.append(f"{key}={value}")
        return words

    def chosen(self, section, key, known):
        """The names of a list, or all that there are."""
        names = section.get(key, list, "a list of names")
        if names is None:
            return list(known)
        for name in names:
            if name not in known:
                raise Refusal(f"{section.where}: {key}: {_seen(name)} seen, one of {', '.join(known) or 'none'} "
                              "wanted")
        return list(dict.fromkeys(names))

    def recording(self, name, value):
        where = f"{self.path}: recordings: {name}"
        log = _Section(where, value, ("file", "driven_by", "options", "mapping", "track", "car"))
        if ("file" in log.value) == ("driven_by" in log.value):
            raise Refusal(f"{where}: one of file and driven_by wanted")
        track, car = log.need("track", str, "a name of tracks"), log.need("car", str, "a name of cars")
        driver = log.value.get("driven_by", car)
        for key, word, known in (("track", track, self.roads), ("car", car, self.cars),
                                 ("driven_by", driver, self.cars)):
            if not isinstance(word, str) or word not in known:
                raise Refusal(f"{where}: {key}: {word!r} seen, one of {', '.join(known) or 'none'} wanted")
        mapping = self.file(f"{where}: mapping", log.value["mapping"]) if "mapping" in log.value else None
        if "file" in log.value:
            path, after = self.file(f"{where}: file", log.value["file"]), []
        else:  # no recording at all: laps of a simulated car, for trying things out
            path, after = f"lap/{name}/lap.csv", [self.drive(name, track, driver, [], log.options())]
        self.recordings[name] = (path, after, mapping, track, car)

    def drive(self, subject, track, car, words, options):
        road, after = self.roads[track]
        vehicle, files, settings = self.cars[car]
        return self.add("lap", subject, ["crgdrive", "lap", "--car", vehicle, "--road", road, *settings, *words,
                                         "-o", f"lap/{subject}/lap.csv", *options],
                        files + ([] if after else [road]), after)

    def laps(self, where, value, _threads):
        """Each car on each track by the built-in driver, and a page of each."""
        section = _Section(where, value or {}, ("tracks", "cars", "options"))
        for track in self.chosen(section, "tracks", self.roads):
            for car in self.chosen(section, "cars", self.cars):
                subject = f"{track}+{car}"
                lap = self.drive(subject, track, car, [], section.options())
                road, after = self.roads[track]
                page = f"lap-page/{subject}/page.html"
                self.add("lap-page", subject, ["crgdrive", "report", f"lap/{subject}/lap.csv", "--road", road,
                                               "-o", page],
                         [] if after else [road], [lap, *after], page=page)

    def replays(self, where, value, _threads):
        """Each recording's commands through its car, put back every so many seconds."""
        section = _Section(where, value or {}, ("recordings", "windows_s", "options"))
        windows = section.get("windows_s", list, "a list of seconds, 0: never put back", [0.6, 2, 8, 0])
        for name in self.chosen(section, "recordings", self.recordings):
            log, driven, mapping, track, car = self.recordings[name]
            for window in windows:
                if isinstance(window, bool) or not isinstance(window, (int, float)) or not 0 <= window <= 1e5:
                    raise Refusal(f"{where}: windows_s: {_seen(window)} seen, seconds wanted")
                subject = f"{name}+{f'{window}s' if window else 'whole'}"
                road, after = self.roads[track]
                vehicle, files, settings = self.cars[car]
                mapped = ["--mapping", mapping] if mapping else []
                self.add("replay", subject,
                         ["crgdrive", "replay", "--car", vehicle, "--road", road, *settings, "--log", log,
                          *mapped, f"--window-s={window}", "-o", f"replay/{subject}", *section.options()],
                         files + ([] if driven else [log]) + ([mapping] if mapping else []) + ([] if after else [road]),
                         driven + after)

    def explanations(self, where, value, threads):
        """crgexplain over the recordings of each car on each track."""
        section = _Section(where, value or {}, ("recordings", "options"))
        groups = {}
        for name in self.chosen(section, "recordings", self.recordings):
            log, driven, mapping, track, car = self.recordings[name]
            groups.setdefault((track, car, mapping), []).append((log, driven))
        for number, ((track, car, mapping), entries) in enumerate(groups.items()):
            subject = f"{track}+{car}"
            if f"explain/{subject}" in self.jobs:
                subject += f"+{number}"  # another mapping
            if self.cars[car][2]:
                raise Refusal(f"{where}: car {car} has 'set'; crgexplain reads vehicle.yaml alone: "
                              "write these settings there")
            logs, drives = [log for log, _ in entries], [job for _, driven in entries for job in driven]
            road, after = self.roads[track]
            vehicle, files, _ = self.cars[car]
            self.add("explain", subject,
                     ["crgexplain", "run", "--road", road, "--car", vehicle, "--log", *logs,
                      *(["--mapping", mapping] if mapping else []), "-o", f"explain/{subject}", *section.options(),
                      f"--threads={threads}"],
                     files + [log for log, driven in entries if not driven] + ([mapping] if mapping else [])
                     + ([] if after else [road]), drives + after,
                     page=f"explain/{subject}/report.html")

    def fleets(self, where, value, threads):
        """A summary of each recording, and what all of a track say together: road, cars, sensors."""
        section = _Section(where, value or {}, ("recordings", "options"))
        fleets = {}
        for name in self.chosen(section, "recordings", self.recordings):
            log, driven, mapping, track, car = self.recordings[name]
            if self.cars[car][2]:
                raise Refusal(f"{where}: car {car} has 'set'; crgexplain reads vehicle.yaml alone: "
                              "write these settings there")
            road, after = self.roads[track]
            vehicle, files, _ = self.cars[car]
            file = f"summary/{name}/drive.summary"
            job = self.add("summary", name,
                           ["crgexplain", "summary", log, "--road", road, "--car", vehicle,
                            *(["--mapping", mapping] if mapping else []), "-o", file, *section.options(),
                            f"--threads={threads}"],
                           files + ([] if driven else [log]) + ([mapping] if mapping else []) + ([] if after else [road]),
                           driven + after)
            fleets.setdefault(track, []).append((file, job))
        for track, summaries in fleets.items():
            self.add("fleet", track,
                     ["crgexplain", "fleet", *(file for file, _ in summaries), "-o", f"fleet/{track}",
                      f"--threads={threads}"],
                     after=[job for _, job in summaries], page=f"fleet/{track}/report.html")

    def trials(self, where, value, threads):
        """Sets of blind trials: made, run, scored."""
        section = _Section(where, value or {}, ("program", "generator", "sets", "count", "first_seed", "waves"))
        program_path = self.file(f"{where}: program", section.need("program", str, "the program blind_trials"))
        generator = self.file(f"{where}: generator", section.need("generator", str, "the program make_trials"))
        sets, count = section.count("sets", 1, 10000), section.count("count", 10, 9999)
        first = section.count("first_seed", 1, 10**9)
        waves = ["--waves"] if section.get("waves", bool, "true or false", False) else []
        for seed in range(first, first + sets):
            name, folder = f"seed{seed}", f"trials/seed{seed}"
            trials = [f"{folder}/{i:04d}" for i in range(count)]
            made = self.add("trials-make", name,
                            [program_path, "make", folder, "--generator", generator, f"--count={count}",
                             f"--seed={seed}", *waves], [program_path, generator], clears=[folder],
                            outputs=[f"{folder}/SHA256SUMS", f"{folder}/sealed",
                                     *(f"{trial}/{file}" for trial in trials for file in ("run.csv", "track.crg",
                                                                                          "vehicle.yaml"))])
            found = [f"{trial}/findings.json" for trial in trials]
            ran = self.add("trials-run", name, [program_path, "run", folder, f"--threads={threads}"],
                           after=[made], clears=found, outputs=found)
            self.add("trials-score", name, [program_path, "score", folder], after=[made, ran], clears=[],
                     outputs=[])

    def sweeps(self, where, value, _threads):
        """Every combination of values of parameters, each a lap."""
        section = _Section(where, value or {}, ("tracks", "cars", "parameters", "options"))
        parameters = section.need("parameters", dict, "parameters and lists of values")
        for key, values in parameters.items():
            if not isinstance(key, str) or not isinstance(values, list) or not values or any(
                    isinstance(v, bool) or not isinstance(v, (int, float)) for v in values):
                raise Refusal(f"{where}: parameters: {key}: {_seen(values)} seen, a list of numbers wanted")
        for track in self.chosen(section, "tracks", self.roads):
            for car in self.chosen(section, "cars", self.cars):
                for values in itertools.product(*parameters.values()):
                    words = [f"{key}={value}" for key, value in zip(parameters, values)]
                    self.drive("+".join([track, car, *words]), track, car, [f"--set={word}" for word in words],
                               section.options())


def read(path):
    """The plan of a campaign.yaml. Raises Refusal."""
    top = _Section(path, _read_yaml(path), ("name", "threads", "tracks", "cars", "recordings", "analyses"))
    name = top.need("name", str, "a name")
    threads = top.count("threads", 1, 1024)
    planner = _Planner(path)
    for track, value in _named(f"{path}: tracks", top.value.get("tracks")):
        planner.track(track, value, threads)
    for car, value in _named(f"{path}: cars", top.value.get("cars")):
        planner.car(car, value)
    for log, value in _named(f"{path}: recordings", top.value.get("recordings")):
        planner.recording(log, value)
    known = {"laps": planner.laps, "replays": planner.replays, "explanations": planner.explanations, "fleets": planner.fleets,
             "trials": planner.trials, "sweeps": planner.sweeps}
    analyses = _Section(f"{path}: analyses", top.value.get("analyses") or {}, tuple(known))
    for analysis, value in analyses.value.items():
        known[analysis](f"{path}: analyses: {analysis}", value, threads)
    if not planner.jobs:
        raise Refusal(f"{path}: there is nothing to do; name tracks, or analyses")
    return {"schema": 1, "name": name, "threads": threads, "jobs": list(planner.jobs.values())}


def program(name):
    """KERBSTONE_TOOLS is a folder of programs or a build's folder of tools; without: PATH."""
    tools = os.environ.get("KERBSTONE_TOOLS")
    for path in ((os.path.join(tools, name, name), os.path.join(tools, name)) if tools else ()):
        if os.path.isfile(path):
            return path
    return name


def _versions(plan):
    """Of each tool that a plan names: another version is a reason to run its jobs again."""
    versions = {}
    for name in sorted({job["command"][0] for job in plan["jobs"]}):
        try:
            ran = subprocess.run([program(name), "--version"], capture_output=True, text=True, check=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise Refusal(f"{name} cannot be run: {error}; build the tools or name their folder "
                          "(--tools)") from None
        versions[name] = ran.stdout.strip()
    return versions


def needs(job, folder):
    """What a scheduler is told, MB and minutes: more than the job took before, else what its kind takes by
    the size of its inputs, and a day."""
    try:
        with open(os.path.join(folder, "state", job["id"] + ".cost.json"), encoding="utf-8") as file:
            cost = json.load(file)
        return {"mem_mb": int(1.5 * float(cost["peak_mb"])) + 50, "minutes": int(cost["seconds"] / 12) + 10}
    except (OSError, ValueError, KeyError, TypeError):
        base, share = MEMORY[job["kind"]]
        inputs_mb = sum(os.path.getsize(path) for path in job["inputs"]) / 1e6
        return {"mem_mb": int(base + share * inputs_mb), "minutes": 1440}


def write_whole(path, text):
    """The old file or the new one, whenever this is killed."""
    os.makedirs(os.path.dirname(path), exist_ok=True)
    part = f"{path}.{os.getpid()}.part"
    with open(part, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def _changed(folder, state, since):
    inputs = state.get("said", {}).get("inputs")
    paths = [entry["path"] for entry in inputs if isinstance(entry, dict) and isinstance(entry.get("path"), str)
             ] if isinstance(inputs, list) else []
    return any(os.path.getmtime(os.path.join(folder, path)) > since for path in paths)


def _forget(folder, plan):
    """Removes the state of jobs that shall be tried again: those that failed or waited for one that did,
    those whose outputs are gone, and those of which a file has changed that only the tool knew to read (a
    recipe's mesh, a mesh's materials)."""
    for job in plan["jobs"]:
        path = os.path.join(folder, "state", job["id"] + ".json")
        try:
            with open(path, encoding="utf-8") as file:
                state = json.load(file)
            good = state["exit_code"] in (0, 3) and all(
                os.path.getsize(os.path.join(folder, output["path"])) == output["bytes"]
                for output in state["outputs"]) and not _changed(folder, state, os.path.getmtime(path))
        except FileNotFoundError:
            good = not os.path.exists(path)
        except (OSError, ValueError, KeyError, TypeError):
            good = False
        if not good:
            os.remove(path)


def main(arguments):
    if len(arguments) != 2:
        print("campaign: plan.py CAMPAIGN.yaml FOLDER wanted", file=sys.stderr)
        return 2
    try:
        plan = read(arguments[0])
        folder = os.path.abspath(arguments[1])
        plan["versions"] = _versions(plan)
        for job in plan["jobs"]:
            job.update(needs(job, folder))
        write_whole(os.path.join(folder, "plan.json"), json.dumps(plan, indent=1) + "\n")
        _forget(folder, plan)
    except Refusal as refusal:
        print(f"campaign: {refusal}", file=sys.stderr)
        return 1
    except OSError as error:
        print(f"campaign: {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    print(f"campaign: {plan['name']}: {len(plan['jobs'])} jobs in {arguments[1]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
