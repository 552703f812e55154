#!/usr/bin/env python3
"""What scripts/hidden_rig says of answers of commission that nobody waited for. Argument: the source folder."""

import contextlib
import copy
import importlib.machinery
import importlib.util
import io
import pathlib
import signal
import subprocess
import sys
import tempfile
import types
import unittest
import unittest.mock

SOURCE = pathlib.Path(sys.argv[1])

loader = importlib.machinery.SourceFileLoader("hidden_rig", str(SOURCE / "scripts/hidden_rig"))
hidden_rig = importlib.util.module_from_spec(importlib.util.spec_from_loader("hidden_rig", loader))
loader.exec_module(hidden_rig)

HIDDEN = {"lens mass": 0.1, "leg_1t stiffness": -0.15, "delay": hidden_rig.DELAY}
CABLES = [{"leg": "leg_1t", "what": "force sensor: on the cable of leg_1v"},
          {"leg": "leg_1v", "what": "force sensor: on the cable of leg_1t"},
          {"leg": "leg_1t", "what": "amplifier: wired the other way round"}]


def parameter(name, deviation, told=True):
    return {"name": name, "deviation": deviation, "standard_deviation": 0.01, "told": told}


def response(of):
    return {"of": of, "worst_db": 0.3, "worst_hz": 40.0, "mean_db": -0.05, "mean_doubt_db": 0.1, "n_told": 20, "n_acting": 9, "as_predicted": True}


ANSWER = {"wrong": CABLES, "parameters": [parameter("lens mass", 0.105), parameter("leg_1t stiffness", 0.3, told=False), parameter("delay", 0.31)],
          "over_noise": 1.02, "n_late": 3, "n_left_out": 0, "closed": {"responses": [response("frame"), response("strain")]}}


def rig_file():
    """As commission would leave it on cards whose gains are off as the converter's are."""
    part = [1 + hidden_rig.GAINS_OFF / 100 * hidden_rig.math.cos(i) for i in range(1, 13)]
    lines = ["sigma:"] + [f"  {leg}: {{channel: {i}, gain: {0.01 / part[i]}}}" for i, leg in enumerate(hidden_rig.LEGS)]
    lines += ["force:"] + [f"  {leg}: {{channel: {i}, gain: {0.01 * part[2 * i + 1]}}}" for i, leg in enumerate(hidden_rig.LEGS)]
    return "\n".join(lines) + "\n"


def changed(**closed):
    answer = copy.deepcopy(ANSWER)
    answer["closed"]["responses"][1].update(closed)
    return answer


class HiddenRig(unittest.TestCase):
    def setUp(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        self.folder = pathlib.Path(place.name)
        (self.folder / "rig.updated.yaml").write_text(rig_file())

    def rows(self, answer, code=0):
        return {what: (found, bool(holds)) for what, found, _, holds in hidden_rig.judged(self.folder, HIDDEN, answer, code)}

    def failed(self, answer, code=0):
        return [what for what, (_, holds) in self.rows(answer, code).items() if not holds]

    def test_a_sound_answer_holds(self):
        self.assertEqual(self.failed(ANSWER), [])
        self.assertEqual(self.rows(ANSWER)["parameters that are told, in their 95 % bands"][0], "2 of 2")
        self.assertEqual(self.rows(ANSWER)["closed, strain"][0],
                         "+0.30 dB off at worst, -0.05 dB all together (noise: 0.10 dB), told at 20 lines, acts at 9")

    def test_what_noise_hides_is_a_failure_in_words(self):
        hidden = {"worst_db": None, "worst_hz": None, "mean_db": None, "mean_doubt_db": None, "n_told": 0, "n_acting": 0}
        for as_predicted in (False, True):
            answer = changed(**hidden, as_predicted=as_predicted)
            self.assertEqual(self.failed(answer), ["closed, strain"])
            self.assertEqual(self.rows(answer)["closed, strain"][0], "noise hides all")

    def test_lines_that_are_told_beside_a_mean_that_is_not(self):
        answer = changed(mean_db=None, mean_doubt_db=None, as_predicted=False)
        self.assertEqual(self.failed(answer), ["closed, strain"])
        self.assertEqual(self.rows(answer)["closed, strain"][0],
                         "+0.30 dB off at worst, hidden by noise all together, told at 20 lines, acts at 9")

    def test_what_did_not_come_to_an_end(self):
        self.assertEqual(self.failed(ANSWER, 4), ["exit code"])
        self.assertEqual(self.failed(dict(ANSWER, closed=None), 4), ["loop"])
        self.assertEqual(self.failed(dict(ANSWER, parameters=[], closed=None, over_noise=None, n_late=None), 4), ["fit"])
        self.assertEqual(self.failed(dict(ANSWER, wrong=CABLES[:2])), ["cables and sign"])
        self.assertEqual(self.failed(dict(ANSWER, over_noise=1.6)), ["left over noise"])

    def test_gains_of_cards(self):
        file = self.folder / "rig.updated.yaml"
        file.write_text(file.read_text().replace("force:\n  leg_1t: {channel: 0, gain: ", "force:\n  leg_1t: {channel: 0, gain: -1e-3, was: "))
        self.assertEqual(self.failed(ANSWER), ["gains, of each other"])

    def test_the_program_says_each_row_and_ends_with_4(self):
        options = types.SimpleNamespace(rigs=1, seed=1, build=SOURCE, keep=self.folder, force=10, limit=9)
        (self.folder / "1").mkdir()
        (self.folder / "1/rig.updated.yaml").write_text(rig_file())
        out = io.StringIO()
        with unittest.mock.patch.multiple(hidden_rig, told=lambda: options, hide=lambda *_: HIDDEN,
                                          commissioned=lambda *_: (changed(worst_db=None, as_predicted=False), 4)), \
                unittest.mock.patch.object(pathlib.Path, "exists", return_value=True), contextlib.redirect_stdout(out):
            self.assertEqual(hidden_rig.main(), 4)
        self.assertIn("  NOT  closed, strain: noise hides all (as predicted)\n", out.getvalue())
        self.assertIn("  ok   closed, frame: ", out.getvalue())

    def test_an_answer_that_breaks_off(self):
        for said, expected in (("", None), ("{\"wrong\": [", None), ("{}", {})):
            program = unittest.mock.Mock(returncode=1)
            program.communicate.return_value = (said, None)
            with unittest.mock.patch.object(subprocess, "run"), unittest.mock.patch.object(subprocess, "Popen", return_value=program):
                self.assertEqual(hidden_rig.commissioned(self.folder, types.SimpleNamespace(build=SOURCE, force=10, limit=9), 1), (expected, 1))

    def test_a_program_that_does_not_end_is_ended(self):
        deaf = "import signal, time; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(1, flush=True); time.sleep(60)"
        started, popen = [], subprocess.Popen

        def noted(*args, **options):
            started.append(popen(*args, **options))
            return started[-1]
        for command, ending in ((["sleep", "60"], signal.SIGTERM), ([sys.executable, "-c", deaf], signal.SIGKILL)):
            err = io.StringIO()
            with unittest.mock.patch.object(subprocess, "Popen", noted), unittest.mock.patch.object(hidden_rig, "GRACE", 0.5), \
                    contextlib.redirect_stderr(err):
                self.assertEqual(hidden_rig.answer_of(command, self.folder, 2), (None, None))
            self.assertEqual(started[-1].poll(), -ending)
            self.assertEqual(err.getvalue(), f"hidden_rig: commission (process {started[-1].pid}) has not answered in 2 s, the --limit, and is ended\n")
        self.assertEqual(hidden_rig.answer_of(["echo", "{}"], self.folder, 30), ("{}\n", 0))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
