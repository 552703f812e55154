#!/usr/bin/env python3
"""From a scene made in Python to a verdict: a table of 400 kg on one leg.

    STILLFRAME=build/release/bin/stillframe PYTHONPATH=python python3 examples/python/frame.py
"""

import tempfile

import stillframe as sf

scene = sf.Scene({
    "title": "A table on one leg",
    "nodes": {"floor": {"position": [0, 0, 0]}, "table": {"position": [0, 0, 1]}},
    "masses": [{"node": "table", "mass": 400}],
    "elements": {"leg": {"type": "truss", "nodes": ["floor", "table"], "stiffness": 4e6}},
    "supports": [{"nodes": ["table", "floor"], "fix": ["x", "y"]}],
    "prescribed": [{"nodes": ["floor"], "move": ["z"]}],
    "dofs": [{"element": "leg"}],
    "inputs": [{"name": "floor", "acceleration": "floor", "along": "z"}],
    "outputs": [{"name": "table", "acceleration": "table", "along": "z"}],
    "monitors": [{"name": "floor_z", "acceleration": "floor", "along": "z"}],
    "compare": {"z": {"floor": "floor_z", "frame": "table"}},
    "controller": {"legs": ["leg"], "target_hz": 5, "damping_ratio": 0.7, "sample_rate_hz": 2000, "delay_samples": 1,
                   "leak_hz": 0.05, "lead_samples": 1.5, "roll_off_hz": 200},
    "floor": {"noise": {"vc": "D", "axes": ["z"], "high_pass_hz": 0.5, "duration_s": 20}},
})

print(scene.linearise().A)
print(scene.modes().natural_frequencies_hz, "Hz")

swept = scene.sweep({"controller.target_hz": [3, 5, 8]}, at=[20])
for target, disk, transmission in zip(swept.columns["controller.target_hz"], swept.columns.disk_margin, swept.columns.transmission_20_hz):
    print(f"target {target:g} Hz: disk margin {disk:.2f}, {transmission:.3f} of the floor at 20 Hz")

with tempfile.TemporaryDirectory() as folder:
    run = scene.run(folder + "/run")
    print(run.verdict.outcome)
    for name in ("passive", "active"):
        log = getattr(run, name)
        print(f"{name}: {1e6 * log.frame_acceleration[:, 0].std():.0f} um/s^2, floor {1e6 * log.floor_acceleration.std():.0f}")
