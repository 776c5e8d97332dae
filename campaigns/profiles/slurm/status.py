#!/usr/bin/env python3
"""Prints whether a job of Slurm is running, success or failed, as Snakemake asks."""
import re
import subprocess
import sys

WAITING = {"PENDING", "RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING", "SIGNALING",
           "STAGE_OUT", "STOPPED"}


def status(number):
    ran = subprocess.run(["scontrol", "--oneliner", "show", "job", number], capture_output=True, text=True)
    state = re.search(r"\bJobState=(\w+)", ran.stdout)
    if state:
        word = state[1]
        return "success" if word == "COMPLETED" else "running" if word in WAITING else "failed"
    # A controller that is away knows the job again when it is back. One that has forgotten it cannot say
    # how it ended; doing it again costs time and no correctness.
    return "failed" if "Invalid job id" in ran.stderr else "running"


print(status(sys.argv[1]))
