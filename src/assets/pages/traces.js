// Plots over one time axis, which they share with the mechanism, and spectra.

/** How blows are marked, by kind: colour, shape of the mark. */
const MARKS = { first_impact: ['#b23a48', 'square'], stroke_impact: ['#b23a48', 'square'], settling: ['#c9a227', 'down'], periodic: ['#2a7f62', 'down'], blank: ['#55606e', 'cross'] };

/** The part of the time that plots show, the time under the pointer, and that of the mechanism. */
class View {
  constructor(end, shortest) { Object.assign(this, { end, shortest, from: 0, to: end, now: 0, pointed: null, listeners: [], followers: [] }); }
  /** `moved` is called when other times are shown, `marked` when a mark of a time moves. */
  watch(moved, marked) { this.listeners.push(moved); this.followers.push(marked); }
  show(from, to) {
    const length = Math.max(this.shortest, Math.min(this.end, to - from)), middle = (from + to) / 2;
    this.from = Math.max(0, Math.min(this.end - length, to - from === length ? from : middle - length / 2));
    this.to = this.from + length;
    this.listeners.forEach((listener) => listener());
  }
  zoom(factor, about = (this.from + this.to) / 2) { this.show(about - (about - this.from) * factor, about + (this.to - about) * factor); }
  pan(share) { const by = Math.max(-this.from, Math.min(this.end - this.to, share * (this.to - this.from))); this.show(this.from + by, this.to + by); }
  all() { this.show(0, this.end); }
  /** Moves the mechanism's time; plots follow when it leaves what they show. */
  seek(time) {
    this.now = Math.max(0, Math.min(this.end, time));
    if (this.now < this.from || this.now > this.to) {
      const length = this.to - this.from, start = this.now - 0.1 * length;
      this.show(start, start + length);
    }
    this.mark();
  }
  point(time) { this.pointed = time; this.mark(); }
  mark() { this.followers.forEach((listener) => listener()); }
}

/** A time in the unit that suits it. */
function timeText(time) { return `${(1000 * time).toFixed(3)} ms`; }

/** A mark of a blow with its point or middle at (x, y). */
function blowMark(painter, kind, x, y) {
  const [color, shape] = MARKS[kind];
  if (shape === 'square') painter.rect(x - 4, y - 4, 8, 8, { fill: color });
  else if (shape === 'down') painter.polygon([x - 4.5, y - 4, x + 4.5, y - 4, x, y + 4], { fill: color });
  else { painter.line([x - 4, y - 4, x + 4, y + 4], { color, width: 1.6 }); painter.line([x - 4, y + 4, x + 4, y - 4], { color, width: 1.6 }); }
}

/** Marks a measured sample that stands out by itself: a ring around it. */
function spikeMark(painter, x, y, color) {
  const ring = Array.from({ length: 13 }, (_, k) => [x + 5 * Math.cos(k * Math.PI / 6), y + 5 * Math.sin(k * Math.PI / 6)]);
  painter.line(ring.flat(), { color, width: 1.2 });
}

/** Pixels that a row of bars of lift-offs takes. */
const BAR = 6;

/** Bars over the times in a view at which a pad carries nothing; what is shorter than a pixel has one. */
function liftedBars(painter, { color, spans, top }, view, px) {
  for (const [from, to] of spans) {
    if (to < view.from || from > view.to) continue;
    const [left, right] = [px(Math.max(from, view.from)), px(Math.min(to, view.to))];
    painter.rect(left, top, Math.max(1, right - left), BAR - 2, { fill: color });
  }
}

/**
 * A plot of signals over the view's time. `curves()`: [{ name, trace, color, dash }]; `scale` turns SI into `unit`; `blows()`: those
 * that are marked. `lifted()`: [{ name, color, spans }], a row of bars each above the curves.
 */
function tracePlot(view, { title, unit, scale = 1, curves, blows = () => [], lifted = () => [], height = 190 }) {
  const legend = (width) => {
    const kinds = [...new Set(blows().map((blow) => blow.kind))].map((kind) => ({ name: words(kind), kind }));
    const entries = [...curves(), ...kinds];
    return legendRows(entries.length > 1 ? entries : [], width - 80);
  };
  const frame = (width, height) => {
    const top = 8 + 17 * legend(width).rows + (blows().length ? 12 : 0) + BAR * lifted().length;
    return { left: 66, top, width: width - 80, height: height - 42 - top };
  };
  const timeAt = (x, box) => Math.max(0, Math.min(view.end, view.from + (x - box.left) / box.width * (view.to - view.from)));
  const place = (time, box) => box.left + (time - view.from) / (view.to - view.from) * box.width;
  let grip = null;
  const figure = new Figure({
    title, height: (width) => height + 17 * legend(width).rows + BAR * lifted().length,
    paint(painter, width, tall) {
      const box = frame(width, tall), shown = curves();
      let [low, high] = [Infinity, -Infinity];
      for (const { trace } of shown) { const [a, b] = trace.range(view.from, view.to); low = Math.min(low, a); high = Math.max(high, b); }
      if (!(low <= high)) [low, high] = [0, 0];
      const pad = (high - low) * 0.05 || Math.abs(high) * 0.05 || 1 / scale;
      const { px, py } = axes(painter, box, { low: 1000 * view.from, high: 1000 * view.to, title: 'time (ms)' }, { low: scale * (low - pad), high: scale * (high + pad), title: unit });
      for (const { trace, color, dash } of shown) {
        for (const points of trace.lines(view.from, view.to, box.width, (time) => px(1000 * time), (value) => py(scale * value))) painter.line(points, { color, dash, width: 1.2 });
      }
      for (const { trace, color } of shown) {
        for (const time of trace.spikes ?? []) if (time >= view.from && time <= view.to) spikeMark(painter, px(1000 * time), py(scale * trace.at(time)), color);
      }
      for (const blow of blows()) if (blow.start_s >= view.from && blow.start_s <= view.to) blowMark(painter, blow.kind, px(1000 * blow.start_s), box.top - 7);
      lifted().forEach(({ color, spans }, k) => liftedBars(painter, { color, spans, top: box.top - BAR * (k + 1) }, view, (time) => px(1000 * time)));
      for (const placed of legend(width).placed) legendEntry(painter, box, placed);
    },
    over(painter, width, tall) {
      const box = frame(width, tall), line = (time, color) => {
        if (time >= view.from && time <= view.to) painter.line([place(time, box), box.top, place(time, box), box.top + box.height], { color });
      };
      line(view.now, ORANGE);
      if (view.pointed !== null) line(view.pointed, '#8a94a0');
      if (grip) painter.rect(Math.min(...grip), box.top, Math.abs(grip[1] - grip[0]), box.height, { fill: BLUE, alpha: 0.15 });
    },
    hover(x, y) {
      const box = frame(this.width, this.tall);
      if (x < box.left || x > box.left + box.width) { view.point(null); return ''; }
      const time = timeAt(x, box), lines = curves().filter(({ trace }) => !Number.isNaN(trace.at(time))).map(({ name, trace }) => `${name}: ${short(scale * trace.at(time))} ${unit}`);
      view.point(time);
      const blow = blows().find((one) => Math.abs(place(one.start_s, box) - x) < 6);
      const off = lifted().filter(({ spans }) => spans.some(([from, to]) => from <= time && time <= to)).map(({ name }) => `${name}: lifted off`);
      return [timeText(time), ...lines, ...off, ...(blow ? [`${words(blow.kind)}, blow ${blow.number} at ${timeText(blow.start_s)}`] : [])].join('\n');
    },
    left() { view.point(null); },
    drag(x0, y0, x1, y1, ended, event) {
      const box = frame(this.width, this.tall);
      if (event.shiftKey) {
        const share = ((this.held ?? x0) - x1) / box.width;
        this.held = ended ? null : x1;
        view.pan(share);
        return;
      }
      if (ended && Math.abs(x1 - x0) < 4) view.seek(timeAt(x1, box));
      else if (ended) view.show(...[timeAt(x0, box), timeAt(x1, box)].sort((a, b) => a - b));
      grip = ended ? null : [x0, x1];
      this.redrawOver();
    },
    wheel(x, y, event) {
      if (event.ctrlKey || event.metaKey) view.zoom(Math.exp(Math.max(-1, Math.min(1, event.deltaY * 0.01))), timeAt(x, frame(this.width, this.tall)));
      else if (event.shiftKey) view.pan(Math.sign(event.deltaX || event.deltaY) * 0.1);
      else return false;
      return true;
    },
  });
  view.watch(() => figure.redraw(), () => { if (figure.near) figure.redrawOver(); });
  return figure;
}

/** Spectra of one phase of a signal: curves of lines `resolution` Hz apart. */
function spectrumPlot(title, curves, unit, scale) {
  const legend = (width) => legendRows(curves.length > 1 ? curves : [], width - 80), most = 1000;
  const frame = (width, height) => {
    const top = 8 + 17 * legend(width).rows;
    return { left: 60, top, width: width - 72, height: height - top - 42 };
  };
  return new Figure({
    title, height: (width) => 180 + 17 * legend(width).rows,
    paint(painter, width, height) {
      let high = 0;
      for (const { values } of curves) for (let k = 1; k < values.length; k++) high = Math.max(high, values[k]);
      const box = frame(width, height), { px, py } = axes(painter, box, { low: 0, high: most, title: 'frequency (Hz)' }, { low: 0, high: scale * high * 1.05 || 1, title: unit });
      for (const { values, resolution, color, dash } of curves) {
        const points = [];
        for (let k = 1; k < values.length; k++) points.push(px(k * resolution), py(scale * values[k]));
        painter.line(points, { color, width: 1.2, dash });
      }
      for (const placed of legend(width).placed) legendEntry(painter, box, placed);
    },
    hover(x) {
      const box = frame(this.width, this.tall), hz = (x - box.left) / box.width * most;
      const told = curves.map(({ name, values, resolution }) => {
        const k = Math.round(hz / resolution);
        if (k <= 0 || k >= values.length) return '';
        return `${curves.length > 1 ? `${name}\n` : ''}${(k * resolution).toFixed(1)} Hz\n${short(scale * values[k])} ${unit}`;
      });
      return told.filter(Boolean).join('\n');
    },
  });
}
