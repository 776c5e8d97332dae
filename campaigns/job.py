"""Runs one job of plan.json in the campaign's folder and writes state/KIND/SUBJECT.json.

  job.py FOLDER JOB [SUBMISSION]

A command that ends by itself has answered, whatever its exit code: the answer is kept, and the job is over.
A command that was killed has not: nothing is written, this ends with 1, and the engine tries again."""
import fcntl
import hashlib
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import time

from plan import program, write_whole


def _state(job_id):
    return os.path.join("state", job_id + ".json")


def _blocked_by(job):
    """The first job that this one needs and that gave nothing to be used."""
    for other in job["after"]:
        with open(_state(other), encoding="utf-8") as file:
            if json.load(file)["exit_code"] != 0:
                return other
    return None


def _clear(paths):
    for path in paths:
        if os.path.isdir(path):
            shutil.rmtree(path)
        elif os.path.exists(path):
            os.remove(path)


def _sha256(path):
    digest = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def _files(paths):
    """Every file that a job wrote; a file that is named must be there."""
    for path in paths:
        if os.path.isdir(path):
            for folder, below, names in os.walk(path):
                below.sort()
                yield from (os.path.join(folder, name) for name in sorted(names) if not name.startswith("."))
        else:
            yield path


def _outputs(paths):
    return [{"path": path, "bytes": os.path.getsize(path), "sha256": _sha256(path)} for path in _files(paths)
            if os.path.basename(path) != "timing.json"]  # never the same twice


def _run(job):
    """Exit code, what was printed, the last line of what was said, seconds."""
    # A tool ends with the shell that a scheduler kills, not after it.
    begin = time.monotonic()
    command = [program(job["command"][0]), *job["command"][1:]]
    with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as child:
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, lambda *_: child.terminate())
        out, err = child.communicate()
    lines = err.decode("utf-8", "replace").strip().splitlines()
    return child.returncode, out, lines[-1] if lines else "", time.monotonic() - begin


def _written(job, code):
    """The outputs of a command that says it is done; raises OSError when one is missing."""
    return _outputs(job["outputs"]) if code in (0, 3) else []


def _alone(job_id):
    """A lock that no other run of the job has: one whose connection broke may still be at work somewhere."""
    path = os.path.join(".locks", job_id)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    file = open(path, "a", encoding="ascii")
    fcntl.flock(file, fcntl.LOCK_EX)
    return file


def run(job):
    blocker = _blocked_by(job)
    if blocker:
        write_whole(_state(job["id"]), json.dumps(
            {"exit_code": -1, "message": f"not begun: it needs {blocker}", "outputs": []}) + "\n")
        return 0
    _clear(job["clears"])
    places = list(job["clears"])
    if "-o" in job["command"]:
        places.append(job["command"][job["command"].index("-o") + 1])
    for path in places:
        os.makedirs(os.path.dirname(path), exist_ok=True)
    code, out, said, seconds = _run(job)
    if code < 0 or code > 128:
        print(f"campaign: {job['id']}: ended by signal {-code if code < 0 else code - 128}", file=sys.stderr)
        return 1
    try:
        printed = json.loads(out) if out else {}
        outputs = _written(job, code)
    except (ValueError, OSError) as error:
        code, said, printed, outputs = 1, f"{job['command'][0]}: {error}", {}, []
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    cost = {"seconds": round(seconds, 3), "cpu_s": round(used.ru_utime + used.ru_stime, 3),
            "peak_mb": used.ru_maxrss // 1024,
            "input_mb": round(sum(map(os.path.getsize, job["inputs"])) / 1e6, 3),
            "output_mb": round(sum(output["bytes"] for output in outputs) / 1e6, 3)}
    write_whole(os.path.join("state", job["id"] + ".cost.json"), json.dumps(cost) + "\n")
    write_whole(_state(job["id"]), json.dumps(
        {"exit_code": code, "message": said if code else "", "outputs": outputs, "said": printed}) + "\n")
    return 0


def main(arguments):
    os.chdir(arguments[0])
    with open("plan.json", encoding="utf-8") as file:
        jobs = {job["id"]: job for job in json.load(file)["jobs"]}
    # A scheduler whose controller dies may start a submission twice, or not know that it has ended.
    ended = os.path.join(".ended", arguments[2]) if len(arguments) > 2 else None
    with _alone(arguments[1]) as lock:
        if ended and os.path.exists(ended):
            return 0
        lock.write(f"{time.time():.3f} {os.uname().nodename} {os.getpid()}\n")  # one line a run
        lock.flush()
        code = run(jobs[arguments[1]])
        if ended and code == 0:
            os.makedirs(".ended", exist_ok=True)
            with open(ended, "w", encoding="ascii"):
                pass
        return code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
