#!/usr/bin/env python3
"""The Python module against the JSON of the programs. Arguments: the program stillframe, the source folder. Skipped
(exit code 77) without numpy."""

import collections.abc
import contextlib
import copy
import importlib.util
import inspect
import io
import json
import os
import pathlib
import pydoc
import subprocess
import sys
import tempfile
import typing
import unittest
import unittest.mock
import warnings

try:
    import numpy as np
except ImportError:
    print("numpy is not installed")
    sys.exit(77)

PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
os.environ["STILLFRAME"] = PROGRAM
sys.path.insert(0, str(SOURCE / "python"))
import stillframe as sf  # noqa: E402
from stillframe import _documents  # noqa: E402
from stillframe._documents import document  # noqa: E402

SCENES = SOURCE / "config/scenes"

LEG = {
    "title": "One leg",
    "nodes": {"floor": {"position": [0, 0, 0]}, "mass": {"position": [0, 0, 1]}},
    "masses": [{"node": "mass", "mass": 400}],
    "elements": {"leg": {"type": "truss", "nodes": ["floor", "mass"], "stiffness": 4e6}},
    "supports": [{"nodes": ["mass", "floor"], "fix": ["x", "y"]}],
    "prescribed": [{"nodes": ["floor"], "move": ["z"]}],
    "dofs": [{"element": "leg"}],
    "inputs": [{"name": "floor", "acceleration": "floor", "along": "z"}],
    "outputs": [{"name": "mass", "acceleration": "mass", "along": "z"}],
    "controller": {
        "legs": ["leg"], "target_hz": 5, "damping_ratio": 0.7, "sample_rate_hz": 1000, "delay_samples": 1, "leak_hz": 0.05,
        "lead_samples": 1,
    },
    "monitors": [{"name": "floor_z", "acceleration": "floor", "along": "z"}],
    "compare": {"z": {"floor": "floor_z", "frame": "mass"}},
    "floor": {"noise": {"vc": "D", "axes": ["z"], "high_pass_hz": 0.5, "duration_s": 12}},
}


def said(*arguments, codes=(0,)):
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], capture_output=True, check=False)
    assert done.returncode in codes, done.stderr
    return json.loads(done.stdout)


def numbers(value):
    """Every number of a document in order, by its bits; null is NaN as it is inside arrays."""
    if isinstance(value, np.ndarray):
        return numbers(np.stack([value.real, value.imag], -1).tolist() if np.iscomplexobj(value) else value.tolist())
    if isinstance(value, collections.abc.Mapping):
        return [n for v in value.values() for n in numbers(v)]
    if isinstance(value, (list, tuple)):
        return [n for v in value for n in numbers(v)]
    if value is None or value != value:
        return ["none"]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return []
    return [float(value).hex()]


class SameBits(unittest.TestCase):
    """Ten scenes, each verb that they have."""

    def same(self, found, expected):
        self.assertEqual(numbers(found), numbers(expected))
        self.assertGreater(len(numbers(found)), 0)

    def test_of_the_programs(self):
        n = 0
        for name in ("cart", "cantilever", "metrology_frame", "frame_flexible", "spinning_arm", "slider_crank",
                     "turning_table", "rotating_cantilever", "frame_under_gravity", "leaf_spring_guide", "euler_column"):
            path = SCENES / f"{name}.yaml"
            scene = sf.Scene(path)
            for verb in ("modes", "equilibrium", "linearise"):
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    try:
                        found = getattr(scene, verb)()
                    except (sf.Refusal, sf.InputError) as error:
                        code = subprocess.run([PROGRAM, verb, str(path)], capture_output=True, check=False).returncode
                        self.assertEqual(code, error.exit_code)
                        continue
                self.same(found, said(verb, path))
                n += 1
        self.assertGreaterEqual(n, 27)
        frame = SCENES / "metrology_frame.yaml"
        self.same(sf.Scene(frame).design(), said("design", frame))
        self.same(sf.Scene(frame).sigma(points=9), said("sigma", frame, "--points", 9))
        self.same(sf.Scene(SCENES / "euler_column.yaml").buckling(count=2), said("buckling", SCENES / "euler_column.yaml", "--count", 2))

    def test_a_scene_is_the_same_as_file_text_and_dict(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "leg.yaml"
            path.write_text(json.dumps(LEG))
            of_file = sf.Scene(path).design()
        self.same(sf.Scene(LEG).design(), of_file)
        self.same(sf.Scene(json.dumps(LEG, indent=1)).design(), of_file)
        own = {k: v for k, v in LEG.items() if k != "controller"}
        self.same(sf.Scene(own).design(controller=LEG["controller"]), of_file)


class Arrays(unittest.TestCase):
    def test_shapes_and_kinds(self):
        linear = sf.Scene(SCENES / "metrology_frame.yaml").linearise()
        n = len(linear.states)
        self.assertEqual(linear.A.shape, (n, n))
        self.assertEqual(linear.C.shape, (len(linear.outputs), n))
        self.assertEqual(linear.B.shape[1], linear.D.shape[1])
        self.assertEqual(linear.second_order.M.shape, (n // 2, n // 2))
        self.assertLess(np.abs(linear.second_order.M - linear.second_order.M.T).max(), 1e-12 * np.abs(linear.second_order.M).max())
        modes = sf.Scene(SCENES / "cart.yaml").modes()
        self.assertTrue(np.iscomplexobj(modes.eigenvalues))
        self.assertAlmostEqual(modes.eigenvalues[0], -1 + 1j * 19.974984355438178, 12)
        # The eigenvalues of A are those of `modes`, by numpy.
        poles = np.sort_complex(np.linalg.eigvals(sf.Scene(SCENES / "cart.yaml").linearise().A))
        self.assertLess(np.abs(poles - np.sort_complex(modes.eigenvalues)).max(), 1e-11 * 20)

    def test_loops_are_systems_of_scipy(self):
        from scipy import signal

        design = sf.Scene(LEG).design()
        closed = design.loops()["closed"]
        system = signal.StateSpace(np.atleast_2d(closed.A), closed.B, closed.C, closed.D, dt=closed.Ts)
        self.assertAlmostEqual(np.abs(system.poles).max(), design.spectral_radius, 9)
        self.assertEqual(sf.Scene(LEG).linearise().to_scipy().A.shape, (2, 2))

    def test_null_is_nan_inside_arrays(self):
        with self.assertWarnsRegex(UserWarning, "delay_samples=-1"):
            found = sf.Scene(LEG).sweep({"controller.delay_samples": [-1, 1]}, at=[20, 600])
        self.assertTrue(np.isnan(found.columns.spectral_radius[0]))
        self.assertLess(found.columns.spectral_radius[1], 1)
        self.assertTrue(np.isnan(found.columns["transmission_600_hz"]).all(), "above half the rate")

    def test_objects_print_themselves(self):
        linear = sf.Scene(LEG).linearise()
        self.assertIn("state_space", repr(linear))
        self.assertIn("<table>", linear._repr_html_())
        self.assertIn("second_order", dir(linear))
        with self.assertRaisesRegex(AttributeError, "no key 'E'"):
            linear.E


class Keys(unittest.TestCase):
    """Of documents."""

    def test_win_over_methods(self):
        found = sf.Document(values=3, items=4, pop=5)
        self.assertEqual((found.values, found.items, found.pop), (3, 4, 5))
        self.assertEqual(vars(found), {"values": 3, "items": 4, "pop": 5})

    def test_are_those_of_a_dict(self):
        found = sf.Scene(LEG).modes()
        self.assertEqual(list(found.keys()), list(found))
        self.assertEqual(dict(found).keys(), vars(found).keys())
        self.assertIs(found.get("nothing"), None)
        self.assertIn("dofs", found)
        self.assertEqual(len(found), len(found.items()))
        self.assertEqual(copy.copy(found), found)

    def test_of_a_document_make_a_block(self):
        block = sf.Document(LEG["controller"])
        self.assertEqual(sf.Scene(LEG).design(controller=block).target_hz, 5)


class Kinds(unittest.TestCase):
    """Of arrays, whatever is in them."""

    def test_null_alone_is_nan(self):
        found = document({"third_octaves_m_s": [[None, None]]}, sf.Document).third_octaves_m_s
        self.assertEqual((found.dtype, found.shape), (float, (1, 2)))
        self.assertTrue(np.isnan(found).all())

    def test_pairs_are_complex(self):
        found = document({"T": [[[[1, -2]]], [[[None, None]]]]}, sf.Document).T
        self.assertEqual(found.shape, (2, 1, 1))
        self.assertEqual(found[0, 0, 0], 1 - 2j)
        self.assertTrue(np.isnan(found[1, 0, 0]))

    def test_counts_are_whole(self):
        found = sf.Scene(LEG).robustness(samples=8, uncertainty={"stiffness": 0.1}, no_search=True)
        self.assertEqual(found.histograms.peak_db.counts.dtype, int)
        self.assertEqual(found.shards.done.dtype, int)

    def test_empty_lists_are_arrays_if_of_numbers(self):
        found = document({"Y_p": [], "B": [[], []], "warnings": []}, sf.Document)
        self.assertEqual((found.Y_p.dtype, found.Y_p.shape, found.B.shape), (float, (0,), (2, 0)))
        self.assertEqual(found.warnings, [])

    def test_are_those_of_the_schemas(self):
        texts, pairs, whole = set(), set(), set()

        def leaves(schema, defs):
            """Of an array: kinds of what is in it at the bottom."""
            schema = defs[schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else schema
            if "prefixItems" in schema and schema["prefixItems"][0].get("$comment") == "real part":
                return {"pair"}
            parts = schema.get("prefixItems", schema.get("anyOf", [schema["items"]] if schema.get("items") else []))
            kinds = {schema["type"]} if isinstance(schema.get("type"), str) else {*schema.get("type", ())}
            return (kinds - {"array"}).union(*(leaves(part, defs) for part in parts))

        def arrays(schema, defs):
            schema = defs[schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else schema
            return "array" in schema.get("type", ()) or any(arrays(part, defs) for part in schema.get("anyOf", ()))

        def walk(schema, defs):
            for key, value in schema.get("properties", {}).items() if isinstance(schema, dict) else ():
                if arrays(value, defs):
                    kinds = leaves(value, defs)
                    for name, found in (("string", texts), ("object", texts), ("pair", pairs), ("integer", whole)):
                        if name in kinds:
                            found.add(key)
            for part in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
                walk(part, defs)

        for verb in ("modes", "equilibrium", "buckling", "linearise", "sigma", "design", "sweep", "feedback", "budget",
                     "robustness", "verdict", "identify", "export"):
            schema = json.loads((SOURCE / f"docs/json/{verb}.schema.json").read_text(encoding="utf-8"))
            walk(schema, schema.get("$defs", {}))
        self.assertEqual((_documents._lists, _documents._complex, _documents._whole), (texts, pairs, whole))


class Given(unittest.TestCase):
    """What scenes and blocks may be made of."""

    def test_arrays_and_scalars_of_numpy(self):
        nodes = {"floor": {"position": np.zeros(3)}, "mass": {"position": (0, np.float32(0), np.int64(1))}}
        self.assertEqual(numbers(sf.Scene(dict(LEG, nodes=nodes)).modes()), numbers(sf.Scene(LEG).modes()))

    def test_what_cannot_be_written_is_named(self):
        for value in (1j, {4}):
            with self.assertRaisesRegex(sf.InputError, "complex|set") as caught:
                sf.Scene(dict(LEG, masses=[{"node": "mass", "mass": value}]))
            self.assertEqual((caught.exception.file, caught.exception.key), ("<scene>", "masses[1].mass"))

    def test_a_scene_of_a_scene(self):
        self.assertEqual(sf.Scene(sf.Scene(LEG)).text, sf.Scene(LEG).text)

    def test_what_is_no_scene(self):
        for source in (None, [1], 3):
            with self.assertRaisesRegex(sf.InputError, "allowed is a path"):
                sf.Scene(source)
        with self.assertRaisesRegex(sf.InputError, "<controller>: found list"):
            sf.Scene(LEG).design(controller=[1])

    def test_a_design_scene_as_a_dict(self):
        found = sf.Scene(LEG).design(design_scene=LEG)
        np.testing.assert_array_equal(found.K_P, sf.Scene(LEG).design().K_P)

    def test_a_block_finds_files_beside_the_scene(self):
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "law.yaml").write_text("x: 1\n")
            with self.assertRaises(sf.InputError) as caught:
                sf.Scene(LEG, folder).design(controller=dict(LEG["controller"], law="law.yaml"))
        self.assertNotIn("cannot be read", caught.exception.message)


class Systems(unittest.TestCase):
    def test_integrated_inputs_have_the_response_of_sigma(self):
        scene = sf.Scene({k: v for k, v in LEG.items() if k not in ("controller", "floor")})
        expected = scene.sigma(from_hz=1, to_hz=40, points=7)
        system = scene.linearise().to_scipy(integrate=True)
        self.assertEqual(system.B.shape, (4, 1))
        for hz, values in zip(expected.frequencies_hz, expected.singular_values):
            found = system.C @ np.linalg.solve(2j * np.pi * hz * np.eye(4) - system.A, system.B) + system.D
            self.assertAlmostEqual(abs(found[0, 0]) / values[0], 1, 9)

    def test_direct_inputs_stay_beside_them(self):
        linear = sf.Scene(SCENES / "slider_crank.yaml").linearise()
        system = linear.to_scipy(integrate=True)
        n = len(linear.states)
        self.assertEqual(system.B.shape, (n + 2, 2))
        np.testing.assert_array_equal(system.B[:n, 1], linear.B[:, 3])

    def test_without_inputs_are_refused_in_words(self):
        bare = {k: v for k, v in LEG.items() if k not in ("inputs", "outputs", "monitors", "compare", "controller", "floor")}
        linear = sf.Scene(bare).linearise()
        self.assertEqual((linear.B.shape, linear.C.shape, linear.D.shape), ((2, 0), (0, 2), (0, 0)))
        with self.assertRaisesRegex(sf.InputError, "no inputs"):
            linear.to_scipy()


class Help(unittest.TestCase):
    def said(self, *arguments):
        with contextlib.redirect_stdout(io.StringIO()) as said:
            sf.help(*arguments)
        return said.getvalue()

    def test_of_options_that_docstrings_name(self):
        for function in (sf.identify, sf.Scene.feedback, sf.Scene.budget, sf.Scene.robustness):
            self.assertIn(f'stillframe.help("{function.__name__}")', function.__doc__)
            self.assertIn("--json", self.said(function.__name__))

    def test_of_a_scene(self):
        self.assertIn("# The scene file", self.said("scene"))

    def test_of_no_verb(self):
        for word in ("modse", 3):
            with self.assertRaisesRegex(sf.InputError, "no verb .*modes"):
                sf.help(word)

    def test_is_not_about_dicts(self):
        text = pydoc.plain(pydoc.render_doc(sf))
        self.assertNotIn("builtins.dict", text)
        self.assertLess(len(text.splitlines()), 1000)


class Sweeps(unittest.TestCase):
    def test_columns_are_the_designs(self):
        found = sf.Scene(LEG).sweep({"controller.target_hz": [4, 6.5], "masses.mass.mass": "300:500:3"}, at=[20])
        self.assertEqual(found.n_points, 6)
        self.assertEqual(found.columns["masses.mass.mass"].tolist(), [300, 400, 500] * 2)
        other = json.loads(json.dumps(LEG))
        other["controller"]["target_hz"], other["masses"][0]["mass"] = 6.5, 500
        design = sf.Scene(other).design()
        self.assertEqual(found.columns.disk_margin[5], design.margins.all_disk)


    def test_one_frequency_is_no_list(self):
        found = sf.Scene(LEG).sweep({"controller.target_hz": [4]}, at=10)
        self.assertLess(found.columns.transmission_10_hz[0], 1)


class Runs(unittest.TestCase):
    def test_a_run_and_its_log(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "run"
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                run = sf.Scene(LEG).run(out, duration=12)
            self.assertEqual(run.verdict.checks[0].outcome, "passed")
            active, passive = run.active, run.passive
            self.assertEqual(active.sigma.shape, (12001, 1))
            self.assertEqual(active.names["sigma"], ["leg"])
            self.assertEqual(active.info.n_lost, 0)
            self.assertEqual(active.time_s[-1], 12)
            # It isolates: above the target the frame moves less than it does passive.
            quiet, loud = (np.sqrt(np.mean(log.frame_acceleration[2000:] ** 2)) for log in (active, passive))
            self.assertLess(quiet, 0.5 * loud)
            part = sf.read_log(out / "active.lcm", from_s=1, to_s=2, channels=["floor", "frame:mass"])
            self.assertEqual(part.floor_acceleration.shape, (1001, 1))
            self.assertEqual(part.floor_acceleration[0], active.floor_acceleration[1000])
            self.assertNotIn("sigma", part)
            again = sf.read_run(out)
            self.assertEqual(numbers(again.verdict), numbers(run.verdict))
            with self.assertRaises(sf.InputError):
                sf.Scene(LEG).run(out)  # is there already


class Logs(unittest.TestCase):
    # What is limited moves otherwise than what is linear.
    scene = sf.Scene(dict(LEG, controller=dict(LEG["controller"], force_limit_n=1e-3)))

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.log = cls.run_of("run", 4)

    @classmethod
    def run_of(cls, name, duration):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return cls.scene.run(cls.folder / name, loop="active", duration=duration).folder / "active.lcm"

    def test_one_channel_is_no_list(self):
        self.assertEqual([*sf.read_log(self.log, channels="sigma").names], ["sigma"])

    def test_say_nothing_of_the_file_between(self):
        self.assertFalse({"file", "format", "bytes"} & {*sf.read_log(self.log).info})

    def test_have_their_signals_named(self):
        with self.assertRaisesRegex(sf.InputError, "did you mean 'sigma'"):
            sf.read_log(self.log).plot("sgma")

    def test_that_are_read_are_no_path(self):
        with self.assertRaisesRegex(sf.InputError, "identify: found Log"):
            sf.identify(sf.read_log(self.log))

    def test_off_the_prediction_are_warned_of(self):
        with self.assertWarnsRegex(UserWarning, "identify: matrix: measured .* dB outside"):
            sf.identify(self.log, tolerance_db=0.1)

    def test_off_the_budget_are_warned_of_where_it_was_asked(self):
        with self.assertWarnsRegex(UserWarning, "budget: .*active.lcm: z: measured") as caught:
            self.scene.budget(log=self.log)
        self.assertEqual(caught.filename, __file__)

    def test_too_short_to_identify_are_warned_of(self):
        with self.assertWarnsRegex(UserWarning, "identify: matrix is not identified: the log has 0.02 s"):
            sf.identify(self.run_of("short", 0.02))


class Package(unittest.TestCase):
    def test_has_the_version_of_the_programs(self):
        project = (SOURCE / "python/pyproject.toml").read_text(encoding="utf-8")
        self.assertIn(f'version = "{sf.version()}"', project)

    def test_the_example_comes_to_a_verdict(self):
        path = os.environ | {"PYTHONPATH": str(SOURCE / "python")}
        command = [sys.executable, str(SOURCE / "examples/python/frame.py")]
        done = subprocess.run(command, env=path, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("\npassed\n", done.stdout)


def public():
    """(name, function) of all that `stillframe` shows, methods and properties of its classes among it."""
    for name in sf.__all__:
        thing = getattr(sf, name)
        if not inspect.isclass(thing):
            yield name, thing
            continue
        for member, value in vars(thing).items():
            value = value.fget if isinstance(value, property) else value
            if inspect.isfunction(value) and (member == "__init__" or not member.startswith("_")):
                yield f"{name}.{member}", value


class Annotations(unittest.TestCase):
    def test_are_complete_and_can_be_looked_up(self):
        self.assertGreater(len(list(public())), 30)
        for name, function in public():
            with self.subTest(name):
                hints = typing.get_type_hints(function)
                self.assertEqual({*inspect.signature(function).parameters} - {"self"}, {*hints} - {"return"})
                self.assertIn("return", hints)
        for name in sf.__all__:
            if inspect.isclass(getattr(sf, name)):
                typing.get_type_hints(getattr(sf, name))

    def test_docstrings_of_numbers_name_units_or_shapes(self):
        n = 0
        for name, function in public():
            if name.endswith("__init__"):
                continue
            with self.subTest(name):
                self.assertTrue(function.__doc__)
                kinds = typing.get_args(typing.get_type_hints(function)["return"]) or (typing.get_type_hints(function)["return"],)
                if any(kind is np.ndarray or (inspect.isclass(kind) and issubclass(kind, (sf.Document, np.generic))) for kind in kinds):
                    n += 1
                    self.assertRegex(function.__doc__, r"\b(m/s\^2|rad/s|Hz|1/s|dB|N|m|s|1)\b|\w x \w")
        self.assertGreaterEqual(n, 17)

    def test_declared_keys_are_there(self):
        scene = sf.Scene(LEG)
        for found in (scene.modes(), scene.linearise(), scene.design(), scene.sigma(points=3)):
            for key in set(typing.get_type_hints(type(found))) - {"_made_by"}:
                with self.subTest(type(found).__name__ + "." + key):
                    self.assertIn(key, found)

    def test_mypy_finds_nothing(self):
        self.assertTrue((SOURCE / "python/stillframe/py.typed").exists())
        if importlib.util.find_spec("mypy") is None:
            self.skipTest("mypy is not installed")
        with tempfile.TemporaryDirectory() as cache:
            use = pathlib.Path(cache) / "use.py"
            use.write_text("import stillframe as sf\nrun = sf.Scene('a.yaml').run('out', duration=1.5)\n"
                           "reveal_type(run.active)\nreveal_type(sf.Scene('a.yaml').linearise().A)\nsf.Scene(3)\n")
            mypy = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--cache-dir", cache]
            done = subprocess.run([*mypy, str(SOURCE / "python/stillframe")], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout)
            seen = subprocess.run([*mypy, str(use)], env=os.environ | {"MYPYPATH": str(SOURCE / "python")}, capture_output=True,
                                  text=True, check=False)
        self.assertRegex(seen.stdout, "use.py:3: note: .*Log")
        self.assertRegex(seen.stdout, "use.py:4: note: .*ndarray")
        self.assertRegex(seen.stdout, "use.py:5: error: .*incompatible type")
        self.assertEqual(seen.stdout.count("error:"), 1, seen.stdout)


class Pictures(unittest.TestCase):
    def setUp(self):
        try:
            import matplotlib
        except ImportError:
            self.skipTest("matplotlib is not installed")
        matplotlib.use("Agg")

    def test_show_the_numbers(self):
        found = sf.Scene(LEG).sigma(points=9)
        lines = found.plot().lines
        self.assertEqual(len(lines), 2)
        for line, values in zip(lines, (found.singular_values, found.closed_singular_values)):
            np.testing.assert_array_equal(line.get_xdata(), found.frequencies_hz)
            np.testing.assert_allclose(10 ** (line.get_ydata() / 20), values[:, 0], rtol=1e-12)
        found = sf.Scene({k: v for k, v in LEG.items() if k != "controller"}).sigma(points=9)
        self.assertEqual([line.get_label() for line in found.plot().lines], ["open"])

    def run_notebook(self, name):
        """The outputs of a notebook, run in a folder of its own."""
        try:
            import ipykernel  # noqa: F401
            import nbformat
            from nbconvert.preprocessors import ExecutePreprocessor
        except ImportError:
            self.skipTest("nbconvert and ipykernel are not installed")
        notebook = nbformat.read(SOURCE / "examples/notebooks" / name, as_version=4)
        self.assertEqual([cell.outputs for cell in notebook.cells if cell.cell_type == "code" and cell.outputs], [])
        own = {"PYTHONPATH": str(SOURCE / "python"), "STILLFRAME_SOURCE": str(SOURCE)}
        with unittest.mock.patch.dict(os.environ, own), tempfile.TemporaryDirectory() as folder:
            ExecutePreprocessor(timeout=600, kernel_name="python3").preprocess(notebook, {"metadata": {"path": folder}})
        return [out for cell in notebook.cells if cell.cell_type == "code" for out in cell.outputs]

    def test_the_notebook_runs_as_it_stands(self):
        kinds = [kind for out in self.run_notebook("frame.ipynb") for kind in out.get("data", {})]
        self.assertEqual(kinds.count("image/png"), 2)

    def test_an_h_infinity_law_against_the_pi(self):
        if subprocess.run(["octave-cli", "-qf", "--eval", "pkg load control"], capture_output=True, check=False).returncode != 0:
            self.skipTest("Octave has no control package")
        outputs = self.run_notebook("h_infinity.ipynb")
        self.assertEqual([kind for out in outputs for kind in out.get("data", {})].count("image/png"), 1)
        said = "".join(out.get("text", "") for out in outputs)
        print(said[said.index("H-infinity against"):])
        self.assertEqual(said.count("better:"), 2)
        self.assertEqual(said.count("worse:"), 2)


class Errors(unittest.TestCase):
    def test_name_file_line_and_key(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bad.yaml"
            path.write_text("title: x\nnodes:\n  a: {position: [0, 0, up]}\n")
            with self.assertRaises(sf.InputError) as caught:
                sf.Scene(path).modes()
        error = caught.exception
        self.assertEqual((error.file, error.line, error.exit_code), (str(path), 3, 2))
        self.assertIn("position", error.key)
        self.assertIn("allowed", error.message)

    def test_of_a_dict_name_no_file_of_ours(self):
        bad = dict(LEG, masses=[{"node": "mass", "mass": -1}])
        before = set(os.listdir("."))
        with self.assertRaises(sf.InputError) as caught:
            sf.Scene(bad).modes()
        self.assertEqual(caught.exception.file, "<scene>")
        self.assertEqual(set(os.listdir(".")), before)

    def test_of_blocks_name_no_file_of_ours(self):
        for name, block in (("controller", {"target": 1}), ("floor", {"nose": 1}), ("uncertainty", {"stiffnes": 1})):
            with self.assertRaises(sf.InputError) as caught:
                verb = {"floor": sf.Scene(LEG).budget}.get(name, sf.Scene(LEG).robustness)
                verb(**{name: block})
            self.assertEqual((caught.exception.file, caught.exception.key), (f"<{name}>", *block))

    def test_name_a_key_that_is_missing(self):
        with self.assertRaises(sf.InputError) as caught:
            sf.Scene({k: v for k, v in LEG.items() if k != "title"}).modes()
        self.assertEqual(caught.exception.key, "title")
        with self.assertRaises(sf.InputError) as caught:
            sf.Scene(dict(LEG, masses=[{"node": "mass"}])).modes()
        self.assertRegex(caught.exception.key, "mass$")

    def test_name_a_file_that_is_not_there(self):
        with self.assertRaises(sf.InputError) as caught:
            sf.Scene("x.yaml").modes()
        self.assertEqual((caught.exception.file, caught.exception.key), (str(pathlib.Path("x.yaml").resolve()), None))

    def test_of_a_swept_path_name_it(self):
        with self.assertRaises(sf.InputError) as caught:
            sf.Scene(LEG).sweep({"controller.target": [1]})
        self.assertEqual((caught.exception.file, caught.exception.key), (None, "controller.target"))

    def test_of_options(self):
        scene = sf.Scene(LEG)
        for call, said in (
            (lambda: scene.robustness(samplse=3), "no option 'samplse' .did you mean 'samples'.*allowed: controller"),
            (lambda: scene.modes(lowest=True), "--lowest: .*true"),
            (lambda: scene.run("never", duration="2 s"), "--duration: .*2 s"),
            (lambda: scene.budget(log=sf.Log()), "log: found Log"),
        ):
            with self.assertRaisesRegex(sf.InputError, said):
                call()

    def test_kinds(self):
        free = dict(LEG, elements={"leg": dict(LEG["elements"]["leg"], stiffness=0)})
        with self.assertRaises(sf.ProgramError) as caught:
            sf.Scene(dict(free, gravity=[0, 0, -9.81])).equilibrium()
        self.assertIn(caught.exception.exit_code, (2, 3))
        with self.assertRaises(sf.InputError):
            sf.Scene("no/such/file.yaml").modes()
        naive = dict(LEG["controller"], realisation="naive_pi")
        del naive["lead_samples"]
        unstable = sf.Scene(dict(LEG, controller=naive)).design()
        self.assertGreater(unstable.spectral_radius, 1)

    def test_of_a_relative_path_from_another_folder(self):
        before = os.getcwd()
        os.environ["STILLFRAME"] = os.path.relpath(PROGRAM)
        try:
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                self.assertEqual(sf.program(), os.path.join(before, os.path.relpath(PROGRAM, before)))
                os.chdir(before)
        finally:
            os.chdir(before)
            os.environ["STILLFRAME"] = PROGRAM

    def test_of_a_program_that_is_not_there(self):
        os.environ["STILLFRAME"] = "/nowhere/stillframe"
        try:
            with self.assertRaisesRegex(sf.ProgramError, "/nowhere/stillframe"):
                sf.Scene(LEG).modes()
        finally:
            os.environ["STILLFRAME"] = PROGRAM


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
