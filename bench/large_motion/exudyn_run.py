#!/usr/bin/env python3
"""One contender of scripts/bench_large_motion: Exudyn (pip install exudyn).

usage: exudyn_run.py MECHANISM.json METHOD SETTING SAMPLES

METHOD is DOPRI5 (SETTING: tolerance, joint coordinates of a kinematic tree) or trapezoidal (SETTING: steps a sample,
for closed chains). Runs from begin to end without a stop at the samples, and prints seconds and velocities as the
others do.
"""

import json
import sys
import time

import numpy as np

sys.exudynFast = True
import exudyn as exu  # noqa: E402
from exudyn import itemInterface as items  # noqa: E402
from exudyn import rigidBodyUtilities as rigid  # noqa: E402


def turn_to(axis):
    """A rotation matrix whose third column is the axis."""
    z = np.array(axis) / np.linalg.norm(axis)
    x = np.cross([0.0, 1.0, 0.0] if abs(z[1]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def build(mechanism):
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    bodies = mechanism["bodies"]
    n = len(bodies)
    turns = [turn_to(body["axis"]) for body in bodies]
    hinges = [np.array(body["hinge"]) for body in bodies]

    def parent_frame(body):
        return (turns[body], hinges[body]) if body >= 0 else (np.eye(3), np.zeros(3))

    transformations, offsets, inertias, centres = exu.Matrix3DList(), exu.Vector3DList(), exu.Matrix3DList(), exu.Vector3DList()
    for k, body in enumerate(bodies):
        turn, origin = parent_frame(body["parent"])
        transformations.Append(turn.T @ turns[k])
        offsets.Append(turn.T @ (hinges[k] - origin))
        inertias.Append(turns[k].T @ np.array(body["inertia"]) @ turns[k])
        centres.Append(turns[k].T @ (np.array(body["centre"]) - hinges[k]))
    node = mbs.AddNode(items.NodeGenericODE2(referenceCoordinates=[0.0] * n, initialCoordinates=[0.0] * n,
                                             initialCoordinates_t=[0.0] * n, numberOfODE2Coordinates=n))
    tree = mbs.AddObject(items.ObjectKinematicTree(
        nodeNumber=node, jointTypes=[exu.JointType.RevoluteZ] * n, linkParents=[body["parent"] for body in bodies],
        jointTransformations=transformations, jointOffsets=offsets, linkInertiasCOM=inertias, linkCOMs=centres,
        linkMasses=[body["mass"] for body in bodies], baseOffset=[0.0, 0.0, 0.0], gravity=mechanism["gravity"],
        jointPControlVector=[body["stiffness"] for body in bodies],
        jointDControlVector=[body["damping"] for body in bodies],
        jointPositionOffsetVector=[0.0] * n, jointVelocityOffsetVector=[0.0] * n))
    ground = mbs.AddObject(items.ObjectGround())

    def marker(point, rotations=False):
        position = np.array(point["position"])
        if point["body"] < 0:
            kind = items.MarkerBodyRigid if rotations else items.MarkerBodyPosition
            return mbs.AddMarker(kind(bodyNumber=ground, localPosition=list(position)))
        k = point["body"]
        return mbs.AddMarker(items.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=k,
                                                            localPosition=list(turns[k].T @ (position - hinges[k]))))

    for spring in mechanism["springs"]:
        length = np.linalg.norm(np.array(spring["to"]["position"]) - np.array(spring["from"]["position"]))
        mbs.AddObject(items.ObjectConnectorSpringDamper(
            markerNumbers=[marker(spring["from"]), marker(spring["to"])], referenceLength=length,
            stiffness=spring["stiffness"], damping=spring["damping"]))
    for guide in mechanism["guides"]:
        axes = [int(abs(component) > 0.5) for component in guide["normal"]]
        base = {"body": -1, "position": guide["point"]["position"]}
        mbs.AddObject(items.ObjectJointGeneric(markerNumbers=[marker(base, True), marker(guide["point"])],
                                               constrainedAxes=axes + [0, 0, 0]))
    sensors = []
    for output in mechanism["outputs"]:
        k = output["point"]["body"]
        at = list(turns[k].T @ (np.array(output["point"]["position"]) - hinges[k]))
        sensors.append(mbs.AddSensor(items.SensorKinematicTree(
            objectNumber=tree, linkNumber=k, localPosition=at, outputVariableType=exu.OutputVariableType.Velocity)))
    mbs.Assemble()
    return container, mbs, sensors


def settings_of(mechanism, method, setting, samples):
    settings = exu.SimulationSettings()
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = 1e9
    settings.timeIntegration.endTime = samples * mechanism["sample_time"]
    settings.timeIntegration.verboseMode = 0
    settings.displayComputationTime = False
    if method == "DOPRI5":
        settings.timeIntegration.numberOfSteps = samples  # the longest step; shorter ones are chosen
        settings.timeIntegration.absoluteTolerance = settings.timeIntegration.relativeTolerance = float(setting)
        settings.timeIntegration.explicitIntegration.computeEndOfStepAccelerations = False
        settings.timeIntegration.initialStepSize = 1e-4
        return settings, exu.DynamicSolverType.DOPRI5
    settings.timeIntegration.numberOfSteps = samples * int(setting)
    settings.timeIntegration.newton.useModifiedNewton = False
    settings.timeIntegration.newton.relativeTolerance = 1e-8
    settings.timeIntegration.newton.absoluteTolerance = 1e-10
    return settings, exu.DynamicSolverType.TrapezoidalIndex2


def main():
    if len(sys.argv) != 5:
        sys.exit(__doc__)
    with open(sys.argv[1]) as file:
        mechanism = json.load(file)
    method, setting, samples = sys.argv[2], sys.argv[3], int(sys.argv[4])
    seconds, attempts = [], 0
    while len(seconds) < 3:
        attempts += 1
        container, mbs, sensors = build(mechanism)
        settings, solver = settings_of(mechanism, method, setting, samples)
        begin = time.thread_time()
        try:
            mbs.SolveDynamic(settings, solverType=solver)
        except ValueError:
            # Version 1.11 gives up on a closed chain or does not, by where its memory happens to lie.
            if attempts > 20:
                raise
            continue
        seconds.append(time.thread_time() - begin)
        velocities = [float(np.dot(mbs.GetSensorValues(sensor), output["direction"]))
                      for sensor, output in zip(sensors, mechanism["outputs"])]
    print(json.dumps({"seconds": sorted(seconds)[1], "velocities": velocities}))


if __name__ == "__main__":
    main()
