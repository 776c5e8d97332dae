"""A campaign on a Slurm of one node while jobs and daemons are killed, against the same undisturbed.

  slurm_trial.py SOURCE TOOLS WORK JOBS KILLED

Runs JOBS laps twice: here, and through the profile slurm. There KILLED of them are killed by SIGKILL while
they run, and slurmd and slurmctld once each. Prints one line per claim that does not hold; exit code 1 then."""
import glob
import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time

source, tools, work = (os.path.abspath(path) for path in sys.argv[1:4])
count, wanted = int(sys.argv[4]), int(sys.argv[5])
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
    options: {{--rate-hz: 10, --laps: 1}}
""")


def campaign(folder, *options):
    return subprocess.run([os.path.join(source, "scripts/campaign"), os.path.join(work, "campaign.yaml"), folder,
                           "--tools", tools, *options], stdout=subprocess.DEVNULL).returncode


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


def near(log, daemons):
    """Whether a run began while a daemon was away, or so shortly before that the daemon may not have written it,
    or its end, down."""
    begun = os.path.getmtime(log)
    return any(died - 15 < begun < back for died, back in filter(None, daemons.values()))


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


def daemon(name):
    """Kills one of Slurm's daemons and starts it again, as an operator would: a controller that died between
    the begin of a job and writing that down begins it twice, and takes the node for broken."""
    died = time.time()
    with open(os.path.join(slurm, f"{name}.pid"), encoding="ascii") as file:
        killed = kill([int(file.read())])
    time.sleep(4)
    subprocess.run(node + [name, slurm], check=True)
    time.sleep(3)
    # Nodes say what they run: jobs whose end was not written down are let go now, not minutes later.
    subprocess.run(["scontrol", "reconfigure"], check=True)
    for _ in range(20):
        time.sleep(1)
        said = subprocess.run(["sinfo", "--noheader", "--format=%T %E"], capture_output=True, text=True).stdout
        if said.startswith("drain") and "Duplicate jobid" in said:
            subprocess.run(["scontrol", "update", f"NodeName={os.uname().nodename.split('.')[0]}", "State=RESUME"],
                           check=True)
            break
    return (died, time.time()) if killed else None


def disturb(folder, over, killed, daemons):
    """Kills a running job every now and then; half of them as a whole, of the others the tool alone."""
    generator = random.Random(26)
    while not over.is_set():
        time.sleep(generator.uniform(0.2, 1.5))
        jobs = [(job, process) for job, process in sorted(running(folder).items())
                if job.startswith("lap/") and job not in killed and below(process)]
        if jobs and len(killed) < wanted:
            job, process = generator.choice(jobs)
            victims = below(process)
            if len(killed) % 2:
                victims.append(process)
            if kill(victims):
                killed.append(job)
        for name, after in (("node", wanted // 4), ("controller", wanted // 2)):
            if len(killed) > after and name not in daemons:
                daemons[name] = daemon(name)


def differences(one, other):
    """What does not have the same bytes; costs, logs and Snakemake's own are left out."""
    found = []
    for folder, below_it, names in os.walk(one):
        below_it[:] = [name for name in below_it if name not in (".snakemake", "slurm")]
        for name in names:
            path = os.path.join(folder, name)
            twin = os.path.join(other, os.path.relpath(path, one))
            if name in ("timing.json", "plan.json", ".lock") or name.endswith(".cost.json"):
                continue
            if not os.path.exists(twin):
                found.append(f"{twin} is missing")
            else:
                with open(path, "rb") as a, open(twin, "rb") as b:
                    if a.read() != b.read():
                        found.append(f"{twin} differs")
    return found


def main():
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    write_campaign()
    quiet, disturbed = os.path.join(work, "quiet"), os.path.join(work, "disturbed")
    subprocess.run(node + ["start", slurm], check=True)
    os.environ["CI"] = "true"  # Snakemake then asks every second, not every ten
    os.environ["SLURM_CONF"] = os.path.join(slurm, "slurm.conf")
    wrong, killed, daemons, over = [], [], {}, threading.Event()
    killer = threading.Thread(target=disturb, args=(disturbed, over, killed, daemons))
    try:
        killer.start()
        begin = time.monotonic()
        if campaign(disturbed, "--profile", "slurm") != 0:
            wrong.append("the disturbed campaign is not done")
        seconds = time.monotonic() - begin
    finally:
        over.set()
        killer.join()
        subprocess.run(node + ["stop", slurm], check=True)
    if campaign(quiet) != 0:
        wrong.append("the undisturbed campaign is not done")
    wrong += differences(quiet, disturbed)
    runs = {}
    for log in glob.glob(os.path.join(disturbed, "slurm/*/*.log")):
        job = os.path.relpath(log, os.path.join(disturbed, "slurm")).rsplit(".", 2)[0]
        runs.setdefault(job, []).append(near(log, daemons))
    for job, times in sorted(runs.items()):
        # What was at work when a daemon died may be run once more: its end may not have been written down.
        least = 2 if job in killed else 1
        if not least <= len(times) <= least + (1 if any(times) else 0):
            wrong.append(f"{job} ran {len(times)} times, killed {job in killed}, a daemon away {times}")
    if len(runs) != count + 2 or len(killed) != wanted or len(daemons) != 2 or not all(daemons.values()):
        wrong.append(f"{len(runs)} jobs, {len(killed)} killed, {daemons}")
    twice = sum(len(times) > (2 if job in killed else 1) for job, times in runs.items())
    print("\n".join(wrong))
    print(f"{len(runs)} jobs in {seconds:.0f} s, {len(killed)} killed, slurmd and slurmctld once each, {twice} run once "
          f"more for a daemon's death: "
          f"{len(wrong)} claims do not hold")
    return 1 if wrong else 0


sys.exit(main())
