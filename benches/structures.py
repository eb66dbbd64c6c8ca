"""Reduction of a structure by scipy, step by step: the programs that benches/structures.rs is compared with.

python structures.py FOLDER superlu|cholmod MODES

FOLDER holds K and M as raw arrays (K.indptr, K.indices, K.data, ...) and the interface rows (b.rows). Prints one line of JSON:
processor seconds of every step and the peak memory of the process.
"""

import json
import resource
import sys
import time

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, eigsh, splu


def load(folder, name):
    indptr = np.fromfile(f"{folder}/{name}.indptr", dtype=np.int64).astype(np.int32)
    indices = np.fromfile(f"{folder}/{name}.indices", dtype=np.int32)
    data = np.fromfile(f"{folder}/{name}.data", dtype=np.float64)
    return sp.csr_matrix((data, indices, indptr), shape=(len(indptr) - 1,) * 2)


def factorise(k_oo, solver):
    if solver == "superlu":
        factor = splu(k_oo, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        return factor.solve
    from sksparse.cholmod import cholesky

    try:
        return cholesky(k_oo, ordering_method="metis")
    except TypeError:  # another generation of the package
        from sksparse.cholmod import cho_factor

        return cho_factor(k_oo, order="metis").solve


def main():
    folder, solver, modes = sys.argv[1], sys.argv[2], int(sys.argv[3])
    k, m = load(folder, "K"), load(folder, "M")
    b = np.fromfile(f"{folder}/b.rows", dtype=np.int64)
    o = np.setdiff1d(np.arange(k.shape[0]), b)
    steps = {}
    begin = time.process_time()

    def step(name):
        nonlocal begin
        now = time.process_time()
        steps[name] = now - begin
        begin = now

    k_oo, m_oo = k[o][:, o].tocsc(), m[o][:, o].tocsc()
    k_ob, m_ob = k[o][:, b].toarray(), m[o][:, b].toarray()
    step("partition")
    solve = factorise(k_oo, solver)
    step("factor")
    g = -np.asarray(solve(k_ob))
    step("constraint")
    inverse = LinearOperator(k_oo.shape, matvec=lambda x: np.asarray(solve(x)).ravel(), dtype=float)
    values, psi = eigsh(k_oo, k=modes, M=m_oo, sigma=0.0, OPinv=inverse, tol=0)
    step("modes")
    inertia = m_oo @ g + m_ob
    m_qb = psi.T @ inertia
    m_bb = g.T @ inertia + m_ob.T @ g + m[b][:, b].toarray()
    k_bb = k_ob.T @ g + k[b][:, b].toarray()
    step("projection")
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    hz = np.sqrt(np.sort(values)) / (2 * np.pi)
    check = [float(np.abs(m_qb).sum()), float(np.trace(m_bb)), float(np.trace(k_bb))]
    print(json.dumps({"steps": steps, "peak_bytes": peak, "hz": hz.tolist(), "check": check}))


main()
