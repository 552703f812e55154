#!/usr/bin/env python3
"""Meshes a plate of 1.4 x 1.3 x 0.15 m with solid elements for CalculiX.

    python3 plate.py                      writes plate.mesh, plate.inp, plate_free.inp
    ccx plate                             its matrices: plate.sti, plate.mas, plate.dof
    stillframe superelement plate --interface mount_1=MOUNT_1@0.6,0,-0.1 \\
      --interface mount_2=MOUNT_2@-0.3,0.519615242270663,-0.1 \\
      --interface mount_3=MOUNT_3@-0.3,-0.519615242270663,-0.1 --interface lens=LENS@0,0,0.05 \\
      --modes 20 --out plate.yaml
    ccx plate_free                        modes of the free plate, for comparison: plate_free.dat
"""

from math import sqrt

CELLS = (14, 13, 2)
LOW, HIGH = (-0.7, -0.65, -0.1), (0.7, 0.65, 0.05)  # m
MOUNTS = {
    "MOUNT_1": (0.6, 0.0, -0.1),
    "MOUNT_2": (-0.3, sqrt(0.27), -0.1),
    "MOUNT_3": (-0.3, -sqrt(0.27), -0.1),
    "LENS": (0.0, 0.0, 0.05),
}
HALF_PAD = 0.08  # m: nodes of a face this near to a mount along x and y belong to it

# Corners, then the middles of the edges, in the order of CalculiX's C3D20, in half cells.
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
OFFSETS = CORNERS + [tuple((a + b) // 2 for a, b in zip(CORNERS[i], CORNERS[j])) for i, j in EDGES]


def lines_of(numbers, width=8):
    rows = [numbers[i : i + width] for i in range(0, len(numbers), width)]
    return ",\n".join(", ".join(map(str, row)) for row in rows)


def mesh():
    numbers, positions, elements = {}, [], []

    def node(at):
        if at not in numbers:
            numbers[at] = len(positions) + 1
            positions.append([l + (h - l) * i / (2 * n) for i, n, l, h in zip(at, CELLS, LOW, HIGH)])
        return numbers[at]

    for k in range(CELLS[2]):
        for j in range(CELLS[1]):
            for i in range(CELLS[0]):
                start = (2 * i, 2 * j, 2 * k)
                elements.append([node(tuple(a + b for a, b in zip(start, o))) for o in OFFSETS])
    return positions, elements


def main():
    positions, elements = mesh()
    deck = ["*NODE"] + [f"{n + 1}, {x:.12g}, {y:.12g}, {z:.12g}" for n, (x, y, z) in enumerate(positions)]
    deck.append("*ELEMENT, TYPE=C3D20, ELSET=PLATE")
    deck += [lines_of([n + 1] + element, 11) for n, element in enumerate(elements)]
    deck += ["*MATERIAL, NAME=ALUMINIUM", "*ELASTIC", "70e9, 0.33", "*DENSITY", "2700"]
    deck.append("*SOLID SECTION, ELSET=PLATE, MATERIAL=ALUMINIUM")
    for name, mount in MOUNTS.items():
        pad = [
            n + 1
            for n, p in enumerate(positions)
            if abs(p[2] - mount[2]) < 1e-9 and all(abs(a - b) <= HALF_PAD for a, b in zip(p[:2], mount))
        ]
        deck.append(f"*NSET, NSET={name}\n{lines_of(pad)}")
    with open("plate.mesh", "w") as file:
        file.write("\n".join(deck) + "\n")
    with open("plate.inp", "w") as file:
        file.write("*INCLUDE, INPUT=plate.mesh\n*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n10\n*END STEP\n")
    with open("plate_free.inp", "w") as file:
        file.write("*INCLUDE, INPUT=plate.mesh\n")
        for i, (name, (x, y, z)) in enumerate(MOUNTS.items()):
            point, turn = len(positions) + 1 + 2 * i, len(positions) + 2 + 2 * i
            file.write(f"*NODE\n{point}, {x:.15g}, {y:.15g}, {z:.15g}\n{turn}, {x:.15g}, {y:.15g}, {z:.15g}\n")
            file.write(f"*RIGID BODY, NSET={name}, REF NODE={point}, ROT NODE={turn}\n")
        file.write("*STEP\n*FREQUENCY\n26\n*END STEP\n")


if __name__ == "__main__":
    main()
