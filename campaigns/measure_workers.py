"""How much sooner a campaign is done with two workers than with one.

  python3 campaigns/measure_workers.py FOLDER --tools DIR [--rounds N] CAMPAIGN.yaml
  python3 campaigns/measure_workers.py FOLDER --tools DIR [--rounds N] MESH...

Runs the campaign (of meshes: a road with its report from each) with --jobs 1 and --jobs 2 in turns, in new folders
below FOLDER, and prints a line for each run. The clock says something only where other programs leave the cores
alone, so what these took is measured as well (/proc/stat) and printed. The last lines: the ratio of the clocks, pair
by pair; the ratio of the processor time, which must be near 1; and the limit, that is the ratio on idle cores from the
processor time of each job. What the campaign takes where nothing is left to do (the engine's start, the page) is then
done alone; what remains is the start of the jobs, and theirs in equal parts."""
import argparse
import glob
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import time

from plan import write_whole
from simulate_queue import jobs_of, simulate

CAMPAIGN = os.path.join(os.path.dirname(os.path.realpath(__file__)), "../scripts/campaign")
QUIET_CORES = 0.1  # others may take so much for a run to count as undisturbed
TICKS_PER_S = os.sysconf("SC_CLK_TCK")


def write_campaign(path, meshes):
    tracks = {os.path.splitext(os.path.basename(mesh))[0]: {"mesh": os.path.abspath(mesh)} for mesh in meshes}
    if len(tracks) != len(meshes):
        sys.exit("measure_workers: two meshes have one name")
    # JSON is YAML.
    write_whole(path, json.dumps({"name": "tracks", "tracks": tracks}) + "\n")


def busy_s():
    """Processor time that anybody took since the machine's start; what a host took away counts."""
    with open("/proc/stat", encoding="ascii") as file:
        user, nice, system, _idle, _wait, irq, softirq, steal = map(int, file.readline().split()[1:9])
    return (user + nice + system + irq + softirq + steal) / TICKS_PER_S


def own_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def at_work_s(folder):
    """Seconds that jobs took from begin (.locks) to end (their state)."""
    total = 0.0
    for lock in glob.glob(os.path.join(folder, ".locks/*/*")):
        with open(lock, encoding="ascii") as file:
            begun = float(file.read().split()[0])
        total += os.path.getmtime(os.path.join(folder, "state", *lock.split(os.sep)[-2:]) + ".json") - begun
    return total


def campaign_cpu_s(campaign, folder, tools, workers):
    before = own_s()
    ended = subprocess.run([CAMPAIGN, campaign, folder, "--tools", tools, "--jobs", str(workers)],
                           stdout=subprocess.DEVNULL)
    if ended.returncode not in (0, 3):
        sys.exit(f"measure_workers: {campaign}: the campaign ended with {ended.returncode}")
    # What failed would be run again where nothing should be left to do; a road that is not usable is not.
    for path in glob.glob(os.path.join(folder, "state/*/*.json")):
        with open(path, encoding="utf-8") as file:
            if json.load(file).get("exit_code", 0) not in (0, 3):
                sys.exit(f"measure_workers: {path}: the job failed; leave it out")
    return own_s() - before


def ideal_s(jobs, cpu_s, alone_s, workers):
    """Seconds on idle cores: what is done alone, and the jobs with their starts."""
    start_s = max(0.0, cpu_s - alone_s - sum(job[0] for job in jobs)) / len(jobs)
    return alone_s + simulate([(job[0] + start_s, 0.0, job[2]) for job in jobs], workers, 1e9, 1e9)[0]


def run(campaign, folder, tools, workers):
    shutil.rmtree(folder, ignore_errors=True)
    busy, begin = busy_s(), time.monotonic()
    cpu_s = campaign_cpu_s(campaign, folder, tools, workers)
    seconds = time.monotonic() - begin
    others = max(0.0, (busy_s() - busy - cpu_s) / seconds)
    jobs, work = jobs_of(folder), at_work_s(folder) / seconds
    jobs_cpu_s = sum(job[0] for job in jobs)
    alone_s = min(campaign_cpu_s(campaign, folder, tools, workers), cpu_s - jobs_cpu_s)
    print(f"{workers} workers: {seconds:7.2f} s by the clock, {cpu_s:7.2f} s of processor, of which jobs "
          f"{jobs_cpu_s:7.2f}, alone {alone_s:.2f}; {work:.2f} jobs at work; "
          f"others took {others:.2f} cores", flush=True)
    return {"seconds": seconds, "cpu_s": cpu_s, "others": others, "jobs": len(jobs),
            "ideal_s": ideal_s(jobs, cpu_s, alone_s, workers)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("source", nargs="+")
    parser.add_argument("--tools", required=True)
    parser.add_argument("--rounds", type=int, default=3)
    told = parser.parse_args()
    campaign = told.source[0]
    if not campaign.endswith((".yaml", ".yml")):
        campaign = os.path.join(told.folder, "campaign.yaml")
        write_campaign(campaign, told.source)
    pairs = []
    for number in range(max(1, told.rounds)):
        order = (1, 2) if number % 2 == 0 else (2, 1)
        ran = {workers: run(campaign, os.path.join(told.folder, "run"), told.tools, workers) for workers in order}
        pairs.append((ran[1], ran[2]))
    clocks = [one["seconds"] / two["seconds"] for one, two in pairs]
    quiet = [clock for clock, pair in zip(clocks, pairs) if max(r["others"] for r in pair) < QUIET_CORES]
    print(f"{pairs[0][0]['jobs']} jobs; the clock, one worker / two: {', '.join(f'{c:.2f}' for c in clocks)}; "
          + (f"median of the {len(quiet)} undisturbed {statistics.median(quiet):.2f}" if quiet
             else "none of them undisturbed"))
    processor = statistics.median(two["cpu_s"] / one["cpu_s"] for one, two in pairs)
    print(f"processor time, two workers / one: {processor:.3f}")
    print(f"limit on idle cores: {statistics.median(one['ideal_s'] / two['ideal_s'] for one, two in pairs):.2f}")


if __name__ == "__main__":
    main()
