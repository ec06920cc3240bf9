"""Case folders: the answers of the command line, errors with their place, and other threads meanwhile."""

import json
import shutil
import subprocess
import threading
import time

import numpy as np
import pytest
import truing

CASES = ["frame-fit/scale", "ft-center/force-gain", "probe-comp/latency", "pose-icp/published-d-table-4"]


def printed(program, *arguments):
    return subprocess.run([program, *arguments], check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("verb", ["solve", "check"])
def test_the_json_is_that_of_the_command_line(fixtures, program, verb, case):
    folder = str(fixtures / case)
    answer = truing.solve(folder, timing=False) if verb == "solve" else truing.check(folder)
    assert answer.to_json() == printed(program, verb, folder, "--json", "--no-timing")
    assert str(answer) == printed(program, verb, folder, "--no-timing")
    assert answer.to_dict() == json.loads(answer.to_json())


def test_the_loop_names_what_the_command_line_names(fixtures, program, tmp_path):
    folder, page = str(fixtures / "frame-fit" / "scale"), tmp_path / "page.html"
    closed = truing.loop(folder, timing=False, report=page)
    assert closed.to_json() == printed(program, "loop", folder, "--json", "--no-timing")
    assert closed.verdict == "explained" and closed.steps[0].effect == "scale"
    assert closed.steps[0].parameters[0].unit == "ppm"
    assert "<html" in page.read_text(encoding="utf-8")


def test_draws_are_those_of_the_command_line(program, tmp_path):
    truing.init("frame-fit", tmp_path / "case")
    for verb, answer in (("solve", truing.solve), ("loop", truing.loop)):
        drawn = answer(tmp_path / "case", monte_carlo=100, timing=False)
        arguments = (verb, str(tmp_path / "case"), "--monte-carlo", "100", "--json", "--no-timing")
        assert drawn.to_json() == printed(program, *arguments)
        assert drawn.monte_carlo.draws == 100
    with pytest.raises(truing.InputError, match="100 to"):
        truing.solve(tmp_path / "case", monte_carlo=5)


def test_a_plan_is_that_of_the_command_line(program, tmp_path):
    truing.init("probe-comp", tmp_path / "case")
    planned = truing.plan(tmp_path / "case", aim="tip-radius", measurements=6, out=tmp_path / "next")
    arguments = ("plan", str(tmp_path / "case"), "--for", "tip-radius", "--budget", "6")
    assert planned.to_json() == printed(program, *arguments, "--json")
    assert str(planned) == printed(program, *arguments)
    assert 0 < planned.planned <= 6 and (tmp_path / "next" / "touches.csv").is_file()
    assert "tip-radius" in planned._repr_html_()
    with pytest.raises(truing.InputError, match="not both"):
        truing.plan(tmp_path / "case", measurements=6, minutes=10.0)


def test_a_machine_is_closed_as_on_the_command_line(fixtures, program, tmp_path):
    listed = [("probe-comp", "axis-scale"), ("pose-icp", "nothing-white")]
    for kind, case in listed:
        shutil.copytree(fixtures / kind / case, tmp_path / kind)
    toml = "".join(f'[[case]]\nfolder = "{kind}"\n' for kind, _ in listed)
    (tmp_path / "machine.toml").write_text(f'name = "mill"\n{toml}', encoding="utf-8")
    closed = truing.machine(tmp_path)
    assert closed.to_json() == printed(program, "loop", str(tmp_path), "--json")
    assert str(closed) == printed(program, "loop", str(tmp_path))
    assert [case.case for case in closed.cases] == ["probe-comp", "pose-icp"]
    assert closed.verdict in closed._repr_html_()
    with pytest.raises(truing.InputError, match="machine.toml"):
        truing.machine(tmp_path / "pose-icp")


def test_depths_are_those_of_the_command_line(program, tmp_path):
    case, nc = tmp_path / "case", tmp_path / "part.ngc"
    truing.init("pose-icp", case)
    with (case / "case.toml").open("a", encoding="utf-8") as settings:
        settings.write("\n[tool]\nfilm_mm = 2.0\n")
    nc.write_text("G21 G90\nG1 X0 Y0 Z1 F100\nG1 X1\n", encoding="utf-8")
    depth = truing.depth(case, nc, planned=[0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    arguments = ("depth", str(case), str(nc), "--planned", "0,0,0.1,0,0,0")
    assert depth.to_json() == printed(program, *arguments, "--json")
    assert str(depth) == printed(program, *arguments)
    assert "largest" in depth._repr_html_()
    with pytest.raises(truing.InputError, match="a pose has six"):
        truing.depth(case, nc, planned=[0.0, 0.0])


def test_effects_are_carried_to_the_next_case(fixtures, tmp_path):
    first, learnt = fixtures / "pose-icp" / "measured-mirror-1", tmp_path / "first.json"
    learnt.write_text(truing.loop(first).to_json(), encoding="utf-8")
    closed = truing.loop(fixtures / "pose-icp" / "measured-mirror-1-next-session", carry=learnt)
    assert closed.carried is not None


def test_a_report_never_overwrites_the_case(tmp_path):
    truing.init("frame-fit", tmp_path / "case")
    with pytest.raises(truing.InputError) as caught:
        truing.solve(tmp_path / "case", report=tmp_path / "case" / "pairs.csv")
    assert caught.value.file == str(tmp_path / "case" / "pairs.csv")


def test_bad_cells_are_named_by_file_line_and_column(tmp_path):
    truing.init("frame-fit", tmp_path / "case")
    table = tmp_path / "case" / "pairs.csv"
    lines = table.read_text(encoding="utf-8").splitlines()
    header = next(i for i, line in enumerate(lines) if not line.startswith("#"))
    cells = lines[header + 1].split(",")
    cells[1] = "a lot"
    lines[header + 1] = ",".join(cells)
    table.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(truing.InputError) as caught:
        truing.solve(tmp_path / "case")
    error = caught.value
    assert error.file == str(table) and (error.line, error.column) == (header + 2, 2)
    assert error.name == lines[header].split(",")[1].strip() and error.free_direction is None
    assert isinstance(error, ValueError) and str(table) in str(error)


def test_what_the_data_leave_free_is_named():
    line = np.linspace(0.0, 300.0, 7)
    flat = np.zeros(7)
    pairs = {
        "point": [f"p{i}" for i in range(7)],
        "from_x_mm": line, "from_y_mm": flat, "from_z_mm": flat,
        "to_x_mm": line, "to_y_mm": flat, "to_z_mm": flat,
    }
    case = truing.Case("frame-fit", {"pairs": pairs}, {"noise": {"point_mm": 0.01}})
    with pytest.raises(truing.NotDeterminedError) as caught:
        truing.solve(case)
    assert "rotation about the line" in caught.value.free_direction
    assert caught.value.file.endswith("pairs.csv")


def test_answers_show_themselves_and_escape_what_files_say(fixtures, tmp_path):
    closed = truing.loop(fixtures / "frame-fit" / "scale")
    page = closed._repr_html_()
    assert "explained" in page and "scale" in page and "ppm" in page
    assert "χ²" in truing.solve(fixtures / "frame-fit" / "scale")._repr_html_()
    assert "frame-fit" in repr(closed) and "steps" in dir(closed)
    closed.warnings.append("<script>")
    assert "<script>" not in closed._repr_html_()
    with pytest.raises(AttributeError, match="no 'verdikt'"):
        _ = closed.verdikt


def test_other_threads_run_while_a_loop_is_closed(fixtures):
    worker = threading.Thread(target=truing.loop, args=(fixtures / "tracker-lm" / "targets-stand",))
    worker.start()
    turns = 0
    while worker.is_alive():
        time.sleep(1e-3)
        turns += 1
    # One turn before the call and one after it are there also where the interpreter is held.
    assert turns > 10


def test_a_case_in_memory_is_the_case_in_a_folder(fixtures, tmp_path):
    truing.init("frame-fit", tmp_path / "case")
    pairs = (tmp_path / "case" / "pairs.csv").read_text(encoding="utf-8")
    rows = [line.split(",") for line in pairs.splitlines() if line and not line.startswith("#")]
    names = [name.strip() for name in rows[0]]
    columns = {name: [row[k].strip() for row in rows[1:]] for k, name in enumerate(names)}
    case = truing.Case("frame-fit", {"pairs": columns}, {"noise": {"point_mm": 0.02}})
    case.write(tmp_path / "again")
    assert truing.solve(case).estimates == truing.solve(tmp_path / "again").estimates
    with pytest.raises(FileExistsError):
        case.write(tmp_path / "again")


def test_settings_of_every_kind_are_written():
    settings = {
        "kind": "x", "flag": True, "list": [1, 2.5, "a\"b"], "array": np.array([1.0, 2.0]), "odd key": 1,
        "pose": {"initial": {"x_mm": 1.0}},
    }
    assert truing.case.toml(settings).splitlines() == [
        'kind = "x"', "flag = true", 'list = [1, 2.5, "a\\"b"]', "array = [1.0, 2.0]", '"odd key" = 1',
        "[pose]", "initial = { x_mm = 1.0 }",
    ]
    with pytest.raises(TypeError):
        truing.case.toml({"bad": object()})
