"""How long a campaign would take on 1 to 10,000 workers, from what its jobs cost here.

  python3 campaigns/simulate_queue.py FOLDER [--copies N] [--submit-per-s R] [--disk-mb-per-s B]

FOLDER is that of a finished campaign. Its jobs are taken N times, as if there were N such campaigns in one.
A worker runs one job at a time for the job's CPU time. Jobs are submitted one after another, R a second, once
what they need is done; what they write goes through one shared disk of B MB/s, first come, first served, while
the worker waits. Nothing fails and workers are alike: what comes out is a lower bound."""
import argparse
import collections
import heapq
import json
import os

WORKERS = (1, 2, 10, 100, 1000, 10000)


def jobs_of(folder):
    """(CPU s, MB written, numbers of the jobs that it needs) of each job."""
    with open(os.path.join(folder, "plan.json"), encoding="utf-8") as file:
        plan = json.load(file)["jobs"]
    number = {job["id"]: k for k, job in enumerate(plan)}
    jobs = []
    for job in plan:
        with open(os.path.join(folder, "state", job["id"] + ".cost.json"), encoding="utf-8") as file:
            cost = json.load(file)
        jobs.append((cost["cpu_s"], cost["output_mb"], [number[other] for other in job["after"]]))
    return jobs


def copied(jobs, copies):
    return [(cpu_s, output_mb, [k * len(jobs) + other for other in after])
            for k in range(copies) for cpu_s, output_mb, after in jobs]


def simulate(jobs, workers, submit_per_s, disk_mb_per_s):
    """Seconds until the last job has ended; and how much of that workers computed, submitting and the disk took."""
    missing = [len(after) for _, _, after in jobs]
    needed_by = [[] for _ in jobs]
    for k, (_, _, after) in enumerate(jobs):
        for other in after:
            needed_by[other].append(k)
    events, waiting, idle = [], collections.deque(), workers
    submitter = disk = now = 0.0

    def submit(k, ready):
        nonlocal submitter
        submitter = max(submitter, ready) + 1.0 / submit_per_s
        heapq.heappush(events, (submitter, k, "submitted"))

    for k, count in enumerate(missing):
        if count == 0:
            submit(k, 0.0)
    while events:
        now, k, what = heapq.heappop(events)
        if what == "submitted":
            waiting.append(k)
        elif what == "computed":
            disk = max(disk, now) + jobs[k][1] / disk_mb_per_s
            heapq.heappush(events, (disk, k, "written"))
        else:
            idle += 1
            for other in needed_by[k]:
                missing[other] -= 1
                if missing[other] == 0:
                    submit(other, now)
        while idle and waiting:
            idle -= 1
            begun = waiting.popleft()
            heapq.heappush(events, (now + jobs[begun][0], begun, "computed"))
    computing = sum(cpu_s for cpu_s, _, _ in jobs) / workers
    writing = sum(output_mb for _, output_mb, _ in jobs) / disk_mb_per_s
    return now, computing / now, len(jobs) / submit_per_s / now, writing / now


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder")
    parser.add_argument("--copies", type=int, default=1)
    parser.add_argument("--submit-per-s", type=float, default=5.0)
    parser.add_argument("--disk-mb-per-s", type=float, default=1000.0)
    told = parser.parse_args()
    jobs = copied(jobs_of(told.folder), told.copies)
    print(f"{len(jobs)} jobs, {sum(job[0] for job in jobs) / 3600:.2f} CPU hours, "
          f"{sum(job[1] for job in jobs) / 1000:.1f} GB")
    print("workers  hours     computing  submitting  disk")
    for workers in WORKERS:
        seconds, computing, submitting, disk = simulate(jobs, workers, told.submit_per_s, told.disk_mb_per_s)
        print(f"{workers:7}  {seconds / 3600:8.3f}  {computing:9.1%}  {submitting:10.1%}  {disk:5.1%}")


if __name__ == "__main__":
    main()
