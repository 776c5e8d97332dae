#!/usr/bin/env python3
"""Runs one job of a campaign on a host with a free place, and ends as it ends.

The places of a host are files below .places in the campaign's folder, locked while they are used, so that they
are free again however this ends. A host that cannot be reached is left alone for a minute; the job goes to
another. Where only the connection broke, what ran there may go on: job.py waits for it before it begins anew."""
import fcntl
import json
import os
import shlex
import subprocess
import sys
import time

CAMPAIGNS = os.path.normpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), "../.."))
UNREACHABLE = 255  # of ssh itself
REST_S = 60


def properties_of(script):
    """What Snakemake says of the job, a comment of its script."""
    mark = "# properties = "
    with open(script, encoding="utf-8") as file:
        return json.loads(next(line for line in file if line.startswith(mark))[len(mark):])


def hosts():
    """(host, places) of each line; # begins a comment."""
    path = os.environ.get("KERBSTONE_HOSTS")
    if not path:
        sys.exit("campaign: KERBSTONE_HOSTS is not set; it names a file with a host and its number of jobs a line")
    found = []
    with open(path, encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            words = line.split("#")[0].split()
            if not words:
                continue
            # A dash would make an option of ssh of it.
            if len(words) != 2 or words[0].startswith("-") or not words[1].isdecimal() or int(words[1]) < 1:
                sys.exit(f"campaign: {path}:{number}: '{line.strip()}' seen, HOST NUMBER wanted")
            found.append((words[0], int(words[1])))
    if not found:
        sys.exit(f"campaign: {path}: no host")
    return found


def rests(host):
    try:
        return time.time() - os.path.getmtime(os.path.join(".places", f"{host}.unreachable")) < REST_S
    except OSError:
        return False


def take():
    """A host and its locked place; waits until there is one."""
    os.makedirs(".places", exist_ok=True)
    while True:
        for place in range(max(count for _, count in hosts())):
            for host, count in hosts():
                if place >= count or rests(host):
                    continue
                file = open(os.path.join(".places", f"{host}.{place}"), "w", encoding="ascii")
                try:
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    return host, file
                except OSError:
                    file.close()
        time.sleep(0.5)


def main(script):
    job = properties_of(script)["wildcards"]["job"]
    tools = os.environ.get("KERBSTONE_TOOLS", "")
    command = (f"cd {shlex.quote(os.getcwd())} && KERBSTONE_TOOLS={shlex.quote(tools)} PYTHONDONTWRITEBYTECODE=1 "
               f"exec python3 {shlex.quote(CAMPAIGNS)}/job.py . {shlex.quote(job)}")
    while True:
        host, place = take()
        with place:
            code = subprocess.run([*os.environ.get("KERBSTONE_SSH", "ssh -o BatchMode=yes -o ConnectTimeout=10 "
                                                   "-o ServerAliveInterval=15").split(), host, command],
                                  stdin=subprocess.DEVNULL).returncode
        if code != UNREACHABLE:
            return code
        with open(os.path.join(".places", f"{host}.unreachable"), "w", encoding="ascii"):
            pass
        print(f"campaign: {host} cannot be reached; {job} goes to another host", file=sys.stderr)


sys.exit(main(sys.argv[-1]))
