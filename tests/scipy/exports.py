"""exports.py STILLFRAME SCENE EXAMPLES OCTAVE_SCRIPT: exports of a loop and of a log, loaded by scipy and by Octave
with the lines of the examples, compared with what the program says of them, and bit for bit with each other.
Exit code 77 where scipy, Octave or its control package is not installed."""

import contextlib
import csv
import json
import pathlib
import runpy
import shutil
import subprocess
import sys
import tempfile

try:
    import numpy
    import scipy.io
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)


def make_files(stillframe, scene, folder):
    def run(*arguments):
        return subprocess.run([stillframe, *arguments], cwd=folder, check=True, capture_output=True, text=True).stdout

    (folder / "design.json").write_text(run("design", scene, "--mat", "loop.mat", "--json"))
    run("run", scene, "--mode", "single_process", "--loop", "active", "--duration", "3", "--out", "out")
    run("export", "out/active.lcm", "--mat", "run.mat", "--csv", "run.csv")
    return json.loads(run("export", "out/active.lcm", "--csv", "part.csv", "--json", "--from", "1", "--to", "2",
                          "--channels", "frame,sigma:leg_2v"))


def bits(values):
    return numpy.ascontiguousarray(values, dtype=float).view(numpy.uint64)


def assert_same(a, b, place):
    """Two values of .mat files, doubles bit for bit."""
    if isinstance(a, dict):
        assert a.keys() == b.keys(), (place, a.keys(), b.keys())
        for key in a:
            assert_same(a[key], b[key], f"{place}.{key}")
    elif isinstance(a, numpy.ndarray) and a.dtype != object and a.dtype.kind == "f" or isinstance(a, float):
        assert numpy.array_equal(bits(a), bits(b)), place
    else:
        assert numpy.array_equal(a, b), place


def variables(file):
    content = scipy.io.loadmat(file, simplify_cells=True)
    return {name: value for name, value in content.items() if not name.startswith("__")}


def check_models(models, said):
    closed, m = models["closed"], models["loop"]["closed"]
    assert closed.dt == m["Ts"]
    for frequency, expected in zip(said["frequencies_hz"], said["closed_singular_values"]):
        z = numpy.exp(2j * numpy.pi * frequency * closed.dt)
        response = closed.C @ numpy.linalg.solve(z * numpy.eye(len(closed.A)) - closed.A, closed.B) + closed.D
        values = numpy.linalg.svd(response[:, :6], compute_uv=False)
        # Balanced states and values of order one; a sum of thirty terms rounds at 1e-14.
        numpy.testing.assert_allclose(values, expected, rtol=1e-9)
    radius = max(abs(numpy.linalg.eigvals(closed.A)))
    numpy.testing.assert_allclose(radius, said["spectral_radius"], rtol=1e-9)
    names = list(m["input_names"])
    assert len(names) == closed.B.shape[1] and names[6].startswith("sensor_noise:"), names
    poles = [complex(*pole) for pole in said["closed_loop_poles"]]
    continuous = numpy.linalg.eigvals(models["loop"]["loop"]["A"])
    # A pole without leak is double to 1e-5 or so, where rounding costs half of the digits.
    assert all(min(abs(continuous - pole)) < 1e-6 * abs(pole) + 1e-6 for pole in poles)
    law, plant = models["loop"]["law"], models["loop"]["plant"]
    assert law["D"].shape == (6, 6) and plant["Ts"] == 0
    assert numpy.array_equal(models["loop"]["K_P"], numpy.array(said["K_P"]))
    assert numpy.array_equal(models["loop"]["K_I"], numpy.array(said["K_I"]))


def check_signals(signals, part):
    run, table, names = signals["run"], signals["table"], signals["names"]
    wide = numpy.column_stack([run["seq"], run["time_s"], run["floor_acceleration"], run["sigma"], run["applied_force"],
                               run["frame_acceleration"], run["command_force"]])
    assert numpy.array_equal(bits(table), bits(wide))
    assert len(table) == 3001 and numpy.array_equal(run["seq"], numpy.arange(3001))
    assert names[:2] == ["seq", "time_s"], names
    labels = [f"floor:{name} [m/s^2]" for name in run["floor_acceleration_names"]]
    labels += [f"sigma:{name} [N]" for name in run["sigma_names"]]
    assert names[2 : 2 + len(labels)] == labels
    summary = part["files"][0]
    assert summary["n_rows"] == 1001 and summary["first_s"] == 1 and summary["last_s"] == 2
    with open("part.csv", newline="") as file:
        header = next(csv.reader(file))
        rows = numpy.loadtxt(file, delimiter=",", ndmin=2)
    assert [name.split(" [")[0] for name in header[2:]] == [column["name"] for column in summary["columns"]]
    assert header[2] == "sigma:leg_2v [N]" and len(header) == 3 + run["frame_acceleration"].shape[1]
    chosen = numpy.column_stack([run["sigma"][:, list(run["sigma_names"]).index("leg_2v")], run["frame_acceleration"]])
    assert numpy.array_equal(bits(rows[:, 2:]), bits(chosen[1000:2001]))


def check_octave(script, examples):
    octave = shutil.which("octave-cli")
    if octave is None:
        print("skipped: octave-cli")
        sys.exit(77)
    done = subprocess.run([octave, "--quiet", "--no-init-file", script, examples], text=True, stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit(done.returncode)
    assert_same(variables("loop.mat"), variables("loop_back.mat"), "loop")
    assert_same(variables("run.mat"), variables("run_back.mat"), "run")
    table = numpy.loadtxt("run.csv", delimiter=",", skiprows=1)
    assert_same(variables("csv_back.mat")["table"], table, "csv")


def main():
    stillframe, scene, examples, script = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        part = make_files(stillframe, scene, folder)
        with contextlib.chdir(folder):
            said = json.loads((folder / "design.json").read_text())
            check_models(runpy.run_path(f"{examples}/models.py"), said)
            check_signals(runpy.run_path(f"{examples}/signals.py"), part)
            check_octave(script, examples)
    print("all the same")


if __name__ == "__main__":
    main()
