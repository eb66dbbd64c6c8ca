"""Writes the finite element model of a cylinder head: stiffness.mtx, mass.mtx, nodes.csv, with the origin at the centre of mass.

A block of aluminium with the cavities of two cores: a water jacket above the deck, around the spark plugs of four cylinders, and eight ports,
which open at both sides. x points across, y along, z up. The script imports the bricks from hollow_beam.py, which must be in the same folder.
Needs numpy.

    python cylinder_head.py FOLDER [FINER]

FINER divides each edge of the bricks (default 1).
"""

import sys

import hollow_beam
import numpy as np

# mm; planes between bricks. A cylinder is 100 mm long; its spark plug stands in the middle.
ACROSS = [-75, -60, -45, -30, -15, 0, 15, 30, 45, 60, 75]
CYLINDER = [-42.5, -20, 0, 20, 42.5]
ALONG = sorted([-200, -185, 185, 200] + [middle + y for middle in (-150, -50, 50, 150) for y in CYLINDER if abs(middle + y) < 185])
UP = [0, 15, 30, 45, 60, 70, 82.5, 95, 110]
JACKET, PORTS = (15, 60), (70, 95)


def solid(x, y, z):
    """Whether a place, in m, lies in the metal."""
    x, y, z = 1e3 * abs(x), 1e3 * abs(y), 1e3 * z
    from_cylinder = abs(y % 100 - 50)
    spark_plug = x < 15 and from_cylinder < 20
    rib = x < 30 and from_cylinder > 42.5 and y < 150
    jacket = x < 60 and y < 185 and JACKET[0] < z < JACKET[1] and not spark_plug and not rib
    port = x > 15 and from_cylinder < 20 and PORTS[0] < z < PORTS[1]
    return not jacket and not port


def rigid_body(nodes, bricks):
    """Mass, centre of mass, and moments of inertia about x and y through it."""
    middles = np.array([nodes[corners].mean(axis=0) for corners, _ in bricks])
    edges = np.array([edges for _, edges in bricks])
    masses = hollow_beam.DENSITY * edges.prod(axis=1)
    centre = masses @ middles / masses.sum()
    squares = masses @ ((middles - centre) ** 2 + edges**2 / 12)
    return masses.sum(), centre, squares.sum() - squares[:2]


def main(folder, finer=1):
    marks = [np.interp(np.arange(finer * (len(mark) - 1) + 1) / finer, np.arange(len(mark)), mark) / 1e3 for mark in (ACROSS, ALONG, UP)]
    nodes, bricks = hollow_beam.mesh(marks, solid)
    mass, centre, inertia = rigid_body(nodes, bricks)
    hollow_beam.write_model(folder, nodes - centre, bricks)
    print(f"{len(nodes)} nodes, {mass:.3f} kg, {inertia[0]:.4f} kg m2 about x, {inertia[1]:.4f} kg m2 about y")
    print(f"centre of mass {1e3 * centre[2]:.1f} mm above the deck")


if __name__ == "__main__":
    main(sys.argv[1], *map(int, sys.argv[2:]))
