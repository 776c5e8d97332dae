"""The module kerbstone: roads whose heights are known by construction."""

import gc
import math
import pickle
import threading

import kerbstone
import numpy as np
import pytest

V_M = np.array([-4.0, -1.0, 0.0, 2.0, 5.0])


def height(u_m, v_m):
    return 0.02 * u_m - 0.05 * v_m


@pytest.fixture
def straight():
    """100 m along +y at x = 10, half a metre between rows; it climbs by 2 % and falls by 5 % to the left."""
    u_m = np.arange(201) * 0.5
    return kerbstone.Road.from_arrays(np.full(201, 10.0), u_m, V_M, height(u_m[:, None], V_M[None, :]))


def test_answers_numbers_and_arrays(straight):
    # On +y, left is towards -x.
    assert straight.z(10.0, 50.0) == pytest.approx(1.0, abs=1e-6)
    assert straight.z(8.0, 50.0) == pytest.approx(1.0 - 0.1, abs=1e-6)
    assert straight.uv(8.0, 50.0) == pytest.approx((50.0, 2.0))
    assert straight.xy(50.0, 2.0) == pytest.approx((8.0, 50.0))
    assert straight.z_at_uv(50.0, -4.0) == pytest.approx(1.2, abs=1e-6)
    x_m, y_m = np.array([[10.0, 8.0], [10.0, 14.0]]), np.array([[50.0, 50.0], [20.0, 20.0]])
    z_m = straight.z(x_m, y_m)
    assert z_m.shape == (2, 2)
    assert z_m == pytest.approx(np.array([[1.0, 0.9], [0.4, 0.6]]), abs=1e-6)
    # Lists, whole numbers, one number beside an array.
    assert straight.z([10, 10], 50) == pytest.approx([1.0, 1.0], abs=1e-6)
    assert isinstance(straight.z(10, 50), float) and isinstance(straight.sample(8, 50), kerbstone.Sample)
    u_m, v_m = straight.uv(x_m, y_m)
    assert u_m == pytest.approx(y_m, abs=1e-6) and v_m == pytest.approx(10.0 - x_m, abs=1e-6)
    assert straight.z_at_uv(u_m, v_m) == pytest.approx(z_m, abs=1e-9)


def test_samples_have_the_same_names_for_numbers_and_arrays(straight):
    one = straight.sample(8.0, 50.0)
    many = straight.sample([8.0, 300.0], [50.0, 0.0])
    assert one.valid and many.valid.tolist()[0]
    for name in ("u_m", "v_m", "z_m", "dzdx", "dzdy", "heading_rad", "normal_z", "friction"):
        assert getattr(many, name)[0] == getattr(one, name)
    assert one.heading_rad == pytest.approx(math.pi / 2)
    assert (one.dzdx, one.dzdy) == pytest.approx((0.05, 0.02), abs=1e-5)


def test_heights_come_back_from_files_of_every_format(straight, tmp_path):
    for format, accuracy in (("KRBI", 0), ("KDBI", 0), ("LDFI", 1e-9), ("LRFI", 1e-3)):
        path = str(tmp_path / f"{format}.crg")
        straight.write(path, format)
        again = kerbstone.Road.read(path)
        assert again.z_m == pytest.approx(straight.z_m, abs=accuracy)
        assert again.length_m == pytest.approx(100.0, abs=1e-3)
    assert not straight.closed
    assert straight.check() == []


def test_the_grid_is_not_copied_and_outlives_the_name(straight):
    z_m = straight.z_m
    assert np.shares_memory(z_m, straight.z_m)
    with pytest.raises(ValueError):
        z_m[0, 0] = 1.0
    expected = z_m.copy()
    del straight
    gc.collect()
    assert (z_m == expected).all()


def test_edits(straight):
    part = straight.crop(u_begin_m=20.0, u_end_m=40.0, v_right_m=-1.0, v_left_m=2.0)
    assert part.length_m == pytest.approx(20.0)
    assert part.v_m.tolist() == [-1.0, 0.0, 2.0]
    assert part.z(10.0, 30.0) == pytest.approx(0.6, abs=1e-6)
    back = straight.reverse()
    assert back.z(8.0, 50.0) == pytest.approx(straight.z(8.0, 50.0), abs=1e-6)
    assert back.uv(8.0, 50.0)[1] == pytest.approx(-2.0)
    assert straight.resample(u_step_m=1.0).u_step_m == pytest.approx(1.0)
    assert straight.append(straight, move=True).length_m == pytest.approx(200.0)


def test_a_strip_is_the_road_below_it(straight):
    strip = straight.strip(9.0, 50.0, math.pi / 2, along=4, across=6, step_m=0.1)
    assert strip.shape == (4, 6)
    along, across = np.meshgrid((np.arange(4) - 1.5) * 0.1, (np.arange(6) - 2.5) * 0.1, indexing="ij")
    assert strip == pytest.approx(height(50.0 + along, 1.0 + across), abs=1e-4)


def test_a_road_goes_through_pickle_and_paths(straight, tmp_path):
    straight.write(tmp_path / "straight.crg", "KDBI")
    road = kerbstone.Road.read(tmp_path / "straight.crg", interpolation="smooth", friction=0.8)
    again = pickle.loads(pickle.dumps(road))
    x_m, y_m = np.linspace(1, 40, 57), np.linspace(-2, 2, 57)
    assert again.sample(x_m, y_m).tobytes() == road.sample(x_m, y_m).tobytes()
    assert again.sample(20.0, 0.5).friction == 0.8
    with pytest.raises(ValueError):
        kerbstone.Road.__new__(kerbstone.Road).__setstate__((b"no road",))


def test_errors_say_what_was_wanted(tmp_path):
    with pytest.raises(kerbstone.Error, match="cannot open"):
        kerbstone.Road.read(str(tmp_path / "missing.crg"))
    (tmp_path / "text.crg").write_text("no road\n")
    with pytest.raises(kerbstone.Error, match="text.crg"):
        kerbstone.Road.read(str(tmp_path / "text.crg"))
    u_m = np.arange(5.0)
    flat = np.zeros((5, 2))
    with pytest.raises(ValueError, match="v_m"):
        kerbstone.Road.from_arrays(u_m, 0 * u_m, [-1.0, 0.0, 1.0], flat)
    with pytest.raises(ValueError, match="from row 2 to the next"):
        kerbstone.Road.from_arrays([0, 1, 2, 5, 6], 0 * u_m, [-1.0, 1.0], flat)
    with pytest.raises(ValueError, match="x_m"):
        kerbstone.Road.from_arrays([0, 1, 2], [0, 0, 0], [-1.0, 1.0], flat)
    with pytest.raises(ValueError, match="format"):
        kerbstone.Road.from_arrays(u_m, 0 * u_m, [-1.0, 1.0], flat).write(str(tmp_path / "x.crg"), "XXXX")
    with pytest.raises(ValueError, match="broadcast"):
        kerbstone.Road.from_arrays(u_m, 0 * u_m, [-1.0, 1.0], flat).z([1.0, 2.0], [1.0, 2.0, 3.0])


def test_nan_stays_nan_and_empty_stays_empty(straight):
    assert math.isnan(straight.z(math.nan, 0.0))
    assert np.isnan(straight.z([math.nan, 10.0], [0.0, 50.0])).tolist() == [True, False]
    assert straight.z([], []).shape == (0,)
    assert len(straight.sample([], [])) == 0


def test_threads_ask_one_road_at_once(straight):
    random = np.random.default_rng(1)
    x_m, y_m = 10.0 + random.uniform(-4, 3, 200_000), random.uniform(0, 100, 200_000)
    expected = straight.z(x_m, y_m)
    answers = [None] * 4

    def ask(k):
        answers[k] = straight.z(x_m, y_m)

    threads = [threading.Thread(target=ask, args=(k,)) for k in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    for answer in answers:
        assert (answer == expected).all()
