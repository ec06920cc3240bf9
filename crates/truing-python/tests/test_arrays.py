"""Solvers on arrays, each against numbers made from the geometry here."""

import numpy as np
import pytest
import truing
from truing import Surface, force_impedance, frame_fit, ft_center, pose_icp, probe_comp, tracker_lm


def rotation(vector):
    """Rodrigues' formula."""
    angle = np.linalg.norm(vector)
    x, y, z = np.asarray(vector) / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


@pytest.fixture
def draws():
    return np.random.default_rng(20240611)


# Round-off: some 10³ mm times 2⁻⁵² times some 10² operations.
EXACT_MM = 1e-10


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_frame_is_found_with_its_scatter(draws, dimension):
    turn = rotation([0.0, 0.0, 0.3] if dimension == 2 else [0.2, -0.1, 0.3])[:dimension, :dimension]
    shift, std_mm = np.arange(1.0, dimension + 1.0), 0.02
    from_mm = draws.uniform(-500.0, 500.0, (400, dimension))
    to_mm = from_mm @ turn.T + shift + draws.normal(0.0, std_mm, from_mm.shape)
    fit = frame_fit.fit(from_mm, to_mm, std_mm)
    assert fit.matrix.shape == (dimension + 1, dimension + 1)
    assert np.allclose(fit.apply(from_mm) + fit.residuals_mm, to_mm, rtol=0.0, atol=EXACT_MM)
    assert fit.degrees_of_freedom == 400 * dimension - len(fit.parameters)
    # χ² over its degrees of freedom: five of its own standard deviations.
    assert abs(fit.variance_factor - 1.0) < 5.0 * np.sqrt(2.0 / fit.degrees_of_freedom)
    moved = fit.linear @ turn.T - np.eye(dimension)
    assert abs(moved).max() < 5.0 * std_mm / 250.0 / np.sqrt(400)


def test_frames_take_uncertainties_of_every_form(draws):
    from_mm = draws.uniform(-100.0, 100.0, (30, 3))
    to_mm = from_mm + draws.normal(0.0, 0.1, (30, 3))
    same = [
        0.1,
        np.full(30, 0.1),
        np.full((30, 3), 0.1),
        np.broadcast_to(0.01 * np.eye(3), (30, 3, 3)),
    ]
    fits = [frame_fit.fit(from_mm, to_mm, std_mm) for std_mm in same]
    for fit in fits[1:]:
        assert np.allclose(fit.matrix, fits[0].matrix, rtol=0.0, atol=1e-9)
        assert np.allclose(fit.covariance, fits[0].covariance, rtol=1e-9, atol=1e-18)


def test_arrays_with_gaps_and_in_another_order_are_read_rightly(draws):
    wide = draws.uniform(-100.0, 100.0, (40, 6))
    from_mm, to_mm = wide[::2, ::2], np.asfortranarray(wide[::2, ::2] + 1.0)
    fit = frame_fit.fit(from_mm, to_mm, 0.01)
    assert np.allclose(fit.translation_mm, 1.0, rtol=0.0, atol=EXACT_MM)
    # Covariances that differ from row to row, and lie from the last column on.
    factors = draws.normal(0.0, 0.01, (20, 3, 3)) + 0.02 * np.eye(3)
    covariance = factors @ factors.transpose(0, 2, 1)
    lying = np.asfortranarray(covariance[:, ::-1])[:, ::-1]
    plain, otherwise = (frame_fit.fit(from_mm, to_mm, std) for std in (covariance, lying))
    assert (plain.covariance == otherwise.covariance).all()
    record = np.column_stack([draws.normal(size=(200, 2)), draws.uniform(-60.0, -30.0, 200), draws.normal(size=(200, 3))])
    found = [ft_center.locate_contact(at, z0_mm=30.0, min_fz_n=5.0) for at in (record, np.asfortranarray(record))]
    assert (found[0].covariance_mm2 == found[1].covariance_mm2).all()


def test_many_touches_are_compensated_as_each_alone(draws):
    # More than one stretch of them, and the last one short.
    part, n = Surface.sphere(50.0), 10_000
    towards = draws.normal(size=(n, 3))
    towards /= np.linalg.norm(towards, axis=1)[:, None]
    centers_mm = (53.0 + draws.normal(0.0, 0.01, (n, 1))) * towards
    std_mm = draws.uniform(1e-3, 2e-3, n)
    found = probe_comp.compensate(part, centers_mm, std_mm, tip_radius_mm=3.0)
    assert found.points_mm.shape == (n, 3) and found.inside_aperture.all() and found.error_mm is None
    for i in [0, 4095, 4096, n - 1]:
        alone = probe_comp.compensate(part, centers_mm[i : i + 1], std_mm[i], tip_radius_mm=3.0)
        assert (found.points_mm[i] == alone.points_mm[0]).all() and found.deviation_mm[i] == alone.deviation_mm[0]
        assert found.deviation_std_mm[i] == alone.deviation_std_mm[0]
    assert probe_comp.compensate(part, np.zeros((0, 3)), 1e-3, tip_radius_mm=3.0).normals.shape == (0, 3)
    centers_mm[[9200, 9300]] *= 2.0
    with pytest.raises(truing.InputError, match="touch 9201") as caught:
        probe_comp.compensate(part, centers_mm, std_mm, tip_radius_mm=3.0)
    assert caught.value.index == 9200


def test_arrays_of_a_wrong_shape_or_value_are_refused(draws):
    points = draws.uniform(size=(5, 3))
    with pytest.raises(truing.InputError, match="to_mm must have the shape 5 × 3, got 4 × 3"):
        frame_fit.fit(points, points[:4], 0.1)
    with pytest.raises(truing.InputError, match="n × 2 or n × 3"):
        frame_fit.fit(np.zeros((5, 4)), np.zeros((5, 4)), 0.1)
    with pytest.raises(truing.InputError, match="2 dimensions|rows and columns"):
        frame_fit.fit(np.zeros(5), np.zeros(5), 0.1)
    with pytest.raises(truing.InputError, match="numbers are needed"):
        frame_fit.fit([["a", "b", "c"]], points, 0.1)
    with pytest.raises(truing.InputError, match="transform must be one of none"):
        frame_fit.fit(points, points, 0.1, transform="rigit")
    bad = points.copy()
    bad[3, 1] = np.nan
    with pytest.raises(truing.InputError, match="point pair 4") as caught:
        frame_fit.fit(points, bad, 0.1)
    assert caught.value.index == 3 and caught.value.file is None
    with pytest.raises(truing.InputError):
        frame_fit.fit(points, points, np.zeros((5, 2)))


def wrenches(force_n, at_mm):
    return np.column_stack([force_n, np.cross(at_mm, force_n)])


def test_a_contact_is_located_from_wrenches(draws):
    n, at_mm = 4096, np.array([12.0, -7.0, 30.0])
    force_n = np.column_stack([draws.normal(0.0, 2.0, n), draws.normal(0.0, 2.0, n), -draws.uniform(30.0, 60.0, n)])
    record = wrenches(force_n, at_mm)
    record[:, 3:5] += draws.normal(0.0, 5.0, (n, 2))
    record[:100] = 0.0
    found = ft_center.locate_contact(record, z0_mm=30.0, min_fz_n=5.0)
    assert found.contact_samples == n - 100
    std_mm = np.sqrt(np.diag(found.covariance_mm2))
    assert (abs(found.center_mm - at_mm[:2]) < 5.0 * std_mm).all() and (std_mm < 0.01).all()
    x_mm, y_mm = ft_center.centers(record, z0_mm=30.0, min_fz_n=5.0)
    assert np.isnan(x_mm[:100]).all() and np.isfinite(y_mm[100:]).all()
    assert np.allclose(x_mm[100:], (30.0 * record[100:, 0] - record[100:, 4]) / record[100:, 2])
    with pytest.raises(truing.InputError, match="six columns"):
        ft_center.centers(record[:, :5], z0_mm=30.0, min_fz_n=5.0)


def test_presses_place_the_sensor_and_the_head(draws):
    turn, shift = rotation([0.0, 0.0, 0.4])[:2, :2], np.array([3.0, -2.0])
    places = [(-40.0, -30.0), (40.0, -30.0), (40.0, 30.0), (-40.0, 30.0), (10.0, 5.0)]
    presses = []
    for k, place in enumerate(places):
        real = np.array(place) + ([0.7, -0.4] if k == 4 else [0.0, 0.0])
        at_mm = np.append(turn @ real + shift, 30.0)
        force_n = np.column_stack([draws.normal(0.0, 0.5, (200, 2)), -draws.uniform(38.0, 42.0, 200)])
        record = wrenches(force_n, at_mm)
        record[:, 3:5] += draws.normal(0.0, 2.0, (200, 2))
        use = "locate" if k == 4 else "frame"
        presses.append(ft_center.Press(f"p{k}", use, place, 0.01 * np.arange(200), record))
    located = ft_center.locate(presses, z0_mm=30.0)
    assert located.names == ["p0", "p1", "p2", "p3", "p4"] and not located.opposed
    assert abs(located.angle_rad - 0.4) < 1e-3
    assert abs(located.offset_mm[4] - [0.7, -0.4]).max() < 6.0 * located.std_mm[4].max() < 0.2
    with pytest.raises(truing.NotDeterminedError) as caught:
        ft_center.locate(presses[:1], z0_mm=30.0)
    assert "angle" in caught.value.free_direction


def test_an_axis_is_calibrated_from_ranges(draws):
    origin_mm = np.array([300.0, 200.0, 100.0])
    stations = np.array([[-900.0, -400.0, 50.0], [1500.0, -300.0, 900.0], [200.0, 1600.0, -300.0], [300.0, -900.0, 1400.0]])
    mounts = np.array([[150.0, 0.0, 20.0], [-80.0, 120.0, -30.0], [-60.0, -110.0, 60.0]])
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    errors = np.column_stack(
        [0.004 * np.sin(angles), 0.003 * np.sin(2.0 * angles), 0.002 * (np.cos(angles) - 1.0),
         1e-5 * np.sin(angles), -8e-6 * np.sin(2.0 * angles), 6e-6 * np.sin(angles)]
    )
    rows, dead = [], draws.uniform(200.0, 300.0, (4, 3))
    for k, (angle, error) in enumerate(zip(angles, errors)):
        turn = rotation(error[3:]) if k and abs(error[3:]).max() > 1e-12 else np.eye(3)
        arms = mounts @ (rotation([0.0, angle, 0.0]) if k else np.eye(3)).T
        points = origin_mm + error[:3] + arms @ turn.T
        for s, station in enumerate(stations):
            for m, point in enumerate(points):
                rows.append((s, m, k, np.linalg.norm(point - station) - dead[s, m] + draws.normal(0.0, 3e-4)))
    station, mount, step, displacement = (np.array(column) for column in zip(*rows))
    survey = dict(
        letter="B", origin_mm=origin_mm, direction=[0.0, 1.0, 0.0], stations_mm=stations, mounts_mm=mounts,
        angles_rad=angles, station=station, mount=mount, step=step, displacement_mm=displacement,
    )
    found = tracker_lm.calibrate(**survey, displacement_std_mm=3e-4, station_std_mm=0.01)
    assert found.names == ["EXB", "EYB", "EZB", "EAB", "EBB", "ECB"]
    assert abs(found.variance_factor - 1.0) < 5.0 * np.sqrt(2.0 / found.degrees_of_freedom)
    pulls = (found.errors - errors)[1:] / found.errors_std[1:]
    assert abs(pulls).max() < 5.0
    assert found.residuals_mm.shape == displacement.shape
    one = mount == 0
    of_one = {key: survey[key][one] for key in ("station", "mount", "step", "displacement_mm")}
    with pytest.raises(truing.NotDeterminedError) as caught:
        tracker_lm.calibrate(**{**survey, **of_one, "mounts_mm": mounts[:1]})
    assert "rotation about the line" in caught.value.free_direction
    with pytest.raises(truing.InputError, match="whole number"):
        tracker_lm.calibrate(**{**survey, "station": station * 1.0})
    with pytest.raises(truing.InputError, match="reading 109 refers to index 4 of stations, but there are only 4"):
        tracker_lm.calibrate(**{**survey, "station": np.where(np.arange(station.size) == 108, 4, station)})
    with pytest.raises(truing.InputError, match="^station of reading 1 is -1; indices count from 0$") as caught:
        tracker_lm.calibrate(**{**survey, "station": station - 1})
    assert caught.value.index == 0


def sag_mm(xy):
    return (xy**2).sum(axis=1) / 960.0


def test_a_part_is_located_by_touches(draws):
    part = Surface.asphere(480.0, -1.0, diameter_mm=200.0)
    xy = draws.uniform(-60.0, 60.0, (60, 2))
    on_part = np.column_stack([xy, sag_mm(xy)])
    turn, shift = rotation([2e-3, -1e-3, 0.0]), np.array([0.3, -0.2, 5.0])
    touches = on_part @ turn.T + shift
    fit = pose_icp.locate(part, touches, 1e-3)
    assert np.allclose(fit.matrix[:3, :3], turn, rtol=0.0, atol=2e-6)
    # A paraboloid of revolution shows its axis only together with its height: the surface is what agrees.
    assert abs(fit.residuals_mm).max() < 1e-9
    assert fit.std is not None and fit.std[5] == 0.0
    with pytest.raises(truing.NotDeterminedError) as caught:
        pose_icp.locate(Surface.plane(), np.column_stack([xy, np.zeros(60)]), 1e-3)
    assert "position along x" in caught.value.free_direction
    with pytest.raises(truing.InputError, match="give start"):
        pose_icp.locate(part, touches, 1e-3, hold=["x", "gamma"])
    with pytest.raises(truing.InputError, match="hold must be one of"):
        pose_icp.locate(part, touches, 1e-3, hold=["delta"])
    ball = Surface.sphere(50.0, (1.0, 2.0, 3.0))
    assert "50" in repr(ball)


def test_a_cloud_is_moved_onto_another(draws):
    xy = draws.uniform(-50.0, 50.0, (3000, 2))
    heights = 4.0 * np.sin(xy[:, 0] / 15.0) + 3.0 * np.cos(xy[:, 1] / 11.0) + 0.02 * xy[:, 0] * xy[:, 1] / 10.0
    target = np.column_stack([xy, heights])
    turn, shift = rotation([0.004, -0.003, 0.006]), np.array([0.2, -0.3, 0.1])
    source = (target - shift) @ turn
    found = pose_icp.register(source, target)
    assert np.allclose(found.matrix[:3, :3], turn, rtol=0.0, atol=1e-6)
    assert np.allclose(found.matrix[:3, 3], shift, rtol=0.0, atol=1e-4)
    assert pose_icp.register(source, target, start=found.matrix).iterations <= found.iterations
    with pytest.raises(truing.InputError, match="start must be a rotation"):
        pose_icp.register(source, target, start=2.0 * np.eye(4))
    with pytest.raises(truing.InputError, match="hold must be of"):
        pose_icp.register(source, target, hold=["w"])
    normals = pose_icp.normals(target, viewpoint_mm=(0.0, 0.0, 1e3))
    assert (normals[:, 2] > 0.0).all() and np.allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_touches_are_compensated(draws):
    directions = draws.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    deviation = draws.normal(0.0, 0.01, 500)
    centers = (25.0 + deviation + 3.0)[:, None] * directions
    found = probe_comp.compensate(Surface.sphere(25.0), centers, 1e-3, tip_radius_mm=3.0, approach=-directions)
    assert np.allclose(found.deviation_mm, deviation, rtol=0.0, atol=EXACT_MM)
    assert np.allclose(found.points_mm, centers - 3.0 * directions, rtol=0.0, atol=EXACT_MM)
    assert found.inside_aperture.all() and found.error_mm is None
    # Planned points of no touch are an empty array, not their absence.
    none = np.zeros((0, 3))
    empty = probe_comp.compensate(
        Surface.sphere(25.0), none, 1e-3, tip_radius_mm=3.0, side="against", guide_mm=np.zeros((0, 2))
    )
    assert empty.error_mm is not None and empty.error_mm.shape == (0, 3)
    inside = probe_comp.compensate(
        Surface.sphere(25.0), 22.0 * directions, 1e-3, tip_radius_mm=3.0, side="against", normal="approach",
        approach=directions,
    )
    assert abs(inside.deviation_mm).max() < EXACT_MM
    with pytest.raises(truing.InputError) as caught:
        probe_comp.compensate(Surface.sphere(25.0), centers, 1e-3, tip_radius_mm=3.0, approach=directions)
    assert caught.value.index == 0


def head(**changes):
    geometry = dict(
        tip_to_plane_mm=120.0, plane_to_joint_mm=180.0, head_radius_mm=40.0, bracket_radius_mm=110.0,
        leg_angles_rad=np.radians([90.0, 210.0, 330.0]).tolist(), weight_n=0.0, center_of_gravity_mm=150.0,
    )
    return force_impedance.Head(**{**geometry, **changes})


def test_the_straight_head_without_weight_is_pressed_by_its_axial_cell(draws):
    polishing = head()
    lengths = np.tile(polishing.lengths_mm((0.0, -300.0, 0.0)), (100_000, 1))
    cells = np.zeros((100_000, 4))
    cells[:, 3] = draws.uniform(20.0, 90.0, 100_000)
    normals = np.tile([0.0, 1.0, 0.0], (100_000, 1))
    found = force_impedance.contact_force(polishing, lengths, cells, normals)
    assert np.allclose(found.normal_n, cells[:, 3], rtol=0.0, atol=1e-9)
    assert np.allclose(found.tip_mm, [0.0, -300.0, 0.0], rtol=0.0, atol=1e-9)
    bad = lengths.copy()
    bad[7, 0] = np.nan
    with pytest.raises(truing.InputError, match="sample 8") as caught:
        force_impedance.contact_force(polishing, bad, cells, normals)
    assert caught.value.index == 7
    with pytest.raises(truing.NotDeterminedError) as caught:
        head(leg_angles_rad=[1.0, 1.0, 1.0])
    assert caught.value.free_direction == "a tilt of the head"


def test_the_controller_presses_until_the_force_is_reached(draws):
    polishing, stiffness_n_per_mm, wall_mm = head(), 50.0, -300.05
    controller = force_impedance.Controller(polishing, mass_kg=5.0, damping_ns_per_mm=3.0)
    tip_y_mm, force_n, command = -300.0, 0.0, {}
    for _ in range(6000):
        force_n = max(0.0, stiffness_n_per_mm * (wall_mm - tip_y_mm))
        cells = draws.normal(0.0, 0.01, 4) + [0.0, 0.0, 0.0, force_n]
        lengths = polishing.lengths_mm((0.0, tip_y_mm, 0.0))
        command = controller.update(lengths, cells.tolist(), (0.0, 1.0, 0.0), 20.0, 1e-3)
        tip_y_mm = command["tip_mm"][1]
    assert command["status"] == "controlling" and command["fault"] is None
    # The reading is that of a contact of 50 N/mm to within the noise of a cell.
    assert abs(force_n - 20.0) < 0.5, force_n
    held = controller.update(None, None, (0.0, 1.0, 0.0), 20.0, 1e-3)
    assert held["status"] == "held" and held["fault"] == "NoSample"
