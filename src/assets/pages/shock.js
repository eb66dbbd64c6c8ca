// Legends of curves, and shock spectra.

const CURVES = ['#2f76c9', '#c8590a', '#2a7f62', '#8a4fa3', '#b23a48', '#7a6a00', '#2c8fae', '#55606e'];
const DASHES = [[], [6, 3], [2, 2], [8, 2, 2, 2], [1, 3], [10, 4], [4, 4]];

/** Entries of a legend as rows that fit a width: [{ x, row, entry }], number of rows. */
function legendRows(entries, width) {
  let [x, row] = [0, 0];
  const placed = entries.map((entry) => {
    const room = 38 + 6.2 * entry.name.length;
    if (x && x + room > width) [x, row] = [0, row + 1];
    const at = { x, row, entry };
    x += room;
    return at;
  });
  return { placed, rows: entries.length ? row + 1 : 0 };
}

/** Draws an entry of a legend: the sample of a line or the mark of a blow, and its name. */
function legendEntry(painter, box, { x, row, entry }) {
  const [left, y] = [box.left + x, 9 + 17 * row];
  if (entry.kind) blowMark(painter, entry.kind, left + 9, y);
  else painter.line([left, y, left + 18, y], { color: entry.color, dash: entry.dash, width: 2 });
  painter.text(entry.name, left + 23, y, { color: SOFT });
}

/** Pseudo-velocities in m/s from which shocks have these grades (Gaberson). */
const GRADES = [[1.3, 'mild'], [2.5, 'moderate'], [7.6, 'very severe']];
const GRADES_TEXT = 'Largest pseudo-velocity of oscillators on each core point, a third of an octave apart. Grades by Gaberson: from 1.3 m/s mild, from 2.5 moderate, from 7.6 very severe.';

/** Spectra over logarithmic axes, with lines at the grades. */
function shockPlot(title, hz, curves) {
  const legend = (width) => legendRows(curves, width - 80), unit = 'pseudo-velocity (m/s)';
  const all = [...curves.flatMap(({ values }) => values.filter((v) => v > 0)), ...GRADES.map(([v]) => v)];
  const low = Math.min(...all) / 1.2, high = Math.max(...all) * 1.2;
  const frame = (width, height) => {
    const top = 8 + 17 * legend(width).rows;
    return { left: 60, top, width: width - 88, height: height - top - 42 };
  };
  return new Figure({
    title, height: (width) => 280 + 17 * legend(width).rows,
    paint(painter, width, height) {
      const box = frame(width, height), { px, py } = axes(painter, box, { low: hz[0], high: hz.at(-1), log: true, title: 'natural frequency (Hz)' }, { low, high, log: true, title: unit });
      for (const [value, text] of GRADES) {
        painter.line([box.left, py(value), box.left + box.width, py(value)], { color: SOFT, dash: [2, 3] });
        painter.text(text, box.left + 4, py(value) - 7, { color: SOFT, size: 10 });
      }
      for (const { values, color, dash } of curves) {
        if (values.every((v) => v > 0)) painter.line(values.flatMap((v, k) => [px(hz[k]), py(v)]), { color, width: 1.4, dash });
      }
      for (const placed of legend(width).placed) legendEntry(painter, box, placed);
    },
    hover(x) {
      const box = frame(this.width, this.tall), place = (x - box.left) / box.width, k = Math.round(place * (hz.length - 1));
      if (k < 0 || k >= hz.length) return '';
      return [`${hz[k].toFixed(0)} Hz`, ...curves.map(({ name, values }) => `${name}: ${short(values[k])} m/s`)].join('\n');
    },
  });
}
