#!/usr/bin/env python3
"""Submits one job of a campaign by sbatch and prints its name, by which it is asked for and cancelled: a number
may be given twice, where a controller died before it had written down whom it had given it to. What runs on the node is job.py itself:
the script that Snakemake made would start Snakemake there again, a second for every job."""
import json
import os
import shlex
import subprocess
import sys
import time
import uuid

CAMPAIGNS = os.path.normpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
PATIENCE_S = 1800  # how long a controller may be away


def submitted(name):
    """Whether a controller took the job of that name and its answer was lost."""
    ran = subprocess.run(["squeue", "--noheader", "--states=all", "--format=%i", f"--name={name}"],
                         capture_output=True, text=True)
    return ran.returncode == 0 and bool(ran.stdout.strip())


def properties_of(script):
    """What Snakemake says of the job, a comment of its script."""
    mark = "# properties = "
    with open(script, encoding="utf-8") as file:
        return json.loads(next(line for line in file if line.startswith(mark))[len(mark):])


def main(script):
    properties = properties_of(script)
    job, resources = properties["wildcards"]["job"], properties["resources"]
    log = os.path.join("slurm", job)
    os.makedirs(os.path.dirname(log), exist_ok=True)
    name = f"kerbstone-{uuid.uuid4().hex}"
    command = ["sbatch", "--no-requeue", f"--job-name={name}", f"--comment={job}",
               f"--cpus-per-task={properties['threads']}", f"--mem={resources['mem_mb']}M",
               f"--time={resources['minutes']}", f"--output={log}.%j.log",
               "--wrap", f"exec python3 {shlex.quote(CAMPAIGNS)}/job.py . {shlex.quote(job)} {name}"]
    until = time.monotonic() + PATIENCE_S
    while True:
        ran = subprocess.run(command, capture_output=True, text=True)
        done = ran.returncode == 0
        if not done and "contact slurm controller" not in ran.stderr and "timed out" not in ran.stderr:
            print(ran.stderr.strip(), file=sys.stderr)
            return 1
        while not done and subprocess.run(["scontrol", "ping"], capture_output=True).returncode != 0:
            if time.monotonic() > until:
                print("campaign: the controller of Slurm does not answer", file=sys.stderr)
                return 1
            time.sleep(2)
        if done or submitted(name):
            print(name)
            return 0


sys.exit(main(sys.argv[-1]))
