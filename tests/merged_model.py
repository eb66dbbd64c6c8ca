"""Merges a machine and an elastic casting into one finite element model with SciPy, independent of decore.

The machine is a frame of beams on clamped feet, the casting the hollow beam of the guide, coarse, on three springs. Writes the matrices of
both, a study that uses them (study.toml), and what the merged model does (merged.json): natural frequencies, and static flexibilities and
undamped receptances between points, each by its motion along the strike.

    python merged_model.py GUIDE_FOLDER FOLDER

Needs numpy and scipy.
"""

import json
import pathlib
import sys

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import eigsh, splu

# Tube of steel: N/m2, kg/m3, m2, m4.
YOUNG, SHEAR, DENSITY, AREA, BENDING, TORSION = 2.1e11, 8.1e10, 7850.0, 1.9e-3, 1.6e-6, 2.4e-6
# Feet first; no two nodes are each other's mirror image, so every mode moves some point.
PLACES = {
    "F1": (0.0, 0.0, 0.0), "F2": (0.9, 0.05, 0.0), "F3": (0.85, 0.72, 0.0), "F4": (-0.04, 0.64, 0.0),
    "T1": (0.02, 0.03, 0.8), "T2": (0.88, 0.04, 0.82), "T3": (0.83, 0.7, 0.79), "T4": (0.0, 0.61, 0.81),
    "S1": (0.4, 0.3, 0.83), "S2": (0.52, 0.33, 0.8), "S3": (0.45, 0.41, 0.81), "M1": (0.47, 0.36, 1.6), "A1": (0.05, 0.6, 1.55),
}  # fmt: skip
BEAMS = [
    "F1 T1", "F2 T2", "F3 T3", "F4 T4", "T1 T2", "T2 T3", "T3 T4", "T4 T1", "T1 S1", "T2 S2", "T3 S3", "S1 S2", "S2 S3", "T4 S3",
    "T4 A1", "A1 M1", "T1 A1",
]  # fmt: skip
GUIDE_KG = 1.0
RADIUS = 0.0125
# Fixtures: machine's point, x and y from the casting's centre of mass, stiffness in N/m.
FIXTURES = {"a": ("S1", (-0.06, -0.008), 5e6), "b": ("S2", (0.055, -0.012), 8e6), "c": ("S3", (0.01, 0.012), 6.5e6)}
STRIKE, CORE = (0.021, 0.004), (-0.031, 0.0, 0.0202)


def beam(start, end):
    """Stiffness and consistent mass of a beam (Euler, Bernoulli) between two places, 12 x 12."""
    along = np.subtract(end, start)
    length = np.linalg.norm(along)
    stiffness, mass = np.zeros((12, 12)), np.zeros((12, 12))
    bar = np.array([[1, -1], [-1, 1]]) / length
    shares = DENSITY * AREA * length / 420 * np.array([[140, 70], [70, 140]])
    polar = 2 * BENDING / AREA
    for (first, second), rigidity, inertia in (((0, 6), YOUNG * AREA, 1.0), ((3, 9), SHEAR * TORSION, polar)):
        place = np.ix_((first, second), (first, second))
        stiffness[place] += rigidity * bar
        mass[place] += inertia * shares
    bend = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], float)
    heavy = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]], float)
    for places, sign in (((1, 5, 7, 11), 1), ((2, 4, 8, 10), -1)):
        scale = np.array([1, sign * length, 1, sign * length])
        stiffness[np.ix_(places, places)] += YOUNG * BENDING / length**3 * bend * np.outer(scale, scale)
        mass[np.ix_(places, places)] += DENSITY * AREA * length / 420 * heavy * np.outer(scale, scale)
    first = along / length
    other = np.cross((0.3, 0.9, 0.2), first)
    axes = np.array([first, other / np.linalg.norm(other), np.cross(first, other / np.linalg.norm(other))])
    turn = np.kron(np.eye(4), axes)
    return turn.T @ stiffness @ turn, turn.T @ mass @ turn


def machine():
    """Stiffness and mass of the frame without its feet, and the first row of each point."""
    nodes, ends = {name: np.array(place) for name, place in PLACES.items()}, []
    for name in BEAMS:
        one, other = name.split()
        middle = name.replace(" ", "_")
        nodes[middle] = 0.45 * nodes[one] + 0.55 * nodes[other]
        ends += [(one, middle), (middle, other)]
    number = {name: index for index, name in enumerate(nodes)}
    order = 6 * len(nodes)
    stiffness, mass = np.zeros((order, order)), np.zeros((order, order))
    for pair in ends:
        place = np.ravel([6 * number[name] + np.arange(6) for name in pair])
        for matrix, part in zip((stiffness, mass), beam(*(nodes[name] for name in pair))):
            matrix[np.ix_(place, place)] += part
    feet = 6 * 4
    rows = {name: 6 * number[name] - feet for name in PLACES if not name.startswith("F")}
    return stiffness[feet:, feet:], mass[feet:, feet:], rows


def casting(guide):
    """Stiffness and mass of the coarse beam, and its nodes from the centre of mass."""
    sys.path.insert(0, str(guide))
    import hollow_beam

    nodes, bricks = hollow_beam.beam(along=8, wall=1, core=2)
    order = 3 * len(nodes)
    stiffness, mass = np.zeros((order, order)), np.zeros((order, order))
    for corners, edges in bricks:
        place = np.ravel([3 * corner + np.arange(3) for corner in corners])
        for matrix, part in zip((stiffness, mass), hollow_beam.brick(edges)):
            matrix[np.ix_(place, place)] += part
    return (stiffness + stiffness.T) / 2, (mass + mass.T) / 2, np.array(nodes)


def area(nodes, place):
    """Weights of the nodes around a place: (1 - (d/r)^2)^2 times a plane, with sum 1 and centre at x and y."""
    apart = (nodes - place) / RADIUS
    near = np.maximum(1 - (apart**2).sum(axis=1), 0) ** 2
    plane = np.column_stack([np.ones(len(nodes)), apart[:, 0], apart[:, 1]])
    factors = np.linalg.pinv(plane.T @ (near[:, None] * plane), rcond=1e-9)[0]
    weights = near * (plane @ factors)
    return weights / weights.sum()


def surface(nodes, at, highest):
    near = nodes[np.hypot(*(nodes[:, :2] - at).T) <= RADIUS]
    return area(nodes, np.array([*at, near[:, 2].max() if highest else near[:, 2].min()]))


def write_matrix(path, matrix):
    rows, columns = np.nonzero(np.tril(matrix))
    lines = [f"{row + 1} {column + 1} {matrix[row, column]:.17g}" for row, column in zip(rows, columns)]
    head = f"%%MatrixMarket matrix coordinate real symmetric\n{len(matrix)} {len(matrix)} {len(lines)}\n"
    path.write_text(head + "\n".join(lines) + "\n")


def write_study(folder, rows, mass_kg):
    table = ["name,role,x_m,y_m,z_m,first_row_0based,dofs"]
    for name, row in rows.items():
        role = "mount" if name.startswith("M") else "fixture"
        table.append(f"{name},{role},{','.join(map(repr, PLACES[name]))},{row},6")
    (folder / "points.csv").write_text("\n".join(table) + "\n")
    fixtures = "".join(
        f'[casting.beam.fixture.{name}]\npoint = "{point}"\nat_m = {list(at)}\nstiffness_n_per_m = {stiffness:.1f}\n'
        "damping_n_s_per_m = 0.0\n"
        for name, (point, at, stiffness) in FIXTURES.items()
    )
    (folder / "study.toml").write_text(f"""duration_s = 0.1
geometry = "as_given"
[structure]
source = "matrices"
stiffness_file = "frame_k.mtx"
mass_file = "frame_m.mtx"
points_file = "points.csv"
cutoff_hz = 1e7
fixed_interface_cutoff_hz = 1e7
damping_ratio = 0.0
housings = "included"
[hammer.one]
mount = "M1"
supply_bar = 5.0
strike_point_m = {list(STRIKE)}
parameters = {{ guide = {{ mass_kg = {GUIDE_KG} }} }}
[casting.beam]
mass_kg = {mass_kg:.6f}
inertia_kg_m2 = [1e-3, 1e-3]
[casting.beam.structure]
stiffness_file = "beam_k.mtx"
mass_file = "beam_m.mtx"
nodes_file = "nodes.csv"
dofs_per_node = 3
cutoff_hz = 6e5
damping_ratio = 0.0
point_radius_m = {RADIUS}
contact_includes_casting = false
[casting.beam.core.wall]
at_m = {list(CORE)}
{fixtures}""")


def main(guide, folder):
    folder = pathlib.Path(folder)
    frame_k, frame_m, rows = machine()
    beam_k, beam_m, nodes = casting(guide)
    for name, matrix in (("frame_k", frame_k), ("frame_m", frame_m), ("beam_k", beam_k), ("beam_m", beam_m)):
        write_matrix(folder / f"{name}.mtx", matrix)
    lines = [f"{number},{x!r},{y!r},{z!r}" for number, (x, y, z) in enumerate(nodes.tolist(), 1)]
    (folder / "nodes.csv").write_text("node,x,y,z\n" + "\n".join(lines) + "\n")
    write_study(folder, rows, beam_m[::3, ::3].sum())

    first, order = len(frame_k), len(frame_k) + len(beam_k)
    stiffness, mass = np.zeros((order, order)), np.zeros((order, order))
    stiffness[:first, :first], stiffness[first:, first:] = frame_k, beam_k
    mass[:first, :first], mass[first:, first:] = frame_m, beam_m
    # The guide is tied to its mount along the strike.
    mass[rows["M1"] + 2, rows["M1"] + 2] += GUIDE_KG
    points = {"mount": np.zeros(order)}
    points["mount"][rows["M1"] + 2] = 1
    of_beam = {"strike": surface(nodes, STRIKE, True), "core": area(nodes, np.array(CORE))}
    for name, (point, at, spring) in FIXTURES.items():
        support = points[f"support.{name}"] = np.zeros(order)
        support[rows[point] + 2] = 1
        of_beam[f"held.{name}"] = surface(nodes, at, False)
    for name, weights in of_beam.items():
        points[name] = np.zeros(order)
        points[name][first + 2 :: 3] = weights
    for name, (_, _, spring) in FIXTURES.items():
        row = points[f"held.{name}"] - points[f"support.{name}"]
        stiffness += spring * np.outer(row, row)

    names, forces = list(points), np.column_stack(list(points.values()))
    # Three horizontal motions of the casting have no stiffness: held at two nodes, without effect on vertical motion.
    far = int(nodes[:, 0].argmax())
    held = [first, first + 1, first + 3 * far + 1]
    free = np.setdiff1d(np.arange(order), held)
    static = splu(sparse.csc_matrix(stiffness[np.ix_(free, free)])).solve(forces[free])
    values = eigsh(sparse.csc_matrix(stiffness), k=200, M=sparse.csc_matrix(mass), sigma=-1e4, tol=0, return_eigenvectors=False)
    hz = np.sqrt(np.sort(values)[3:]) / (2 * np.pi)
    assert abs(np.sort(values)[2]) < 1e-3 * values.max() and hz[0] > 5
    grid = np.linspace(20.0, 18000.0, 60)
    # (w^2 M - K) x = -F
    answers = [
        forces.T @ splu(sparse.csc_matrix(stiffness - (2 * np.pi * one) ** 2 * mass)).solve(forces) for one in grid
    ]
    result = {
        "points": names,
        "frequencies_hz": hz.tolist(),
        "static_m_per_n": (forces[free].T @ static).tolist(),
        "receptance_hz": grid.tolist(),
        "receptance_m_per_n": [answer.tolist() for answer in answers],
    }
    (folder / "merged.json").write_text(json.dumps(result))


if __name__ == "__main__":
    main(*sys.argv[1:])
