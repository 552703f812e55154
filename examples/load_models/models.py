# The linear models of a loop in Python, in the folder of loop.mat:
#   stillframe design SCENE --mat loop.mat
import numpy
import scipy.io
import scipy.signal

loop = scipy.io.loadmat("loop.mat", simplify_cells=True)

m = loop["closed"]
closed = scipy.signal.StateSpace(m["A"], m["B"], m["C"], m["D"], dt=m["Ts"])
# The same with python-control: closed = control.ss(m["A"], m["B"], m["C"], m["D"], m["Ts"])

z = numpy.exp(2j * numpy.pi * 20 * closed.dt)
response = closed.C @ numpy.linalg.solve(z * numpy.eye(len(closed.A)) - closed.A, closed.B) + closed.D
largest = numpy.linalg.svd(response[:, :6], compute_uv=False)[0]
print(f"largest singular value at 20 Hz, closed loop: {largest:.4f}")
