"""What crgbuild export writes, read by scipy and by a reader of PNG of its own, against the road itself."""

import json
import os
import struct
import subprocess
import zlib

import kerbstone
import numpy as np
import pytest

CRGBUILD = os.environ["CRGBUILD"]


@pytest.fixture
def road_file(tmp_path):
    u = np.arange(0, 120.25, 0.25)
    v = np.linspace(-5, 5, 41)
    z = 40 + 3 * np.sin(u / 25)[:, None] - 0.03 * abs(v)[None, :]
    z[200:240, 30:] = np.nan
    road = kerbstone.Road.from_arrays(80 * np.sin(u / 80), 80 * (1 - np.cos(u / 80)), v, z)
    path = str(tmp_path / "bend.crg")
    road.write(path)
    return path


def export(road_file, output, *more):
    ran = subprocess.run(
        [CRGBUILD, "export", road_file, "-o", str(output), *more], capture_output=True, text=True, check=False
    )
    assert ran.returncode == 0, ran.stderr
    return ran.stdout


def read_grey_png(path):
    """16 bits of grey, by the PNG specification."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    at, packed, size, kinds = 8, b"", None, []
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0]
        kinds.append(kind)
        if kind == b"IHDR":
            width, height, depth, colour, *_ = struct.unpack(">IIBBBBB", body)
            assert (depth, colour) == (16, 0)
            size = (height, width)
        elif kind == b"IDAT":
            packed += body
        at += 12 + length
    assert b"gAMA" not in kinds
    raw = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(size[0], 1 + 2 * size[1])
    before = np.zeros(2 * size[1], np.uint8)
    rows = []
    for line in raw:
        how, row = int(line[0]), line[1:].copy()
        for k in range(len(row)):
            a = int(row[k - 2]) if k >= 2 else 0
            b = int(before[k])
            c = int(before[k - 2]) if k >= 2 else 0
            p = a + b - c
            paeth = min((a, b, c), key=lambda value: abs(p - value))
            row[k] = (int(row[k]) + (0, a, b, (a + b) // 2, paeth)[how]) % 256
        rows.append(row)
        before = row
    return np.array(rows).view(">u2").astype(np.uint16)


@pytest.mark.parametrize("ending", ["png", "raw"])
def test_heightmap(road_file, tmp_path, ending):
    output = tmp_path / f"map.{ending}"
    told = export(road_file, output, "--step-m", "0.5")
    facts = json.loads((tmp_path / f"map.{ending}.json").read_text())
    assert "mm at most between them" in told
    shape = (facts["rows"], facts["columns"])
    levels = read_grey_png(output) if ending == "png" else np.fromfile(output, "<u2").reshape(shape)
    assert levels.shape == shape
    road = kerbstone.Road.read(road_file)
    x, y = np.meshgrid(
        facts["x_m"] + facts["cell_m"] * np.arange(shape[1]), facts["y_m"] - facts["cell_m"] * np.arange(shape[0])
    )
    sample = road.sample(x.ravel(), y.ravel())
    true = np.where(sample.inside & sample.valid, sample.z_m, np.nan).reshape(shape)
    assert np.array_equal(levels == 0, np.isnan(true))
    assert (levels > 0).sum() > 4000
    here = levels > 0
    assert np.max(abs(facts["z_m"] + facts["z_step_m"] * levels[here] - true[here])) < 1e-3


def test_mat(road_file, tmp_path):
    io = pytest.importorskip("scipy.io")
    export(road_file, tmp_path / "bend.mat")
    read = io.loadmat(tmp_path / "bend.mat")
    road = kerbstone.Road.read(road_file)
    assert np.array_equal(read["x_m"].ravel(), road.x_m)
    assert np.array_equal(read["v_m"].ravel(), road.v_m)
    assert read["z_m"].shape == road.z_m.shape
    assert np.array_equal(np.isnan(read["z_m"]), np.isnan(road.z_m))
    u = read["u_begin_m"][0, 0] + read["u_step_m"][0, 0] * np.arange(read["z_m"].shape[0])
    at = road.z_at_uv(np.repeat(u, road.v_m.size), np.tile(road.v_m, u.size)).reshape(read["z_m"].shape)
    assert np.nanmax(abs(at - read["z_m"])) < 1e-4
    assert read["closed"][0, 0] == 0
