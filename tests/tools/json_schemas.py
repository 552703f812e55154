"""Everything that the programs write as JSON, against docs/json/*.schema.json.

    json_schemas.py STILLFRAME SOURCE [FOLDER_OF_SCHEMAS]

STILLFRAME is the program, its siblings beside it. Every schema must be used, every key of it be written at least once
and not as null, and every key that may be absent be absent at least once: a key that is added, renamed or lost fails,
and so does one that only the schema knows. Runs itself in a private network. Skipped (77) where there is no jsonschema.
"""
import collections
import contextlib
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

try:
    import jsonschema
except ImportError:
    print("json_schemas.py: no python3-jsonschema here, nothing is tested", file=sys.stderr)
    sys.exit(77)

# Keys that no run of this test can have written, or that it cannot have left out; each with its reason.
NEVER_SEEN = {
    "robustness#/$defs/found/properties/failure": "the worst plant that a search finds has an equilibrium",
    "robustness#/$defs/outcome/properties/failure": "and so have its neighbours",
}
NEVER_ABSENT = {
    "robustness#/$defs/found/properties/decay_per_s": "as failure",
    "robustness#/$defs/found/properties/least_damping_ratio": "as failure",
    "robustness#/$defs/found/properties/spectral_radius": "as failure",
    "robustness#/$defs/outcome/properties/decay_per_s": "as failure",
    "robustness#/$defs/outcome/properties/least_damping_ratio": "as failure",
    "robustness#/$defs/outcome/properties/spectral_radius": "as failure",
}

UNITS_IN_KEYS = {"Hz": "hz", "dB": "db", "us": "us", "ns": "ns", "samples": "samples", "N": "n", "m/s": "m_s",
                 "m/s^2": "m_s2"}
# Whole numbers without n_: those that number something, sizes, times, taps as a scene has them, and what `counts` counts.
NO_COUNTS = {"pid", "seed", "index", "seq", "period", "column", "first_bin", "bytes", "unread_bytes", "started_ns", "worst_ns",
             "taps", "stable", "unstable", "failed", "line"}

# A mass on one leg: the smallest scene that everything can be asked of, and quick.
LEG = """title: One leg
planar: true
nodes: {f: {position: [0, 0]}, c: {position: [0, 0.25]}}
masses: [{node: c, mass: 100}]
elements:
  leg: {type: truss, nodes: [f, c], stiffness: 2e6, damping: 150}
supports: [{nodes: [f, c], fix: [x]}]
prescribed: [{nodes: [f], move: [y]}]
dofs: [{element: leg}]
inputs: [{name: g, acceleration: f, along: y}]
outputs: [{name: c_y, acceleration: c, along: y}]
controller: {legs: [leg], target_hz: 5, damping_ratio: 0.7, sample_rate_hz: 1000, delay_samples: 1,
  lead_samples: 1.5, leak_hz: 0.05, force_limit_n: 200}
uncertainty: {stiffness: 0.3, actuator_gain: 0.4}
"""
# A strip that warps, and a joint that a scene has not: all that an import can say.
STRIPS = """nodes = [0 0 0; 0.1 0 0];
elements = [1 2];
nprops(1).fix = true;
nprops(2).rot_x = 0.1;
eprops(1).elems = 1;
eprops(1).emod = 210e9; eprops(1).smod = 70e9; eprops(1).dens = 7800;
eprops(1).cshape = 'rect'; eprops(1).dim = [0.02 0.001]; eprops(1).orien = [0 0 1];
eprops(1).flex = 1:6; eprops(1).warping = true; eprops(1).color = 'grey';
out = spacarlight(nodes, elements, nprops, eprops);
"""
COMPARED = "monitors: [{name: g_y, acceleration: f, along: y}]\ncompare: {y: {floor: g_y, frame: c_y}}\n"
PUSHED = "disturbances: [{name: push, node: c, along: y, force: {sine: {amplitude: 1, frequency_hz: 7}}}]\n"
MULTISINE = "floor: {multisine: {frequencies_hz: [4, 8, 14, 40], amplitude: 1e-3, ramp_s: 2, window_s: 2}}\n"
NOISE = "floor: {noise: {vc: D, high_pass_hz: 0.5, duration_s: 12}}\n"
KNOCK = """floor: {sum: [{noise: {vc: G, high_pass_hz: 0.5, duration_s: 12}},
  {impact: {peak: 0.5, width_s: 0.1, at_s: 6, input: g}}]}
"""

PATIENCE_S = 600  # with sanitizers everything takes longer

errors = []


def fail(text):
    errors.append(text)
    print("json_schemas.py: " + text, file=sys.stderr)


# --- schemas


def closed_objects(schema, pointer="#"):
    """Every schema of an object with fixed keys, with its place."""
    if isinstance(schema, dict):
        if "properties" in schema and not pointer.endswith("/properties"):
            yield pointer, schema
        for key, value in schema.items():
            yield from closed_objects(value, f"{pointer}/{key}")
    elif isinstance(schema, list):
        for i, value in enumerate(schema):
            yield from closed_objects(value, f"{pointer}/{i}")


class Schema:
    """One schema, and what has been seen of it."""

    def __init__(self, path):
        self.name = path.name.removesuffix(".schema.json")
        self.tree = strict(path.read_text(encoding="utf-8"), path.name)
        jsonschema.Draft202012Validator.check_schema(self.tree)
        self.validator = jsonschema.Draft202012Validator(self.tree)
        self.n_documents = 0
        self.objects, self.present, self.filled = (collections.Counter() for _ in range(3))
        self.require_form()

    def require_form(self):
        if self.tree.get("$id") is None or not re.fullmatch(f"/stillframe/{self.name}/[1-9][0-9]*", self.tree["$id"]):
            fail(f"{self.name}: $id is {self.tree.get('$id')}")
        if not self.tree.get("title"):
            fail(f"{self.name}: no title")
        for pointer, schema in closed_objects(self.tree):
            if schema.get("additionalProperties") is not False or "required" not in schema:
                fail(f"{self.name}{pointer}: additionalProperties: false and required belong here")
            for key in set(schema.get("required", [])) - set(schema["properties"]):
                fail(f"{self.name}{pointer}: {key} is required and not described")
            for key, value in schema["properties"].items():
                self.require_key(f"{self.name}{pointer}/properties/{key}", key, value)

    @staticmethod
    def require_key(place, key, value):
        """Keys as docs/json/README.md has them: units that are not SI, counts, and what scene means."""
        description = value.get("description")
        if not description:
            fail(f"{place}: no description")
            return
        unit = re.search(r"(?:^|, )(Hz|dB|us|ns|samples|N|m/s|m/s\^2)(?: rms)?(?:;|$)", description)
        whole = "integer" in value.get("type", "")
        if unit and not whole:
            wanted = UNITS_IN_KEYS[unit[1]]
            if not re.search(f"(^|_){wanted}$", key):
                fail(f"{place}: is in {unit[1]}, and its key has no {wanted} at its end")
        if whole and not key.startswith("n_") and key not in NO_COUNTS:
            fail(f"{place}: is a count without n_, or belongs to NO_COUNTS")
        if key == "scene" and "the scene's title" not in description:
            fail(f"{place}: scene is the scene's title, a path is scene_file")

    def take(self, text, where):
        """Validates the text of a document."""
        document = strict(text, where)
        self.n_documents += 1
        found = sorted(self.validator.iter_errors(document), key=lambda error: list(map(str, error.absolute_path)))
        for error in found[:5]:
            path = "/".join(map(str, error.absolute_path))
            fail(f"{where}: not as {self.name}.schema.json says: /{path}: {error.message[:300]}")
        self.walk(self.tree, "#", document)

    def fits(self, schema, value):
        return self.validator.evolve(schema=schema).is_valid(value)

    def walk(self, schema, pointer, value):
        """Counts what of the schema a value has."""
        if "$ref" in schema:
            pointer = schema["$ref"]
            schema = self.tree["$defs"][pointer.removeprefix("#/$defs/")]
        for kind in ("anyOf", "oneOf"):
            for i, branch in enumerate(schema.get(kind, [])):
                if self.fits(branch, value):
                    self.walk(branch, f"{pointer}/{kind}/{i}", value)
        if isinstance(value, dict):
            properties = schema.get("properties", {})
            if properties:
                self.objects[pointer] += 1
            for key, inner in value.items():
                if key in properties:
                    place = f"{pointer}/properties/{key}"
                    self.present[place] += 1
                    self.filled[place] += inner is not None
                    self.walk(properties[key], place, inner)
                elif isinstance(schema.get("additionalProperties"), dict):
                    self.walk(schema["additionalProperties"], f"{pointer}/additionalProperties", inner)
        elif isinstance(value, list) and isinstance(schema.get("items"), dict):
            for inner in value:
                if isinstance(inner, (dict, list)):
                    self.walk(schema["items"], f"{pointer}/items", inner)

    def require_all_seen(self, never_seen, never_absent):
        if self.n_documents == 0:
            fail(f"{self.name}: nothing was held against it")
            return
        for pointer, schema in closed_objects(self.tree):
            for key in schema["properties"]:
                place = f"{pointer}/properties/{key}"
                if self.filled[place] == 0:
                    if never_seen.pop(self.name + place, None) is None:
                        fail(f"{self.name}{place}: was never written, or as null alone")
                elif key not in schema["required"] and self.present[place] == self.objects[pointer]:
                    if never_absent.pop(self.name + place, None) is None:
                        fail(f"{self.name}{place}: was never absent; required?")


def strict(text, where):
    """JSON as the standard has it: no NaN and no Infinity, no key twice."""

    def no_constant(word):
        raise ValueError(f"{where}: {word} is no JSON")

    def no_key_twice(pairs):
        keys = [key for key, _ in pairs]
        if len(set(keys)) != len(keys):
            raise ValueError(f"{where}: a key stands twice among {keys}")
        return dict(pairs)

    return json.loads(text, parse_constant=no_constant, object_pairs_hook=no_key_twice)


# --- programs


class Programs:
    def __init__(self, stillframe, source, schemas):
        self.stillframe = str(stillframe)
        self.config = source / "config"
        self.schemas = schemas

    def scene(self, name):
        return self.config / "scenes" / f"{name}.yaml"

    def controller(self, name):
        return self.config / "controllers" / f"{name}.yaml"

    def start(self, *arguments, output=subprocess.PIPE):
        command = [self.stillframe, *map(str, arguments)]
        return subprocess.Popen(command, stdout=output, stderr=subprocess.PIPE, text=True)

    def call(self, *arguments, codes=(0,)):
        """Standard output of `stillframe ARGUMENTS`."""
        process = self.start(*arguments)
        output, said = process.communicate(timeout=PATIENCE_S)
        if process.returncode not in codes:
            raise RuntimeError(f"stillframe {' '.join(map(str, arguments))}: exit code {process.returncode}: {said}")
        if not output:
            raise RuntimeError(f"nothing on standard output, exit code {process.returncode}: {said}")
        return output

    def check(self, *arguments, codes=(0,), schema=None):
        """The document of `stillframe ARGUMENTS --json`, which is as its schema says."""
        try:
            output = self.call(*arguments, "--json", codes=codes)
            self.schemas[schema or arguments[0]].take(output, " ".join(map(str, arguments)))
        except (RuntimeError, ValueError) as error:
            fail(f"{' '.join(map(str, arguments))}: {error}")

    def check_file(self, schema, path):
        try:
            self.schemas[schema].take(pathlib.Path(path).read_text(encoding="utf-8"), str(path))
        except (OSError, ValueError) as error:
            fail(f"{path}: {error}")


def write(name, text):
    pathlib.Path(name).write_text(text, encoding="utf-8")
    return name


def models(run):
    for name in ("metrology_frame", "cantilever", "spinning_arm", "frame_under_gravity"):
        run.check("modes", run.scene(name))
    for name in ("metrology_frame", "cantilever", "rotating_cantilever", "frame_under_gravity"):
        run.check("equilibrium", run.scene(name))
    run.check("buckling", run.scene("euler_column"))
    run.check("buckling", run.scene("lateral_buckling"), "--count", 2)
    run.check("linearise", run.scene("cart"), "--certify")
    run.check("linearise", run.scene("metrology_frame"))
    run.check("linearise", run.scene("rotating_cantilever"))
    flexible = run.scene("frame_flexible").read_text(encoding="utf-8").replace("../", f"{run.config}/")
    run.check("linearise", write("reduced.yaml", flexible + "\nreduce: {modes: 9}\n"))
    open_loop = re.sub("(?m)^controller:.*$", "", flexible)
    run.check("sigma", write("reduced_open.yaml", open_loop + "\nreduce: {modes: 9}\n"), "--points", 20, "--to", 1000)
    plate = run.config.parent / "examples/superelement/plate.py"
    subprocess.run([sys.executable, plate], check=True)
    subprocess.run(["ccx", "plate"], check=True, stdout=subprocess.DEVNULL)
    for modes in (0, 3):
        run.check("superelement", "plate", "--interface", "a=MOUNT_1", "--interface", "b=LENS", "--modes", modes)
    run.check("import", write("strips.m", STRIPS), codes=(4,))
    run.check("sigma", run.scene("cart"))
    run.check("sigma", run.scene("frame_flexible"), "--points", 20)
    run.check("sigma", run.scene("metrology_frame"), "--to", 2000, "--points", 20)


def loops(run):
    frame = run.scene("metrology_frame")
    run.check("design", write("reduced_frame.yaml", frame.read_text(encoding="utf-8").replace("../", f"{run.config}/")
                              + "\nreduce: {modes: 4}\n"))
    leg = write("leg.yaml", LEG + NOISE)
    run.check("design", frame)
    run.check("design", frame, "--controller", run.controller("own_law_1khz"))
    run.check("design", frame, "--controller", run.controller("feed_forward_1khz"))
    aimed = LEG.replace("leak_hz", "feed_forward: {target_hz: 4, damping_ratio: 0.8}, leak_hz")
    run.check("design", write("aimed.yaml", aimed))
    gains = write("gains_of_ones_own.yaml", "K_P: [[19]]\nK_I: [[891]]\n")
    run.check("design", write("own_gains.yaml", LEG.replace("leak_hz", f"law: {gains}, leak_hz")))
    run.check("design", write("unstable.yaml", LEG.replace("leak_hz", "realisation: naive_pi, leak_hz")), codes=(3,))

    # Slow and to a near target, where the search for a bound takes seconds.
    slow = LEG.replace("sample_rate_hz: 1000", "sample_rate_hz: 300").replace("target_hz: 5", "target_hz: 8")
    run.check("feedback", write("slow.yaml", slow), "--curve")
    run.check("feedback", leg, "--disk", 1.9)

    run.check("sweep", leg, "--set", "controller.delay_samples=-1,1", "--at", "20,600", codes=(4,))
    run.check("sweep", frame, "--set", "controller.delay_samples=0,1,7", "--at", 20)
    run.check("budget", leg, "--duration", 4)
    run.check("budget", leg, "--floor", write("still.yaml", "still: {duration_s: 1}\n"))
    run.check("budget", frame, "--duration", 4, "--controller", run.controller("feed_forward_1khz"))

    known = write("known.yaml", "stiffness: 0.05\n")  # a leg that no loop is lost over
    run.check("robustness", leg, "--samples", 5, "--uncertainty", known)
    run.check("robustness", leg, "--samples", 20, "--out", "all.json")
    run.check_file("robustness_record", "all.json")
    for shard in (1, 2):
        run.check("robustness", leg, "--samples", 20, "--shard", f"{shard}/2", "--out", f"part_{shard}.json")
        run.check_file("robustness_record", f"part_{shard}.json")
    run.check("merge", "part_1.json", "part_2.json", "--out", "merged.json", schema="robustness_record")
    run.check_file("robustness_record", "merged.json")
    run.check("robustness", leg, "--from", "merged.json", "--no-search")


def rigs(run):
    gains = "rig_gains.yaml"
    run.call("design", write("rig_leg.yaml", LEG), "--out", gains)
    turned = "driver: {name: simulation}\nsigma: {leg: {gain: -1}}\n"
    run.check("rig", gains, write("turned.yaml", turned), codes=(4,))
    known = "stiffness: 0.2\nmass: 0.1\nsensor_gain: 0.1\ndelay_samples: 0.5\n"
    run.check("commission", "rig_leg.yaml", write("turned_rig.yaml", turned), "--uncertainty",
              write("rig_known.yaml", known), "--window", 0.4, "--windows", 3, codes=(0, 4))
    run.check("commission", "rig_leg.yaml", "--simulate", "rig_leg.yaml", "--uncertainty", "rig_known.yaml",
              "--window", 0.4, "--windows", 3, "--until", "loop", "--report", "rig.html", codes=(0, 4))


def runs(run):
    any_verdict = (0, 4)

    def one(name, text, *more):
        run.check("run", write(f"{name}.yaml", text), "--mode", "single_process", "--out", name, *more,
                  codes=any_verdict, schema="verdict")
        run.check_file("verdict", f"{name}/verdict.json")

    one("lines", LEG + MULTISINE)
    one("noise", LEG + COMPARED + NOISE)
    one("pushed", LEG + COMPARED + KNOCK + PUSHED)
    one("passive", LEG + COMPARED + NOISE, "--loop", "passive", "--duration", 2)
    run.check("report", "lines/active.lcm", "--verdict", "again.json", codes=any_verdict, schema="verdict")
    run.check_file("verdict", "again.json")

    run.check("identify", "lines/active.lcm", codes=any_verdict)
    run.check("identify", "noise/active.lcm", "--segment", 2, codes=any_verdict)
    # Six inputs that three motions move are not identified.
    frame = run.scene("metrology_frame").read_text(encoding="utf-8").replace("../", f"{run.config}/")
    one("frame", frame, "--loop", "passive", "--duration", 4)
    run.check("identify", "frame/passive.lcm", "--segment", 1, codes=any_verdict)
    run.check("budget", "noise.yaml", "--log", "noise/passive.lcm", "--log", "noise/active.lcm", codes=any_verdict)

    run.check("replay", "noise/active.lcm")
    other = pathlib.Path("noise/gains.yaml").read_text(encoding="utf-8").replace("leak_hz: 0.05", "leak_hz: 0.06")
    run.check("replay", "noise/active.lcm", "--gains", write("other.yaml", other), codes=(4,))
    run.check("export", "noise/active.lcm", "--csv", "noise.csv", "--mat", "noise.mat", "--to", 1)

    nowhere = write("nowhere.yaml", "step: {height: 1e-3, rise_s: 1, input: nothing}\n")
    still = write("calm.yaml", "noise: {vc: G, high_pass_hz: 0.5, duration_s: 2}\n")
    run.check("batch", "noise.yaml", "lines.yaml", "--floor", still, "--floor", nowhere, codes=(4,))
    run.check("batch", "noise.yaml", "--floor", still, "--duration", "1", codes=(0, 4))
    run.check("batch", "noise.yaml", "--floor", still, "--duration", "1e-5", codes=(4,))


@contextlib.contextmanager
def ended(*processes):
    """Whatever happens, no process is left."""
    try:
        yield
    finally:
        for process in processes:
            if process.poll() is None:
                process.kill()
            process.communicate()


def lines_of(path):
    """The whole lines that are there, but for the first, which says where the page is."""
    text = pathlib.Path(path).read_text(encoding="utf-8")
    return text[: text.rfind("\n") + 1].splitlines()[1:]


def wait_for(what, holds, process):
    """Until so it is; the process must go on meanwhile."""
    for _ in range(600):
        if holds():
            return
        if process.poll() is not None:
            break
        time.sleep(0.1)
    raise RuntimeError(f"waited for {what} in vain")


def by_the_clock(run):
    """A run in wall-clock mode, which is asked and watched meanwhile; again where the machine had no time for it."""
    for attempt in (1, 2, 3):
        folder = pathlib.Path(f"clock_{attempt}")
        folder.mkdir()
        os.environ["XDG_STATE_HOME"] = str(folder.resolve())  # a fault that latches stays here
        try:
            clocked(run, folder)
            return
        except RuntimeError as error:
            print(f"by_the_clock, {attempt}: {error}")
    fail("no run by the clock came to its end")


def clocked(run, folder):
    """Errors: RuntimeError if there was nothing to see."""
    # Slow, so that a machine with other work keeps up.
    scene = write("clock.yaml", LEG.replace("sample_rate_hz: 1000", "sample_rate_hz: 200") + COMPARED + NOISE)
    views, out = folder / "views", folder / "run"

    def seen(*keys):
        """Whether the newest line says something of all these."""
        return any(all(json.loads(line)[key] for key in keys) for line in lines_of(views)[-1:])

    with open(views, "w", encoding="utf-8") as file:
        watch = run.start("watch", "--json", "--serve", 0, output=file)
    with ended(watch):
        wall = run.start("run", scene, "--mode", "wall_clock", "--realtime", "off", "--duration", 7, "--out", out,
                         "--loop", "active", "--json")
        with ended(wall):
            wait_for("levels and forces", lambda: seen("run", "controller", "axes", "legs"), wall)
            status = run.call("ctl", "status", "--timeout", 5, "--json")
            page = re.match("live page: (http://127.0.0.1:[0-9]+) ", views.read_text(encoding="utf-8"))
            with urllib.request.urlopen(f"{page[1]}/view", timeout=10) as answer:
                view = answer.read().decode()
            verdict, said = wall.communicate(timeout=PATIENCE_S)
        if wall.returncode not in (0, 4) or not verdict:
            raise RuntimeError(f"run --mode wall_clock: exit code {wall.returncode}: {said}")
        if all(timing.get("wake_up") is None for timing in json.loads(verdict)["timing"]):
            raise RuntimeError(f"run --mode wall_clock: nothing is known of its wake-ups: {said}")
        wait_for("what plant and controller say at their end", lambda: seen("timing"), watch)
        watch.send_signal(signal.SIGINT)
        watch.wait(timeout=PATIENCE_S)
    run.schemas["ctl"].take(status, "ctl status")
    run.schemas["watch"].take(view, "watch --serve: /view")
    run.schemas["verdict"].take(verdict, "run --mode wall_clock")
    run.check_file("timing", out / "active_timing.json")
    run.check("replay", out / "active.lcm")
    for i, line in enumerate(lines_of(views)):
        run.schemas["watch"].take(line, f"watch --json, line {i + 1}")


def require_table(readme, schemas):
    """Every schema has its line."""
    named = set(re.findall(r"\(([a-z_]+)\.schema\.json\)", readme.read_text(encoding="utf-8")))
    for name in set(schemas) ^ named:
        fail(f"{readme.name}: {name} is {'not named' if name in schemas else 'named, and there is no such schema'}")


def main():
    arguments = sys.argv[1:]
    if len(arguments) not in (2, 3):
        print(__doc__, file=sys.stderr)
        return 2
    stillframe, source = (pathlib.Path(path).resolve() for path in arguments[:2])
    folder = pathlib.Path(arguments[2]).resolve() if len(arguments) == 3 else source / "docs" / "json"
    inside = "STILLFRAME_JSON_SCHEMAS_INSIDE"
    if inside not in os.environ:
        os.environ[inside] = "1"
        network = source / "scripts" / "private_network"
        again = (network, sys.executable, pathlib.Path(__file__).resolve(), stillframe, source, folder)
        os.execv(network, list(map(str, again)))
    os.environ.pop("LCM_DEFAULT_URL", None)
    schemas = {schema.name: schema for schema in map(Schema, sorted(folder.glob("*.schema.json")))}
    if not schemas:
        fail(f"{folder}: no schema")
    require_table(folder / "README.md", schemas)
    run = Programs(stillframe, source, schemas)
    with tempfile.TemporaryDirectory() as empty, contextlib.chdir(empty):
        for part in (models, loops, rigs, runs, by_the_clock):
            began = time.monotonic()
            part(run)
            print(f"{part.__name__}: {time.monotonic() - began:.1f} s")
    never_seen, never_absent = dict(NEVER_SEEN), dict(NEVER_ABSENT)
    for schema in schemas.values():
        schema.require_all_seen(never_seen, never_absent)
    for place in (*never_seen, *never_absent):
        fail(f"{place}: is in the list of exceptions, and needs not be")
    used = os.times()
    print(f"{sum(schema.n_documents for schema in schemas.values())} documents, {len(schemas)} schemas, "
          f"{used.user + used.system + used.children_user + used.children_system:.1f} s of CPU, {len(errors)} errors")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
