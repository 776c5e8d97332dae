"""build and refine beside the commands that do the same: the same files, the same words."""

import json
import os
import signal
import subprocess
import threading
import time
from pathlib import Path

import kerbstone
import numpy as np
import pytest
from beside_commands import TOOLS, command, framed_page, same_folders, same_values


def write_mesh(path, length_m=200, radius_m=150, rings=0):
    """A road 8 m wide with a crown of 2 %, in a bend; or closed rings, 400 m apart."""
    across = np.linspace(-4, 4, 9)
    rows = 200 if rings else int(length_m) + 1
    angles = np.arange(rows) * 2 * np.pi / rows if rings else np.arange(rows) / radius_m
    with open(path, "w", encoding="utf-8") as file:
        for k in range(max(rings, 1)):
            file.write(f"o asphalt{k}\n")
            for a in angles:
                for v in across:
                    r = radius_m - v
                    file.write(f"v {r * np.sin(a) + 400 * k:.6f} {radius_m - r * np.cos(a):.6f} {-0.02 * abs(v):.6f}\n")
            for i in range(rows if rings else rows - 1):
                for j in range(across.size - 1):
                    a = k * rows * across.size + i * across.size + j + 1
                    b = k * rows * across.size + (i + 1) % rows * across.size + j + 1
                    file.write(f"f {a} {b} {b + 1} {a + 1}\n")


KEYS = {"up": "z", "unit": "m", "u_step_m": 0.5, "v_step_m": 0.5}
FLAGS = ["--up", "z", "--unit", "m", "--u-step-m", "0.5", "--v-step-m", "0.5"]


def test_build_writes_what_the_command_writes(here):
    for name in ("command", "python"):
        write_mesh(here.command.parent / name / "track.obj")
    here.enter("command")
    printed = command("crgbuild", "build", "track.obj", "-o", "out", *FLAGS).stdout
    here.enter("python")
    stages = []
    built = kerbstone.build("track.obj", Path("out"), progress=lambda stage, share: stages.append((stage, share)), **KEYS)
    names = same_folders(here.command / "out", here.python / "out")
    assert {"track.crg", "report.json", "report.html", "summary.json", "track.png"} <= set(names)

    assert built.crg_path == "out/track.crg" and built.page_path == "out/report.html" and built.patches_path is None
    same_values(built.summary, json.loads(Path("out/summary.json").read_text("utf-8")))
    same_values(built.report, json.loads(Path("out/report.json").read_text("utf-8")))
    assert built.summary.reference_line.length_m == pytest.approx(200, abs=1)
    assert built.verdict == built.report.verdict and not built.reused
    assert [f"remark   {remark}" for remark in built.remarks] == [
        line for line in printed.splitlines() if line.startswith("remark ")
    ]
    assert framed_page(built._repr_html_()) == Path("out/report.html").read_bytes()
    assert len({stage for stage, _ in stages}) > 3 and all(0 <= share <= 1 for _, share in stages)
    road = kerbstone.Road.read(built.crg_path)
    assert road.z(150 * np.sin(0.5), 150 * (1 - np.cos(0.5))) == pytest.approx(0.0, abs=0.005)

    assert kerbstone.build("track.obj", "out", **KEYS).reused
    # Another program: what the command left is not taken for the module's own.
    here.enter("command")
    assert not kerbstone.build("track.obj", "out", **KEYS).reused

    # As a run that is killed while it moves its files in leaves them.
    kerbstone.Road.read("out/track.crg")
    manifest = Path("out/manifest.json")
    manifest.write_text(manifest.read_text("utf-8").replace('"complete": true', '"complete": false'), "utf-8")
    with pytest.raises(kerbstone.Error, match="'complete' is false"):
        kerbstone.Road.read("out/track.crg")
    Path("out/report.html").unlink()
    assert "track" in built._repr_html_()


def test_build_refuses_in_the_words_of_the_command(here):
    here.enter("python")
    write_mesh("track.obj")
    Path("empty.obj").write_text("o road\n", encoding="utf-8")
    for words, flags, keys in (
        ("missing.obj", [], {}),
        ("empty.obj", [], {}),
        ("track.obj", ["--up", "z", "--unit", "m", "--v-max-m", "0.1"], {"up": "z", "unit": "m", "v_max_m": 0.1}),
    ):
        ran = subprocess.run([TOOLS["crgbuild"], "build", words, "-o", "out", *flags], capture_output=True, text=True, check=False)
        with pytest.raises(kerbstone.Error) as refused:
            kerbstone.build(words, "out", **keys)
        assert ran.returncode != 0 and str(refused.value) in ran.stderr
        assert not Path("out").exists()
    with pytest.raises(kerbstone.Error, match="no recipe key 'no_such_key'"):
        kerbstone.build("track.obj", "out", no_such_key=1)
    with pytest.raises(TypeError, match="u_step_m"):
        kerbstone.build("track.obj", "out", u_step_m=object())
    with pytest.raises(ValueError, match="reverse"):
        kerbstone.build("track.obj", "out", reverse=False)


def test_a_road_that_must_not_be_used_is_raised_with_what_was_made(here):
    here.enter("python")
    write_mesh("track.obj")
    ran = command("crgbuild", "build", "track.obj", "-o", "out", *FLAGS, "--max-z-error-p99-m", "1e-9", code=3)
    with pytest.raises(kerbstone.NotUsable) as refused:
        kerbstone.build("track.obj", "out", max_z_error_p99_m=1e-9, force=True, **KEYS)
    assert str(refused.value) in ran.stderr and "not usable, 1 error: 1 % of the points of the road" in str(refused.value)
    result = refused.value.result
    assert isinstance(result, kerbstone.Built) and Path(result.crg_path).exists()
    assert isinstance(refused.value, kerbstone.Error)


def test_a_question_has_its_answers(here):
    here.enter("python")
    write_mesh("two.obj", radius_m=60, rings=2)
    ran = command("crgbuild", "build", "two.obj", "-o", "out", "--up", "z", "--unit", "m", "--json", code=3)
    asked = json.loads(ran.stdout)
    with pytest.raises(kerbstone.Question) as question:
        kerbstone.build("two.obj", "out", up="z", unit="m")
    assert str(question.value) in ran.stderr and question.value.result is None
    assert [answer.flags for answer in question.value.answers] == [answer["flags"] for answer in asked["answers"]]
    assert len(question.value.answers) >= 2 and question.value.answers[0].width_m == pytest.approx(8, abs=0.5)


def test_other_threads_run_and_ctrl_c_ends_a_build(here):
    here.enter("python")
    write_mesh("track.obj", length_m=400)
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.005):
            ticks.append(time.monotonic())

    ticker = threading.Thread(target=tick)
    ticker.start()
    begin = time.monotonic()
    kerbstone.build("track.obj", "first", **KEYS)
    took = time.monotonic() - begin
    done.set()
    ticker.join()
    assert len(ticks) > 0.1 * took / 0.005

    begun = threading.Event()

    def interrupt():
        begun.wait()
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        for _ in range(100):
            kerbstone.build("track.obj", "second", force=True, progress=lambda stage, share: begun.set(), **KEYS)
    assert not list(Path("second").glob(".kerbstone*")) if Path("second").exists() else True

    class Stop(Exception):
        pass

    def stop(stage, share):
        raise Stop

    with pytest.raises(Stop):
        kerbstone.build("track.obj", "third", progress=stop, **KEYS)
    assert not Path("third").exists()


def test_builds_at_once_are_the_builds_one_by_one(here):
    here.enter("python")
    write_mesh("track.obj")
    kerbstone.build("track.obj", "alone", report=False, **KEYS)
    threads = [
        threading.Thread(target=lambda k=k: kerbstone.build("track.obj", f"out{k}", report=False, **KEYS)) for k in range(3)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k in range(3):
        assert Path(f"out{k}/track.crg").read_bytes() == Path("alone/track.crg").read_bytes()


def wavy_road(path):
    u_m = np.arange(0, 200.25, 0.25)
    v_m = np.linspace(-6, 6, 49)
    z_m = 0.01 * np.sin(u_m[:, None] / 2.5) + 0.01 * np.cos(v_m[None, :] + u_m[:, None] / 4) - 0.015 * abs(v_m)[None, :]
    kerbstone.Road.from_arrays(120 * np.sin(u_m / 120), 120 * (1 - np.cos(u_m / 120)), v_m, z_m).write(str(path))


@pytest.fixture(scope="module")
def scanned(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scanned")
    wavy_road(folder / "road.crg")
    command("lidar2mesh", "synth", folder / "road.crg", "-o", folder / "scans", "--u-begin-m", 60, "--u-end-m", 120, "--azimuths", 128, "--v-m", -1, 1)
    command("lidar2mesh", "synth", folder / "road.crg", "-o", folder / "noise", "--u-begin-m", 40, "--u-end-m", 80, "--azimuths", 16, "--beams", 8,
            "--noise-m", 0.2, "--cars", 0)  # fmt: skip
    return folder


@pytest.mark.parametrize(
    ("flags", "options"),
    [
        ([], {}),
        (
            ["--frame", "sensor", "--extrinsic", 0.5, 0, 0.123456789, 0, 0, 1, "--max-range-m", 40, "--drift-m", 0.04, "--drift-rad", 1e-3, "--min-points",
             2, "--cloud-unit", "m", "--base-stddev-m", 0.03, "--gate-m", 0.4, "--no-grass", "--format", "stl,pcd", "--doubles", "--no-report"],
            {"frame": "sensor", "extrinsic": [0.5, 0, 0.123456789, 0, 0, 1], "max_range_m": 40, "drift_m": 0.04, "drift_rad": 1e-3, "min_points": 2,
             "cloud_unit": "m", "base_stddev_m": 0.03, "gate_m": 0.4, "no_grass": True, "format": ["stl", "pcd"], "doubles": True, "report": False},
        ),
    ],
)  # fmt: skip
def test_refine_writes_what_the_command_writes(here, scanned, flags, options):
    scans, poses, base = scanned / "scans", scanned / "scans/trajectory.csv", scanned / "road.crg"
    here.enter("command")
    code = 3 if options else 0  # the sensor stands elsewhere
    ran = subprocess.run(
        [TOOLS["lidar2mesh"], "map", scans, "--trajectory", poses, "--road", base, "-o", "out", *map(str, flags)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ran.returncode in (0, code), ran.stderr
    here.enter("python")
    try:
        refined = kerbstone.refine(scans, "out", trajectory=poses, base=base, **options)
        assert ran.returncode == 0
    except kerbstone.NotUsable as refused:
        assert ran.returncode == 3 and str(refused) in ran.stderr
        refined = refused.result
    same_folders(here.command / "out", here.python / "out")
    same_values(refined.summary, json.loads(Path("out/summary.json").read_text("utf-8")))
    assert refined.coverage == pytest.approx(refined.summary.grid.coverage) and refined.remarks == refined.summary.remarks
    assert refined.converged == refined.summary.registration.converged
    if options:
        assert refined.report is None and refined.page_path is None and "Refined" in refined._repr_html_()
    else:
        assert framed_page(refined._repr_html_()) == Path("out/report.html").read_bytes()
        assert refined.report.comparisons[0].key == "against"


def test_refine_without_a_base_and_from_several_files(here, scanned):
    clouds = sorted(path for path in (scanned / "scans").iterdir() if path.suffix in (".ply", ".pcd", ".las"))
    poses = scanned / "scans/trajectory.csv"
    here.enter("command")
    command("lidar2mesh", "map", *clouds, "--trajectory", poses, "--v-max-m", 4, "--step-m", 0.25, "-o", "out", "--no-report")
    here.enter("python")
    kerbstone.refine(clouds, "out", trajectory=poses, v_max_m=4, step_m=0.25, report=False)
    same_folders(here.command / "out", here.python / "out")


def test_refine_refuses(here, scanned):
    here.enter("python")
    scans, poses, base = scanned / "scans", scanned / "scans/trajectory.csv", scanned / "road.crg"
    ran = command("lidar2mesh", "map", scans, "--road", base, "--frame", "sensor", "-o", "out", code=1)
    with pytest.raises(kerbstone.Error) as refused:
        kerbstone.refine(scans, "out", base=base, frame="sensor")
    assert str(refused.value) in ran.stderr
    with pytest.raises(kerbstone.NotUsable, match="had not converged") as unusable:
        kerbstone.refine(scanned / "noise", "noise", trajectory=scanned / "noise/trajectory.csv", base=base, drift_m=1, drift_rad=0.05)
    assert unusable.value.result.faults and Path("noise/refined.crg").exists()
    assert unusable.value.result.report.verdict == "not_usable"
    for wrong, words in (
        ({"gate_m": 50}, "--gate-m: 50 seen, 0.05 to 5 wanted"),
        ({"gate_m": float("nan")}, "--gate-m"),
        ({"frame": "moon"}, "'moon' seen"),
        ({"extrinsic": [1, 2]}, "six numbers"),
        ({"outliers": [1]}, "neighbours"),
        ({"centreline": poses}, "excludes"),
        ({"min_points": 0}, "--min-points: 0 seen"),
    ):
        with pytest.raises(kerbstone.Error, match=words):
            kerbstone.refine(scans, "out", trajectory=poses, base=base, **wrong)
    with pytest.raises(kerbstone.Error, match="no scan"):
        kerbstone.refine([], "out", trajectory=poses, base=base)
    with pytest.raises(TypeError, match="no argument 'gate'"):
        kerbstone.refine(scans, "out", trajectory=poses, base=base, gate=1)
    with pytest.raises(TypeError, match="gate_m: 'wide' seen"):
        kerbstone.refine(scans, "out", trajectory=poses, base=base, gate_m="wide")
    with pytest.raises(ValueError, match="v_max_m"):
        kerbstone.refine(scans, "out", trajectory=poses, base=base, v_max_m=4)
    assert not Path("out").exists()
