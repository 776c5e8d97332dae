"""From a track's mesh to findings, in one script: build the road, drive it, and ask why two cars drive differently.

    python3 mesh_to_findings.py MESH_OR_TRACK.yaml VEHICLE.yaml OUT

Laps of a car with more drag than the vehicle file says stand for the recording. In a notebook, `built` or `found` as
the last line of a cell shows the report.
"""

import csv
import sys
from pathlib import Path

import kerbstone
import numpy as np

CHANNELS = ("time_s", "x_m", "y_m", "yaw_rad", "vx_mps", "yaw_rate_radps", "ax_mps2", "ay_mps2", "steer_rad", "throttle",
            "brake_fl_pa", "brake_fr_pa", "brake_rl_pa", "brake_rr_pa", "wheel_fl_radps", "wheel_fr_radps",
            "wheel_rl_radps", "wheel_rr_radps", "engine_radps", "gear")  # fmt: skip


def record(car: kerbstone.Car, road: kerbstone.Road, path: Path, laps: int) -> None:
    """Laps as a logger has them: 50 rows a second."""
    driven = car.lap(road, laps=laps, record_every=20)
    if not driven.complete:
        sys.exit(f"the car did not finish: {driven.problem}")
    with open(path, "w", encoding="utf-8", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(CHANNELS)
        rows.writerows(np.column_stack([driven.telemetry[name] for name in CHANNELS]).tolist())


def main(mesh: Path, vehicle: Path, out: Path) -> None:
    try:
        built = kerbstone.build(mesh, out / "road", progress=lambda stage, share: print(f"{share:4.0%} {stage}"))
    except kerbstone.Question as question:
        for answer in question.answers:
            print(f"{answer.length_m:.0f} m long, {answer.width_m:.1f} m wide: crgbuild {answer.flags}")
        raise
    print(built)
    findings = built.report.findings if built.report else []
    print(f"{built.summary.reference_line.length_m:.0f} m, {len(findings)} findings about the road")
    for remark in built.remarks:
        print("remark:", remark)

    road = kerbstone.Road.read(built.crg_path)
    draggy = kerbstone.Car.read(str(vehicle), settings=["aero.drag_area_m2=1.3"])
    record(draggy, road, out / "recorded.csv", laps=4)
    found = kerbstone.explain(out / "recorded.csv", vehicle, built.crg_path, out / "why", fuel_kg=30, skip_simulation=True)
    print(found)
    for finding in found.findings:
        for parameter in finding.parameters:
            print(f"{finding.mechanism}: {parameter.name} {parameter.value:.4g} {parameter.unit}")
    (out / "report.html").write_text(found._repr_html_(), encoding="utf-8")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*map(Path, sys.argv[1:]))
