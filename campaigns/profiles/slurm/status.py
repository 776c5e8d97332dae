#!/usr/bin/env python3
"""Prints whether a job of Slurm is running, success or failed, as Snakemake asks."""
import os
import subprocess
import sys

WAITING = {"PENDING", "RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED", "REQUEUED", "RESIZING", "SIGNALING",
           "STAGE_OUT", "STOPPED"}


def status(name):
    if os.path.exists(os.path.join(".ended", name)):
        return "success"  # job.py says so, whatever a controller that died has forgotten
    ran = subprocess.run(["squeue", "--noheader", "--states=all", "--format=%T", f"--name={name}"],
                         capture_output=True, text=True)
    if ran.returncode != 0:
        return "running"  # as far as anybody knows: the controller is away and will be back
    # A job that is not known was lost with a controller, or ended long ago. It cannot be said how: doing it
    # again costs time and no correctness.
    word = ran.stdout.strip() or "UNKNOWN"
    return "success" if word == "COMPLETED" else "running" if word in WAITING else "failed"


print(status(sys.argv[1]))
