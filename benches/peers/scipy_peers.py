"""SciPy's LSODA and Radau on decore's compiled right-hand side: `scipy_peers.py LIBRARY STUDY TOLERANCE END_S LONGEST_S`.

Prints a line of JSON per method. Contacts follow the state; the first impact is found on the dense output and starts the
gate's clock, supplies and gates are stops. SciPy's own work and the calls through ctypes count: that is what its users have.
"""

import ctypes
import json
import sys
import time

import numpy
import scipy
from scipy.integrate import LSODA, Radau
from scipy.optimize import brentq

DOUBLES = ctypes.POINTER(ctypes.c_double)


def load(path):
    library = ctypes.CDLL(path)
    signatures = {
        "peer_new": (ctypes.c_void_p, [ctypes.c_char_p, ctypes.c_int]),
        "peer_states": (ctypes.c_size_t, [ctypes.c_void_p]),
        "peer_heave": (ctypes.c_size_t, [ctypes.c_void_p]),
        "peer_initial": (None, [ctypes.c_void_p, DOUBLES, DOUBLES]),
        "peer_rhs": (None, [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]),
        "peer_strike": (ctypes.c_double, [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]),
        "peer_first_impact": (ctypes.c_double, [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]),
        "peer_next_stop": (ctypes.c_double, [ctypes.c_void_p, ctypes.c_double]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def run(library, study, method, tolerance, end_s, longest_s):
    problem = library.peer_new(study.encode(), 1)
    states = library.peer_states(problem)
    y, scales = numpy.zeros(states), numpy.zeros(states)
    library.peer_initial(problem, y.ctypes.data_as(DOUBLES), scales.ctypes.data_as(DOUBLES))
    heave = library.peer_heave(problem)
    evaluations = 0

    def rhs(t, y):
        nonlocal evaluations
        evaluations += 1
        rate = numpy.empty(states)
        y = numpy.ascontiguousarray(y)
        library.peer_rhs(problem, t, y.ctypes.data, rate.ctypes.data)
        return rate

    def strike(t, y):
        y = numpy.ascontiguousarray(y)
        return library.peer_strike(problem, t, y.ctypes.data)

    first_impact, peak, steps, t = None, 0.0, 0, 0.0
    begin = time.thread_time()
    while t < end_s:
        stop = min(library.peer_next_stop(problem, t), end_s)
        solver = method(rhs, t, y, stop, rtol=1e-13, atol=tolerance * scales, first_step=1e-6)
        while solver.status == "running":
            if time.thread_time() - begin > longest_s:
                return None, None, steps, evaluations, t, time.thread_time() - begin
            solver.step()
            steps += 1
            t, y = solver.t, solver.y
            dense = solver.dense_output()
            if abs(y[heave]) > 0.7 * peak:
                span = numpy.linspace(solver.t_old, solver.t, 17)
                peak = max(peak, numpy.abs(dense(span)[heave]).max())
            if first_impact is None and strike(t, y) > 0.0:
                t = brentq(lambda t: strike(t, dense(t)), solver.t_old, solver.t, xtol=1e-15)
                y = numpy.ascontiguousarray(dense(t))
                first_impact = library.peer_first_impact(problem, t, y.ctypes.data)
                break
        if solver.status == "failed":
            break
    return first_impact, peak, steps, evaluations, t, time.thread_time() - begin


def main():
    library, study = load(sys.argv[1]), sys.argv[2]
    tolerance, end_s, longest_s = (float(argument) for argument in sys.argv[3:6])
    for method in (LSODA, Radau):
        found = run(library, study, method, tolerance, end_s, longest_s)
        keys = ("first_impact_j", "peak_velocity_m_s", "steps", "evaluations", "reached_s", "cpu_s")
        name = f"SciPy {scipy.__version__} {method.__name__}"
        print(json.dumps({"name": name, **dict(zip(keys, found))}), flush=True)


main()
