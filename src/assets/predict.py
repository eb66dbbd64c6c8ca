"""Predict rows with a model that `decore surrogate DATASET --output model.parquet` wrote. Needs NumPy alone: `pip install numpy`.

    python predict.py model.parquet rows.csv predicted.csv

The rows need a column for each factor, named like the factor, or `factor_` and its name. Separate cells by commas. Files that end in .parquet are
read and written with pyarrow, if it is installed. In a program: `model = load("model.parquet")`, then `predict(model, {"pressure": [5.0, 5.5], ...})`.
"""

import csv
import json
import re
import struct
import sys

import numpy as np


def _whole(data, at):
    """Read a variable-length whole number of Thrift's compact protocol; return it and the place behind it."""
    number = shift = 0
    while True:
        byte = data[at]
        number |= (byte & 127) << shift
        at, shift = at + 1, shift + 7
        if byte < 128:
            return number, at


def _value(data, at, kind):
    """Read a value of Thrift's compact protocol; return it and the place behind it."""
    if kind in (1, 2):
        return kind == 1, at
    if kind == 3:
        return data[at], at + 1
    if kind in (4, 5, 6):
        number, at = _whole(data, at)
        return (number >> 1) ^ -(number & 1), at
    if kind == 7:
        return struct.unpack_from("<d", data, at)[0], at + 8
    if kind == 8:
        size, at = _whole(data, at)
        return data[at : at + size], at + size
    if kind in (9, 10):
        head, at = data[at], at + 1
        size, at = (head >> 4, at) if head >> 4 < 15 else _whole(data, at)
        values = []
        for _ in range(size):
            value, at = _value(data, at, head & 15)
            values.append(value)
        return values, at
    if kind == 12:
        return _fields(data, at)
    raise ValueError(f"Thrift type {kind} is not supported")


def _fields(data, at):
    """Read a structure of Thrift's compact protocol as values by field number; return it and the place behind it."""
    fields, number = {}, 0
    while data[at] != 0:
        head, at = data[at], at + 1
        step, at = (head >> 4, at) if head >> 4 else _value(data, at, 4)
        number = number + step if head >> 4 else step
        fields[number], at = _value(data, at, head & 15)
    return fields, at + 1


def _numbers(data, column):
    """Read the numbers of a column chunk: pages without compression, dictionary and nulls, as decore writes a model."""
    # ColumnMetaData: 1 type, 4 codec, 5 values, 9 first page. Types: 2 INT64, 5 DOUBLE.
    kind, codec, count, at = (column[field] for field in (1, 4, 5, 9))
    if codec != 0 or kind not in (2, 5):
        raise ValueError("the model was compressed or changed by another program: write it again with `decore surrogate --output`")
    pages, found = [], 0
    while found < count:
        # PageHeader: 3 size, 5 data page; of that 1 values, 2 encoding (0 plain).
        page, at = _fields(data, at)
        if page.get(5, {}).get(2) != 0:
            raise ValueError("the model was encoded by another program: write it again with `decore surrogate --output`")
        pages.append(np.frombuffer(data, "<i8" if kind == 2 else "<f8", page[5][1], at))
        at, found = at + page[3], found + page[5][1]
    return np.concatenate(pages).astype(float) if pages else np.zeros(0)


def load(path):
    """Load a model: its figures and columns."""
    with open(path, "rb") as file:
        data = file.read()
    if len(data) < 12 or data[:4] != b"PAR1" or data[-4:] != b"PAR1":
        raise ValueError(f"{path} is not a model: expected a file that `decore surrogate --output` wrote")
    # FileMetaData: 4 row groups, 5 key-values. RowGroup: 1 columns. ColumnChunk: 3 ColumnMetaData; of that 3 is the path.
    footer, _ = _fields(data, len(data) - 8 - int.from_bytes(data[-8:-4], "little"))
    entries = {entry[1]: entry.get(2, b"") for entry in footer.get(5, [])}
    if b"decore.surrogate" not in entries:
        raise ValueError(f"{path} is not a model: it has no entry `decore.surrogate`")
    figures = json.loads(entries[b"decore.surrogate"])["surrogate"]
    parts = {}
    for group in footer[4]:
        for chunk in group[1]:
            parts.setdefault(b".".join(chunk[3][3]).decode(), []).append(_numbers(data, chunk[3]))
    columns = {name: np.concatenate(part) for name, part in parts.items()}
    scaled = [columns[f"scaled_{factor['name']}"] for factor in figures["factors"]]
    return {"figures": figures, "columns": columns, "points": np.column_stack(scaled)}


# Weights of rows are large numbers of both signs, and the variance at a place is a small difference of large numbers. The last digit of an
# exponential or a sum would therefore show. So functions, sums and factorisation repeat decore's operations one by one. There are no matrix
# products, because libraries sum in their own order.
_LN_2 = (0.6931471803691238, 1.9082149292705877e-10)


def _exp(x):
    """Exponential function from basic operations."""
    rounding = 6755399441055744.0
    x = np.clip(x, -700.0, 700.0)
    k = (x * 1.4426950408889634 + rounding) - rounding
    r = (x - k * _LN_2[0]) - k * _LN_2[1]
    square = r * r
    even, odd = np.full_like(x, 1.0 / 479001600.0), np.full_like(x, 1.0 / 6227020800.0)
    for of_even, of_odd in ((3628800.0, 39916800.0), (40320.0, 362880.0), (720.0, 5040.0), (24.0, 120.0), (2.0, 6.0), (1.0, 1.0)):
        even, odd = even * square + 1.0 / of_even, odd * square + 1.0 / of_odd
    return np.ldexp(even + r * odd, k.astype(int))


def _ln(x):
    """Natural logarithm of positive numbers from basic operations."""
    mantissa, exponent = np.frexp(np.maximum(x, 2.2250738585072014e-308))
    mantissa, exponent = 2.0 * mantissa, exponent - 1.0
    large = mantissa > 1.4142135623730951
    mantissa, exponent = np.where(large, 0.5 * mantissa, mantissa), np.where(large, exponent + 1.0, exponent)
    f = (mantissa - 1.0) / (mantissa + 1.0)
    square = f * f
    total = np.full_like(f, 1.0 / 21.0)
    for odd in (19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0):
        total = total * square + 1.0 / odd
    return exponent * _LN_2[0] + (2.0 * f + (2.0 * f * square * total + exponent * _LN_2[1]))


def _sum(rows, weights):
    """Weighted sum of rows, one after the other."""
    total = np.zeros(rows.shape[1])
    for row, weight in zip(rows, weights):
        total = total + row * weight
    return total


def _scaled(factor, values):
    """Return values scaled to a factor's range (0 to 1; for names their number), and whether they lie outside the range or beyond the rows."""
    if factor["names"]:
        # Names can be numbers in a table of another program.
        values = [str(int(value)) if isinstance(value, float) and value.is_integer() else str(value) for value in values]
        unknown = set(values) - set(factor["names"])
        if unknown:
            raise ValueError(f"{factor['name']}: unknown values {sorted(unknown)}: expected one of {factor['names']}")
        numbers = np.array([factor["names"].index(name) for name in values], dtype=float)
        return numbers, np.array([name in factor.get("unseen", ()) for name in values], dtype=bool)
    values = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(values)):
        raise ValueError(f"{factor['name']}: expected finite numbers")
    low, high = factor["range"]
    slack = 1e-9 * max(high - low, abs(low), abs(high))
    outside = (values < low - slack) | (values > high + slack)
    ends = np.asarray(factor.get("covered") or factor["range"], dtype=float)
    if factor["logarithmic"]:
        values, low, high, ends = (_ln(np.asarray(value, dtype=float)) for value in (values, low, high, ends))
    values, (first, last) = ((x - low) / (high - low) if high > low else np.zeros(len(x)) for x in (values, ends))
    slack = 0.1 * (last - first) + 1e-9
    return values, outside | (values < first - slack) | (values > last + slack)


def _correlations(process, nominal, a, b):
    """Correlations of the places a with the places b."""
    squared = np.zeros((len(a), len(b)))
    for k, weight in enumerate(process["weights"]):
        difference = a[:, k][:, None] - b[:, k][None, :]
        squared += weight * ((difference != 0.0) if nominal[k] else difference * difference)
    if process["kernel"] == "squared_exponential":
        return _exp(-0.5 * squared)
    s = np.sqrt(5.0 * squared)
    return (1.0 + s + s * s / 3.0) * _exp(-s)


def _cholesky(matrix):
    """Lower Cholesky factor; products are subtracted one by one."""
    for k in range(len(matrix)):
        matrix[k, k] = np.sqrt(matrix[k, k])
        below = matrix[k + 1 :, k]
        below /= matrix[k, k]
        for first in range(k + 1, len(matrix), 256):
            # Only the lower triangle, in blocks of columns.
            columns = below[first - k - 1 : first - k + 255]
            matrix[first:, first : first + 256] -= below[first - k - 1 :, None] * columns
    return matrix


def _solve(factor, sides):
    """Forward substitution for the columns of sides; products are subtracted one by one."""
    for k in range(len(factor)):
        sides[k] /= factor[k, k]
        sides[k + 1 :] -= factor[k + 1 :, k][:, None] * sides[k]
    return sides


def _process(model, process, name, places):
    """Mean and standard deviation, noise included, of a Gaussian process."""
    values = model["columns"][name]
    known = ~np.isnan(values)
    points, weights = model["points"][known], model["columns"][f"{name}_weight"][known]
    nominal = [bool(factor["names"]) for factor in model["figures"]["factors"]]
    matrix = _correlations(process, nominal, points, points)
    spread, runs = process.get("spread", 0.0), model["columns"].get(f"{name}_runs", np.ones(len(known)))[known]
    np.fill_diagonal(matrix, 1.0 + process["noise"] + spread / runs)
    factor = _cholesky(matrix)
    ones = _solve(factor, np.ones((len(points), 1)))
    total = _sum(ones, ones[:, 0])[0]
    mean, std_dev = np.empty(len(places)), np.empty(len(places))
    for first in range(0, len(places), 256):
        part = slice(first, first + 256)
        near = _correlations(process, nominal, points, places[part])
        mean[part] = process["mean"] + _sum(near, weights)
        explained = _solve(factor, near)
        rest = 1.0 - _sum(explained, ones[:, 0])
        share = np.maximum(1.0 - _sum(explained, explained), 0.0) + rest * rest / total + (process["noise"] + spread)
        std_dev[part] = np.sqrt(process["variance"] * share)
    return mean, std_dev


def _far(model, places):
    """Return whether places are far from all rows of the models."""
    figures, columns = model["figures"], model["columns"]
    modelled = [~np.isnan(columns[output["output"]]) for output in figures["outputs"] if output["process"] is not None]
    if figures.get("covered_distance") is None or not modelled:
        return np.zeros(len(places), dtype=bool)
    points, nominal = model["points"][np.any(modelled, axis=0)], [bool(factor["names"]) for factor in figures["factors"]]
    far = np.empty(len(places), dtype=bool)
    for first in range(0, len(places), 256):
        part, squared = slice(first, first + 256), 0.0
        for k, names in enumerate(nominal):
            difference = points[:, k][:, None] - places[part, k][None, :]
            squared = squared + ((difference != 0.0) if names else difference * difference)
        far[part] = np.sqrt(squared.min(axis=0)) > figures["covered_distance"]
    return far


def _identifier(name):
    """Return a name as part of a column's name: letters, digits and underscores, first a letter."""
    safe = re.sub("[^A-Za-z0-9]", "_", name)
    return safe if re.match("[A-Za-z]", safe) else f"n_{safe}"


def _column(rows, name):
    """Return the name of the column with the values of a factor."""
    written = [c for wanted in (_identifier(f"factor_{name}"), f"factor_{_identifier(name)}") for c in rows if _identifier(c) == wanted]
    own = [name] if name in rows else []
    if own and name.startswith("factor_"):
        written = []
    if own and written:
        raise ValueError(f"both columns `{name}` and `{written[0]}` exist: rename the one that is not the factor")
    if not own and not written:
        raise ValueError(f"column `{name}` (or `factor_{name}`) is missing; columns: {', '.join(rows)}")
    return (own or written)[0]


def predict(model, rows):
    """Return for each output its expected value, standard deviation, interval and, if rows failed, the probability of success."""
    figures = model["figures"]
    cells = [rows[_column(rows, factor["name"])] for factor in figures["factors"]]
    scaled, outside = zip(*(_scaled(factor, values) for factor, values in zip(figures["factors"], cells)))
    places = np.column_stack(scaled)
    found = {"outside": np.any(outside, axis=0) | _far(model, places)}
    for output in figures["outputs"]:
        process, success, name = output["process"], output["success"], output["output"]
        if process is None:
            continue
        least = min(q2 for q2 in (process["q2"], process["q2_folds"]) if q2 is not None)
        if not least >= figures["least_q2"]:
            print(f"{name}: Q2 {least:.3f} is below {figures['least_q2']}: do not rely on it", file=sys.stderr)
        mean, std_dev = _process(model, process, name, places)
        reach = process["reach"] * std_dev
        found |= {name: mean, f"{name}_std_dev": std_dev, f"{name}_low": mean - reach, f"{name}_high": mean + reach}
        if success is None:
            continue
        if success["process"] is None:
            found[f"{name}_probability"] = np.full(len(places), success["everywhere"])
            continue
        (slope, offset), (m, s) = success["scaling"], _process(model, success["process"], f"{name}_success", places)
        margin = (slope * m + offset) / np.sqrt(1.0 + np.pi / 8.0 * (slope * s) ** 2)
        found[f"{name}_probability"] = 1.0 / (1.0 + np.exp(-margin))
    return found


def _pyarrow(path):
    """Import pyarrow and its module for Parquet, or explain what to do without it."""
    try:
        import pyarrow
        import pyarrow.parquet as parquet
    except ImportError:
        raise ValueError(f"{path}: Parquet needs pyarrow: run `pip install pyarrow`, or use a CSV file") from None
    return pyarrow, parquet


def _read(path):
    """Return the columns of a file by name; columns of CSV stay texts, because a name can look like a number."""
    if path.endswith(".parquet"):
        return _pyarrow(path)[1].read_table(path).to_pydict()
    with open(path, newline="", encoding="utf-8-sig") as file:
        reader = csv.reader(file)
        lines = [(reader.line_num, [cell.strip() for cell in line]) for line in reader if line]
    if not lines:
        raise ValueError(f"{path} is empty: expected a line of column names, then rows")
    (_, header), *rows = lines
    for name in header:
        if header.count(name) > 1:
            raise ValueError(f"{path}: {header.count(name)} columns are named `{name}`: rename all but one")
    for number, row in rows:
        if len(row) != len(header):
            raise ValueError(f"{path}, line {number}: {len(row)} cells, expected {len(header)} as in the first line")
    return {name: [row[place] for _, row in rows] for place, name in enumerate(header)}


def main(model, rows, output):
    """Predict the rows of a file."""
    found = predict(load(model), _read(rows))
    print(f"{int(found['outside'].sum())} of {len(found['outside'])} rows lie outside the factors' ranges or far from the model's rows", file=sys.stderr)
    if output.endswith(".parquet"):
        pyarrow, parquet = _pyarrow(output)
        parquet.write_table(pyarrow.table(found), output)
        return
    with open(output, "w", newline="", encoding="utf-8") as file:
        cells = ([str(value).lower() if isinstance(value, bool) else value for value in values.tolist()] for values in found.values())
        csv.writer(file, lineterminator="\n").writerows([list(found), *zip(*cells)])


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("error: expected three files: python predict.py model.parquet rows.csv predicted.csv")
    try:
        main(*sys.argv[1:])
    except (OSError, ValueError) as error:
        sys.exit(f"error: {error}")
