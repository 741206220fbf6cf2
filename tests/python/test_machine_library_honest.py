"""The library on the honest plant: its errors scaled to a machine, and what is printed where identify does not end."""

from studies import honest_drive
from studies.machine_library import honest as machine_library_honest
from studies.machine_library.points import cells, points, read_library, sensor_settings

TRIP = 50.0


def test_errors_are_those_of_the_file_scaled_to_the_machine() -> None:
    machine = read_library()[0]
    of_file = honest_drive.plant_settings()
    configuration = {"protection.over_current_a": TRIP, "control.flux_reference_wb": 0.55}
    found = machine_library_honest.plant(machine, 125, configuration)
    for key, by in (
        ("plant.saturation.knee_wb", 0.55 / 1.1),
        ("plant.saturation.machine_flux_wb", 0.55 / 1.1),
        ("plant.sensors.current.noise_a", TRIP / 250),
        ("plant.sensors.current.phase_a.offset_a", TRIP / 250),
        ("plant.sensors.current.phase_b.gain_error", 1),
        ("plant.sensors.current.bits", 1),
        ("plant.sensors.voltage.range_v", machine.u_dc / 530),
        ("plant.inverter.threshold_v", 1),
        ("plant.inverter.slope_ohm", 250 / TRIP),
    ):
        assert abs(found[key] - by * of_file[key]) < 1e-12, key
    assert found["plant.sensors.current.range_a"] > TRIP
    assert set(of_file) <= set(found)
    assert found["plant.inverter.dead_time_us"] == 3
    assert machine_library_honest.plant(machine, 50, configuration)["plant.inverter.dead_time_us"] == 1.5


def test_points_of_a_cell_do_not_depend_on_the_other_cells() -> None:
    library = read_library()
    some = points(cells(library[:1], ["foc"], [125], machine_library_honest.SENSORS), 1, 3)
    more = points(cells(library, ["foc", "dtc"], [50, 125], machine_library_honest.SENSORS), 1, 3)
    assert len(some) == 3
    assert set(some) <= set(more)
    assert len(more) == len(library) * 2 * 2 * 3
    assert all(sensor_settings(point.cell.sensors, TRIP, 530) == {} for point in more), "the plant has its own"
