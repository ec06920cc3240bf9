"""Types are there, complete, and those of what is called."""

import subprocess
import sys
from pathlib import Path

import truing

PACKAGE = Path(truing.__file__).parent


def ran(*arguments, folder):
    done = subprocess.run([sys.executable, "-m", *arguments], capture_output=True, text=True, cwd=folder)
    return done.returncode, done.stdout + done.stderr


def test_the_package_is_typed_throughout(tmp_path):
    assert (PACKAGE / "py.typed").is_file()
    code, said = ran("mypy", "--strict", "--ignore-missing-imports", "-p", "truing", folder=tmp_path)
    assert code == 0, said


def test_the_stub_is_that_of_the_native_half(tmp_path):
    code, said = ran("mypy.stubtest", "truing._truing", folder=tmp_path)
    assert code == 0, said


def test_wrong_calls_are_found_by_their_types(tmp_path):
    (tmp_path / "calls.py").write_text(
        "import truing\n"
        "truing.frame_fit.fit([[0.0]], [[0.0]], 0.1, transform='rigit')\n"
        "truing.solve(1.5)\n"
        "truing.solve('case').estimates\n",
        encoding="utf-8",
    )
    code, said = ran("mypy", "--strict", "calls.py", folder=tmp_path)
    assert code == 1 and said.count("error:") == 2, said
