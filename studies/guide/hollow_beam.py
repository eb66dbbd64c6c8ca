"""Writes the finite element model of a hollow beam: stiffness.mtx, mass.mtx, nodes.csv.

The beam is the specimen of the paper: walls of aluminium around a core. Eight-node bricks with incompatible modes (Wilson, Taylor), which
bend without locking. Needs numpy.

    python hollow_beam.py FOLDER
"""

import itertools
import pathlib
import sys

import numpy as np

# m; the core is 22.4 x 22.4 x 170 mm. Walls of 9 mm make 0.517 kg.
LENGTH, WIDTH, CORE = 0.170, 0.0404, 0.0224
YOUNG, POISSON, DENSITY = 72e9, 0.33, 2690.0
CORNERS = np.array(list(itertools.product((-1, 1), repeat=3)))


def elasticity():
    factor = YOUNG / ((1 + POISSON) * (1 - 2 * POISSON))
    matrix = np.zeros((6, 6))
    matrix[:3, :3] = POISSON
    np.fill_diagonal(matrix[:3, :3], 1 - POISSON)
    matrix[3:, 3:] = np.eye(3) * (1 - 2 * POISSON) / 2
    return factor * matrix


def strain(gradients):
    """Strain per displacement of functions with these gradients (functions x 3)."""
    out = np.zeros((6, 3 * len(gradients)))
    for index, (x, y, z) in enumerate(gradients):
        out[:, 3 * index : 3 * index + 3] = [[x, 0, 0], [0, y, 0], [0, 0, z], [y, x, 0], [0, z, y], [z, 0, x]]
    return out


def brick(size):
    """Stiffness and mass of a brick with these edges, three directions per corner."""
    half = np.array(size) / 2
    stiffness, mass = np.zeros((33, 33)), np.zeros((8, 8))
    for point in CORNERS / np.sqrt(3):
        terms = 1 + CORNERS * point
        values = terms.prod(axis=1) / 8
        slopes = np.stack([CORNERS[:, i] * np.delete(terms, i, axis=1).prod(axis=1) / 8 for i in range(3)], axis=1)
        bubbles = -2 * np.diag(point)
        slopes = np.vstack([slopes, bubbles]) / half
        b = strain(slopes)
        stiffness += b.T @ elasticity() @ b * half.prod()
        mass += np.outer(values, values) * DENSITY * half.prod()
    inner = stiffness[24:, 24:]
    condensed = stiffness[:24, :24] - stiffness[:24, 24:] @ np.linalg.solve(inner, stiffness[24:, :24])
    return condensed, np.kron(mass, np.eye(3))


def mesh(marks, solid):
    """Places of the nodes, and the bricks between the marks along x, y and z whose middle is solid: their corners and edges."""
    numbers, bricks = {}, []
    for place in itertools.product(*(range(len(mark) - 1) for mark in marks)):
        if not solid(*((mark[n] + mark[n + 1]) / 2 for mark, n in zip(marks, place))):
            continue
        corners = [tuple(np.add(place, corner)) for corner in (CORNERS + 1) // 2]
        edges = tuple(round(mark[n + 1] - mark[n], 12) for mark, n in zip(marks, place))
        bricks.append(([numbers.setdefault(corner, len(numbers)) for corner in corners], edges))
    return np.array([[mark[n] for mark, n in zip(marks, place)] for place in numbers]), bricks


def write(path, order, rows, columns, values):
    """Writes the lower triangle of a symmetric matrix, entries of one place summed, as a Matrix Market file."""
    places, index = np.unique(rows * order + columns, return_inverse=True)
    sums = np.bincount(index, values)
    lower = places // order >= places % order
    with open(path, "w") as file:
        file.write(f"%%MatrixMarket matrix coordinate real symmetric\n{order} {order} {lower.sum()}\n")
        for place, value in zip(places[lower], sums[lower]):
            file.write(f"{place // order + 1} {place % order + 1} {value:.17g}\n")


def write_model(folder, nodes, bricks):
    """Writes the matrices and nodes of a mesh into a folder."""
    matrices = {edges: brick(edges) for _, edges in bricks}
    dofs = np.array([[3 * corner + axis for corner in corners for axis in range(3)] for corners, _ in bricks])
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, 24).ravel()
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for which, name in enumerate(("stiffness", "mass")):
        values = np.concatenate([matrices[edges][which].ravel() for _, edges in bricks])
        write(folder / f"{name}.mtx", 3 * len(nodes), rows, columns, values)
    lines = [f"{number},{x:.9g},{y:.9g},{z:.9g}" for number, (x, y, z) in enumerate(nodes, 1)]
    (folder / "nodes.csv").write_text("node,x,y,z\n" + "\n".join(lines) + "\n")


def beam(along, wall, core):
    """The mesh with this number of bricks along the beam, through a wall and across the core."""
    inner = np.linspace(-CORE / 2, CORE / 2, core + 1)
    outer = np.linspace(CORE / 2, WIDTH / 2, wall + 1)[1:]
    section = np.concatenate([-outer[::-1], inner, outer])
    marks = [np.linspace(-LENGTH / 2, LENGTH / 2, along + 1), section, section]
    return mesh(marks, lambda _, y, z: max(abs(y), abs(z)) > CORE / 2)


def main(folder, along=24, wall=2, core=4):
    write_model(folder, *beam(along, wall, core))


if __name__ == "__main__":
    main(sys.argv[1])
