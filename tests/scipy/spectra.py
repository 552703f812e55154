"""spectra.py PRINT_SPECTRA FLOORS: welch() and third_octave_velocity() of report/spectra/spectra.hpp against
scipy.signal.welch, and against levels that are computed here from scipy's spectrum, on every recording of a folder.
Exit code 77 where scipy is not installed."""

import pathlib
import subprocess
import sys

try:
    import numpy
    import scipy.signal
except ImportError as error:
    print(f"skipped: {error}")
    sys.exit(77)

# Equal means to 1e-10. Of Welch's segments every bin is; of a whole recording as one segment the quietest bins lie 1e-16
# in power below the loudest, where both transforms round by 1e-16 of the loudest amplitude: ROUNDING allows ten times that.
TOLERANCE = 1e-10
ROUNDING = 1e-15

NOMINAL_HZ = [1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8, 10, 12.5, 16, 20, 25, 31.5, 40, 50, 63, 80]


def read_recording(path):
    """The columns of a recording and its rate, read apart from the program's own reader."""
    lines = path.read_text().splitlines()
    comments = " ".join(line for line in lines if line.startswith("#"))
    rows = [line for line in lines if not line.startswith("#")][1:]
    rate = float(comments.split("fs_hz=")[1].split()[0])
    return rate, numpy.array([[float(word) for word in row.split(",")] for row in rows]).T


def third_octave_velocity(frequency, density):
    """Rms velocity in the bands from 1 to 80 Hz: the integral of S_a / (2 pi f)^2, taken as constant over each bin."""
    df = frequency[1]
    velocity = numpy.zeros_like(density)
    velocity[1:] = density[1:] / (2 * numpy.pi * frequency[1:]) ** 2
    levels = []
    for n in range(len(NOMINAL_HZ)):
        centre = 10 ** (n / 10)
        lower, upper = centre * 10 ** -0.05, centre * 10 ** 0.05
        begin = numpy.clip(frequency - df / 2, lower, upper)
        end = numpy.clip(frequency + df / 2, lower, upper)
        levels.append(numpy.sqrt(numpy.sum(velocity * (end - begin))))
    return numpy.array(levels)


def printed(program, path, column, length):
    output = subprocess.run([program, path, str(column), str(length)], check=True, capture_output=True, text=True).stdout
    rows = [line.split() for line in output.splitlines()]
    return [numpy.array([[float(a), float(b)] for word, a, b in rows if word == kind]) for kind in ("psd", "band")]


def worst(found, expected, allowed=None):
    """The largest difference in units of the expected values, above what is allowed for."""
    assert found.shape == expected.shape, (found.shape, expected.shape)
    excess = numpy.abs(found - expected) - (0 if allowed is None else allowed)
    return max(numpy.max(excess / numpy.abs(expected)), 0.0)


def compare(program, path):
    rate, columns = read_recording(path)
    largest = 0.0
    for column, x in enumerate(columns):
        # 16 s, a power of two, an odd length, a prime, and all of it.
        for length in (round(16 * rate), 1024, 2047, 1031, len(x)):
            window = scipy.signal.get_window("hann", length)
            frequency, density = scipy.signal.welch(
                x, rate, nperseg=length, detrend=lambda s: s - (s @ window / window.sum())[..., None])
            psd, bands = printed(program, path, column, length)
            whole = length == len(x)
            rounding = 2 * ROUNDING * numpy.sqrt(density * density.max()) if whole else None
            largest = max(
                largest,
                worst(psd[1:, 0], frequency[1:]),
                # Of the mean that is taken off nothing is left but rounding.
                worst(psd[1:, 1], density[1:], None if rounding is None else rounding[1:]),
                psd[0, 1] / density.max(),
                worst(bands[:, 0], numpy.array(NOMINAL_HZ)),
                worst(bands[:, 1], third_octave_velocity(frequency, density)),
            )
    print(f"{path.name}: {len(columns)} columns of {len(columns[0])}, largest relative difference {largest:.1e}")
    return largest


def main():
    program, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    recordings = [path for path in sorted(folder.glob("*.csv")) if "fs_hz=" in path.read_text()[:2000]]
    assert len(recordings) >= 2, recordings
    differences = [compare(program, path) for path in recordings]
    sys.exit(0 if max(differences) < TOLERANCE else 1)


if __name__ == "__main__":
    main()
