"""A campaign on a Slurm of one node while jobs and daemons are killed, against the same undisturbed.

  slurm_trial.py SOURCE TOOLS WORK JOBS KILLED [SEED]

Runs JOBS laps twice: through the profile slurm, and here. Of the first, KILLED jobs are killed by SIGKILL while
they run, and slurmd and slurmctld once each while jobs run. Which jobs, and when, is drawn from SEED and printed.
Then all files of both must have the same bytes, and job.py's own record (.locks) must say that each killed job ran
twice and every other once. Prints one line per claim that does not hold; exit code 1 then."""
import glob
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time

source, tools, work = (os.path.abspath(path) for path in sys.argv[1:4])
count, wanted = int(sys.argv[4]), int(sys.argv[5])
seed = int(sys.argv[6]) if len(sys.argv) > 6 else 26
slurm = os.path.join(work, "slurm")
node = [os.path.join(source, "tests/campaign/one_node_slurm")]


def write_campaign():
    with open(os.path.join(work, "campaign.yaml"), "w", encoding="utf-8") as file:
        file.write(f"""name: disturbed
tracks:
  ring: {{circuit: {source}/tracks/kerbstone-ring/circuit.yaml, facet_m: 5, options: {{--u-step-m: 0.5, --v-step-m: 0.5}}}}
cars:
  av21: {source}/vehicles/av21/vehicle.yaml
analyses:
  sweeps:
    parameters: {{chassis.mass_kg: {[700 + k for k in range(count)]}}}
    options: {{--rate-hz: 10, --laps: {max(1, 80 // count)}}}
""")


def campaign(folder, programs, *options):
    return subprocess.run([os.path.join(source, "scripts/campaign"), os.path.join(work, "campaign.yaml"), folder,
                           "--tools", programs, *options], stdout=subprocess.DEVNULL).returncode


def running(folder):
    """Process and job of every job.py that works in the folder."""
    found = {}
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            with open(path, "rb") as file:
                words = file.read().decode("utf-8", "replace").split("\0")
            if len(words) > 3 and words[1].endswith("/job.py") and os.readlink(
                    os.path.join(os.path.dirname(path), "cwd")) == folder:
                found[words[3]] = int(path.split("/")[2])
        except OSError:
            pass  # it has ended
    return found


def left_behind():
    """Slurm's processes that still name the trial's folder."""
    found = []
    for path in glob.glob("/proc/[0-9]*/cmdline"):
        try:
            with open(path, "rb") as file:
                words = file.read().decode("utf-8", "replace").split("\0")
        except OSError:
            continue
        if re.search("(slurm|munge)", os.path.basename(words[0])) and any(slurm in word for word in words[1:]):
            found.append(" ".join(words))
    return found


def below(process):
    try:
        with open(f"/proc/{process}/task/{process}/children", encoding="ascii") as file:
            return [int(word) for word in file.read().split()]
    except OSError:
        return []


def kill(processes):
    """By SIGKILL; false where one of them had ended: they are stopped first, so that none ends meanwhile."""
    try:
        for process in processes:
            os.kill(process, signal.SIGSTOP)
        time.sleep(0.02)
        alive = True
        for process in processes:
            with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
                alive = alive and file.read().rsplit(")", 1)[1].split()[0] in ("T", "t")
        for process in processes:
            os.kill(process, signal.SIGKILL if alive else signal.SIGCONT)
        return alive
    except (ProcessLookupError, FileNotFoundError):
        return False


def resume_node():
    """As an operator would: a controller that died between the begin of a job and writing that down begins it
    twice, and takes the node for broken."""
    said = subprocess.run(["sinfo", "--noheader", "--format=%T %E"], capture_output=True, text=True).stdout
    if said.startswith("drain") and "Duplicate jobid" in said:
        subprocess.run(["scontrol", "update", f"NodeName={os.uname().nodename.split('.')[0]}", "State=RESUME"],
                       check=True)


def kill_daemon(name):
    """Kills one of Slurm's daemons and starts it again; (when it died, when it was back), or None where it had
    ended by itself."""
    with open(os.path.join(slurm, f"{name}.pid"), encoding="ascii") as file:
        died, killed = time.time(), kill([int(file.read())])
    time.sleep(4)
    subprocess.run(node + [name, slurm], check=True)
    return (died, time.time()) if killed else None


def done(folder, job):
    return os.path.exists(os.path.join(folder, "state", job + ".json"))


class Disturber(threading.Thread):
    """Kills drawn jobs, half of them with job.py and half the tool alone, and both daemons; no job while a daemon
    is away, and no daemon just after a job or while a killed job runs again, so that what each death costs can be
    told apart."""

    def __init__(self, folder, laps):
        super().__init__()
        self.folder, self.over = folder, threading.Event()
        self.random = random.Random(seed)
        self.laps = laps
        self.drawn = self.random.sample(laps, len(laps))  # the first are killed; the next where one was too quick
        self.killed, self.daemons, self.last_kill = [], {}, 0.0
        self.ask_at = []  # when nodes shall say what they run
        self.due = {"node": int(self.random.uniform(0.2, 0.4) * len(laps)),
                    "controller": int(self.random.uniform(0.5, 0.7) * len(laps))}

    def victims(self):
        """The next jobs of the drawn order that can still be killed, as many as are wanted."""
        left = [job for job in self.drawn if job not in self.killed and not done(self.folder, job)]
        return left[:wanted - len(self.killed)]

    def kill_job(self, job):
        time.sleep(self.random.uniform(0, 0.3))
        process = running(self.folder).get(job)
        tool = below(process) if process else []
        if tool and kill(tool + [process] if len(self.killed) % 2 else tool):
            self.killed.append(job)
            self.last_kill = time.monotonic()

    def run(self):
        looked = time.monotonic()
        while not self.over.is_set():
            time.sleep(0.02)
            at_work = running(self.folder)
            ended = sum(done(self.folder, job) for job in self.laps)
            due = [name for name, after in self.due.items() if name not in self.daemons and ended >= after]
            if due and at_work and time.monotonic() - self.last_kill > 3 and not set(at_work) & set(self.killed):
                self.daemons[due[0]] = kill_daemon(due[0])
                # Jobs whose end was not written down are let go then, not minutes later: the controller believes
                # a node that does not know a job no sooner than 10 s after its start (BatchStartTimeout).
                self.ask_at = [time.monotonic() + wait for wait in (1, 13, 30)]
            elif not due:
                for job in sorted(set(self.victims()) & set(at_work)):
                    self.kill_job(job)
            if time.monotonic() - looked > 1:
                resume_node()
                looked = time.monotonic()
            if self.ask_at and looked > self.ask_at[0]:
                self.ask_at.pop(0)
                subprocess.run(["scontrol", "reconfigure"], check=True)

    def end(self):
        self.over.set()
        self.join()


def runs_of(folder, job):
    """When each run of a job began, by job.py's record."""
    try:
        with open(os.path.join(folder, ".locks", job), encoding="ascii") as file:
            return [float(line.split()[0]) for line in file]
    except FileNotFoundError:
        return []


def miscounted(folder, jobs, disturber):
    """Jobs that did not run as often as they should, and those that ran once more for a daemon's death: what
    began while a daemon was away, or so shortly before that the controller may not have written its begin or end
    down, may run once more where nobody killed it."""
    wrong, more = [], []
    for job in jobs:
        runs, least = runs_of(folder, job), 2 if job in disturber.killed else 1
        near = any(died - 15 < begun < back for died, back in filter(None, disturber.daemons.values())
                   for begun in runs)
        if len(runs) == 2 and least == 1 and near:
            more.append(job)
        elif len(runs) != least:
            wrong.append(f"{job} ran {len(runs)} times, {least} wanted: begun at {runs}, daemons {disturber.daemons}")
    return wrong, more


def files_of(folder):
    """Below a campaign's folder; costs, logs and what the engine keeps for itself are left out."""
    for place, below_it, names in os.walk(folder):
        below_it[:] = [name for name in below_it if name not in (".snakemake", ".locks", ".ended", "slurm")]
        for name in names:
            if name not in ("timing.json", "plan.json", ".lock") and not name.endswith(".cost.json"):
                yield os.path.relpath(os.path.join(place, name), folder)


def differences(one, other):
    """How many files were compared, and those that do not have the same bytes in both, or are in one alone."""
    here, there = set(files_of(one)), set(files_of(other))
    found = [f"{path} is in one of both alone" for path in sorted(here ^ there)]
    for path in sorted(here & there):
        with open(os.path.join(one, path), "rb") as a, open(os.path.join(other, path), "rb") as b:
            if a.read() != b.read():
                found.append(f"{path} differs")
    return len(here & there), found


def main():
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    own_tools = os.path.join(work, "tools")  # whatever is built meanwhile
    os.makedirs(own_tools)
    for name in ("crgbuild", "crgdrive", "kerbstone"):
        shutil.copy(os.path.join(tools, name, name), own_tools)
    write_campaign()
    quiet, disturbed = os.path.join(work, "quiet"), os.path.join(work, "disturbed")
    subprocess.run(node + ["start", slurm], check=True)
    os.environ["CI"] = "true"  # Snakemake then asks every second, not every ten
    os.environ["SLURM_CONF"] = os.path.join(slurm, "slurm.conf")
    wrong = []
    laps = [f"lap/ring+av21+chassis.mass_kg={700 + k}" for k in range(count)]
    disturber = Disturber(disturbed, laps)
    print(f"seed {seed}: slurmd dies after {disturber.due['node']} laps, slurmctld after "
          f"{disturber.due['controller']}; first drawn: {' '.join(job[-3:] for job in disturber.drawn[:wanted])}")
    try:
        disturber.start()
        begin = time.monotonic()
        if campaign(disturbed, own_tools, "--profile", "slurm") != 0:
            wrong.append("the disturbed campaign is not done")
        seconds = time.monotonic() - begin
    finally:
        disturber.end()
        subprocess.run(node + ["stop", slurm], check=True)
    wrong += [f"left behind: {process}" for process in left_behind()]
    if campaign(quiet, own_tools) != 0:
        wrong.append("the undisturbed campaign is not done")
    compared, different = differences(quiet, disturbed)
    counts, more = miscounted(disturbed, ["mesh/ring", "road/ring", *laps], disturber)
    wrong += different + counts
    if compared < 2 * count:  # of every lap the drive and how it ended
        wrong.append(f"only {compared} files to compare")
    if len(disturber.killed) != wanted or sorted(filter(disturber.daemons.get, disturber.daemons)) != ["controller", "node"]:
        wrong.append(f"{len(disturber.killed)} of {wanted} killed, daemons {disturber.daemons}")
    print("killed:", " ".join(job[-3:] for job in disturber.killed))
    print("\n".join(wrong))
    print(f"{count + 2} jobs in {seconds:.0f} s, {len(disturber.killed)} killed, {len(disturber.daemons)} daemons; "
          f"{compared} files compared, {len(different)} differ; run once more for a daemon's death: {len(more)}; "
          f"{len(wrong)} claims do not hold")
    return 1 if wrong else 0


sys.exit(main())
