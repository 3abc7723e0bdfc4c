"""What is built for others to install works where there is no repository."""

import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
UV = ROOT / ".uv/bin/uv"


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_the_wheel_works_away_from_the_repository_and_without_physics(tmp_path):
    def run(*command):
        return subprocess.run(
            [str(word) for word in command], cwd=tmp_path, capture_output=True, text=True
        )

    built = run(UV, "build", "--quiet", "--wheel", "--out-dir", tmp_path, ROOT)
    assert built.returncode == 0, built.stderr
    (wheel,) = tmp_path.glob("*.whl")
    venv.create(tmp_path / "there")
    there = tmp_path / "there/bin"
    installed = run(
        UV, "pip", "install", "--quiet", "--python", there / "python",
        "--constraint", ROOT / "constraints.txt", wheel,
    )  # fmt: skip
    assert installed.returncode == 0, installed.stderr

    where = run(there / "python", "-c", "import cairn; print(cairn.__file__)").stdout
    assert where.startswith(str(tmp_path)), where
    assert sys.prefix not in where
    assert run(there / "cairn", "doctor").returncode == 0
    quick = run(there / "cairn", "run", "quick")
    assert quick.returncode == 0, quick.stderr
    assert (tmp_path / "runs/quick/picture.png").is_file()
    for name in ("office", "warehouse"):
        script = f"import cairn; print(cairn.maps.load('{name}').name)"
        assert run(there / "python", "-c", script).stdout.strip() == name
    office = run(there / "cairn", "run", "office")
    assert office.returncode == 2
    assert 'pip install "cairn-nav[sim]"' in office.stderr
