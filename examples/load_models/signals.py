# The signals of a log in Python, in the folder of run.mat and run.csv:
#   stillframe export LOG --mat run.mat --csv run.csv
import csv

import numpy
import scipy.io

run = scipy.io.loadmat("run.mat", simplify_cells=True)
lens_z = list(run["frame_acceleration_names"]).index("lens_z")
rms = numpy.sqrt(numpy.mean(run["frame_acceleration"][:, lens_z] ** 2))
print(f"rms of lens_z: {rms:.6g} {run['frame_acceleration_unit']}")

# pandas.read_csv("run.csv", float_precision="round_trip") reads the same bits; its default does not.
with open("run.csv", newline="") as file:
    names = next(csv.reader(file))
    table = numpy.loadtxt(file, delimiter=",", ndmin=2)
print(f"{len(table)} samples of {len(names)} columns in the text, {len(run['time_s'])} samples in the .mat file")
