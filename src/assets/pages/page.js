// What all pages share: data out of the page, numbers as text, and figures on canvas that can be saved as SVG.

/** Colours on light and dark paper; what is saved or printed is on light paper. */
const LIGHT = { INK: '#1c2430', SOFT: '#55606e', RULE: '#dfe4ea', GREY: '#b4bdc8', BLUE: '#1f5fa8', ORANGE: '#c8590a', PAPER: '#ffffff' };
const NIGHT = { INK: '#e6eaef', SOFT: '#a3adb9', RULE: '#333b45', GREY: '#69747f', BLUE: '#6ea8e6', ORANGE: '#f0924a', PAPER: '#14181d' };
let INK, SOFT, RULE, GREY, BLUE, ORANGE, PAPER;
const GREY_RGB = [0, 0, 0], BLUE_RGB = [0, 0, 0];
/** Called when the colours have changed: what was drawn before is forgotten. */
const dressed = new Set();

/** Takes the colours of dark or light paper. */
function dress(dark) {
  ({ INK, SOFT, RULE, GREY, BLUE, ORANGE, PAPER } = dark ? NIGHT : LIGHT);
  Object.assign(GREY_RGB, rgbOf(GREY));
  Object.assign(BLUE_RGB, rgbOf(BLUE));
  dressed.forEach((forget) => forget());
}

/** Red, green and blue of `#rrggbb`. */
function rgbOf(color) { return [1, 3, 5].map((at) => parseInt(color.slice(at, at + 2), 16)); }

const night = matchMedia('(prefers-color-scheme: dark)');
dress(night.matches);
night.addEventListener('change', () => { dress(night.matches); figures.forEach((figure) => figure.renew()); });

const words = (name) => name.replaceAll('_', ' ');
const meta = JSON.parse(document.getElementById('meta').textContent);
const body = document.getElementById('page');
const FONT = 'system-ui,-apple-system,"Segoe UI",sans-serif';

/** An element; texts become text nodes, so that names from files of others are shown as they are. */
function el(tag, attributes, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name.startsWith('on')) node.addEventListener(name.slice(2), value);
    else if (name in node && typeof value !== 'string') node[name] = value;
    else node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}

function section(title, ...content) {
  const node = el('section', {}, el('h2', {}, title), ...content);
  body.append(node);
  return node;
}

function note(text) { return el('p', { class: 'note' }, text); }

/** Where the page's figures come from; `content` stands before it. */
function provenance(meta, ...content) {
  const facts = [['study', meta.title], ['study hash', meta.study_hash], ['seed', String(meta.seed)], ['program', `decore ${meta.version}`], ['set over the study', meta.overrides.join('; ') || 'nothing'], ...meta.inputs.map(([name, hash]) => [`file ${name}`, hash])];
  const lines = facts.map(([name, value]) => el('tr', {}, el('td', { class: 'text' }, name), el('td', { class: 'text' }, value)));
  section(content.length ? 'Energy residuals and provenance' : 'Provenance', ...content, el('table', {}, ...lines), el('details', {}, el('summary', {}, 'Text of the study'), el('pre', {}, meta.study_text)));
}

/** A select with a label before it. `options`: [value, text]. */
function choice(label, options, value, changed) {
  const select = el('select', { onchange: () => changed(select.value) });
  for (const [key, text] of options) select.append(el('option', { value: String(key) }, text));
  select.value = String(value);
  return el('label', {}, label, select);
}

/** The bytes of a block of base64 in the page. */
function bytesOf(id) {
  const text = document.getElementById(id).textContent.trim();
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

/** A number to four significant digits; with an exponent only where it would be long. */
function short(value) {
  if (value === 0) return '0';
  if (!Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size < 1e-3 || size >= 1e7) return value.toExponential(3).replace('e+', 'e');
  const rounded = Number(size.toPrecision(4));
  return value.toFixed(Math.max(0, 3 - Math.floor(Math.log10(rounded))));
}

/** A number as the sentence has it: no zeros at the end. */
function brief(value) {
  const size = Math.abs(value);
  return size >= 1e-3 && size < 1e7 ? String(Number(value.toPrecision(4))) : short(value);
}

function withUnit(value, unit) {
  return unit && unit !== '1' ? `${value} ${unit}` : value;
}

/** A name of a quantity with its unit in brackets. */
function titled(label, unit) {
  return unit && unit !== '1' ? `${label} (${unit})` : label;
}

/** About `count` round numbers from `low` to `high`. */
function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const raw = (high - low) / Math.max(1, count), power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((m) => m * power >= raw * 0.999) || 10);
  const marks = [];
  if (count < 16 && Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) < 1) return ticks(low, high, 2 * count);
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++) marks.push(i * step);
  return marks;
}

/** The place of values on an axis { log, domain }, 0 to 1, and the value at a place. */
function scaled({ log, domain: [low, high] }) {
  if (!log) return (v) => (v - low) / (high - low || 1);
  const [base, span] = [Math.log(low), Math.log(high / low) || 1];
  return (v) => (Math.log(v) - base) / span;
}
function valueAt({ log, domain: [low, high] }, part) { return log ? low * (high / low) ** part : low + part * (high - low); }

/** Marks of an axis of logarithms with their texts, [value, text]: decades, and 2 and 5 between them where there is room. */
function logTicks(low, high, count) {
  const from = Math.floor(Math.log10(low)), to = Math.ceil(Math.log10(high)), decades = to - from + 1, marks = [];
  const within = (steps) => steps.filter((v) => v >= low * (1 - 1e-9) && v <= high * (1 + 1e-9));
  for (const parts of [[1], [1, 3], [1, 2, 5]]) {
    const found = within(Array.from({ length: decades }, (_, k) => parts.map((part) => part * 10 ** (from + k))).flat());
    if (found.length <= Math.max(2, count) || !marks.length) marks.splice(0, marks.length, ...found);
  }
  const text = (v) => (v >= 1e5 || v < 1e-3 ? String(Number(v.toPrecision(1)).toExponential()).replace('e+', 'e') : String(Number(v.toPrecision(3))));
  return marks.length > 1 ? marks.map((v) => [v, text(v)]) : zip(ticks(low, high, count));
}

/** Texts of ticks: as many decimals as their distance needs. */
function tickTexts(marks) {
  const step = marks.length > 1 ? Math.abs(marks[1] - marks[0]) : Math.abs(marks[0]) || 1;
  const largest = Math.max(...marks.map(Math.abs));
  if (largest >= 1e6 || (largest > 0 && largest < 1e-3)) return marks.map((m) => (m === 0 ? '0' : String(Number(m.toPrecision(4)).toExponential()).replace('e+', 'e')));
  const decimals = Math.min(8, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
  return marks.map((m) => (Math.abs(m) < step * 1e-9 ? 0 : m).toFixed(decimals));
}

/** Draws on a canvas. Its sister [SvgPainter] writes the same as SVG. */
class CanvasPainter {
  constructor(context) { this.context = context; }
  line(points, { color = INK, width = 1, alpha = 1, dash = [] } = {}) {
    const c = this.context;
    c.globalAlpha = alpha; c.strokeStyle = color; c.lineWidth = width; c.lineJoin = 'round'; c.setLineDash(dash);
    c.beginPath();
    for (let i = 0; i < points.length; i += 2) i ? c.lineTo(points[i], points[i + 1]) : c.moveTo(points[0], points[1]);
    c.stroke();
    c.globalAlpha = 1;
  }
  rect(x, y, width, height, { fill, stroke, alpha = 1 } = {}) {
    const c = this.context;
    c.globalAlpha = alpha; c.setLineDash([]); c.lineWidth = 1;
    if (fill) { c.fillStyle = fill; c.fillRect(x, y, width, height); }
    if (stroke) { c.strokeStyle = stroke; c.strokeRect(x, y, width, height); }
    c.globalAlpha = 1;
  }
  /** Discs at [x, y, x, y, ...]. */
  dots(points, radius, { color = BLUE, alpha = 1 } = {}) {
    const c = this.context;
    c.globalAlpha = alpha; c.fillStyle = color;
    for (let i = 0; i < points.length; i += 2) {
      c.beginPath(); c.arc(points[i], points[i + 1], radius, 0, 2 * Math.PI); c.fill();
    }
    c.globalAlpha = 1;
  }
  text(string, x, y, { color = INK, size = 11, align = 'left', weight = 400, turned = false, halo = false } = {}) {
    const c = this.context;
    c.save();
    c.translate(x, y);
    if (turned) c.rotate(-Math.PI / 2);
    c.font = `${weight} ${size}px ${FONT}`; c.textAlign = align; c.textBaseline = 'middle'; c.fillStyle = color;
    if (halo) { c.strokeStyle = `${PAPER}e0`; c.lineWidth = 3; c.lineJoin = 'round'; c.strokeText(string, 0, 0); }
    c.fillText(string, 0, 0);
    c.restore();
  }
  /** A closed line through [x, y, x, y, ...]. */
  polygon(points, { fill, stroke } = {}) {
    const c = this.context;
    c.setLineDash([]); c.lineWidth = 1;
    c.beginPath();
    for (let i = 0; i < points.length; i += 2) i ? c.lineTo(points[i], points[i + 1]) : c.moveTo(points[0], points[1]);
    c.closePath();
    if (fill) { c.fillStyle = fill; c.fill(); }
    if (stroke) { c.strokeStyle = stroke; c.stroke(); }
  }
  /** A drawn canvas, or the part [x, y, width, height] of it, stretched smoothly over a rectangle. */
  image(canvas, x, y, width, height, part = [0, 0, canvas.width, canvas.height]) { this.context.drawImage(canvas, ...part, x, y, width, height); }
}

/** Writes an SVG of what is drawn; images are embedded. */
class SvgPainter {
  constructor(width, height) { this.parts = []; this.width = width; this.height = height; }
  static escape(text) {
    const names = { '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' };
    return String(text).replace(/[&<>"]/g, (c) => names[c]);
  }
  static at(value) { return Number(value.toFixed(2)); }
  line(points, { color = INK, width = 1, alpha = 1, dash = [] } = {}) {
    const path = Array.from(points, SvgPainter.at).join(' ');
    const dashes = dash.length ? ` stroke-dasharray="${dash.join(' ')}"` : '';
    this.parts.push(`<polyline points="${path}" fill="none" stroke="${color}" stroke-width="${width}" stroke-opacity="${alpha}" stroke-linejoin="round"${dashes}/>`);
  }
  rect(x, y, width, height, { fill = 'none', stroke = 'none', alpha = 1 } = {}) {
    const [a, b, c, d] = [x, y, width, height].map(SvgPainter.at);
    this.parts.push(`<rect x="${a}" y="${b}" width="${c}" height="${d}" fill="${fill}" stroke="${stroke}" opacity="${alpha}"/>`);
  }
  dots(points, radius, { color = BLUE, alpha = 1 } = {}) {
    const at = SvgPainter.at, all = [];
    for (let i = 0; i < points.length; i += 2) all.push(`<circle cx="${at(points[i])}" cy="${at(points[i + 1])}" r="${radius}"/>`);
    this.parts.push(`<g fill="${color}" fill-opacity="${alpha}">${all.join('')}</g>`);
  }
  text(string, x, y, { color = INK, size = 11, align = 'left', weight = 400, turned = false } = {}) {
    const anchor = { left: 'start', center: 'middle', right: 'end' }[align];
    const [a, b] = [SvgPainter.at(x), SvgPainter.at(y)], turn = turned ? ` transform="rotate(-90 ${a} ${b})"` : '';
    this.parts.push(`<text x="${a}" y="${b}" font-size="${size}" font-weight="${weight}" fill="${color}" text-anchor="${anchor}" dominant-baseline="central"${turn}>${SvgPainter.escape(string)}</text>`);
  }
  polygon(points, { fill = 'none', stroke = 'none' } = {}) {
    this.parts.push(`<polygon points="${Array.from(points, SvgPainter.at).join(' ')}" fill="${fill}" stroke="${stroke}"/>`);
  }
  image(canvas, x, y, width, height, part = [0, 0, canvas.width, canvas.height]) {
    const own = el('canvas', { width: part[2], height: part[3] });
    own.getContext('2d').drawImage(canvas, ...part, 0, 0, part[2], part[3]);
    const [a, b, c, d] = [x, y, width, height].map(SvgPainter.at);
    this.parts.push(`<image x="${a}" y="${b}" width="${c}" height="${d}" preserveAspectRatio="none" href="${own.toDataURL('image/png')}"/>`);
  }
  finish() {
    const size = `width="${this.width}" height="${this.height}" viewBox="0 0 ${this.width} ${this.height}"`;
    const family = SvgPainter.escape(FONT);
    return `<svg xmlns="http://www.w3.org/2000/svg" ${size} font-family="${family}"><rect width="100%" height="100%" fill="#fff"/>${this.parts.join('\n')}</svg>\n`;
  }
}

/** Words of a text in at most `most` lines of about `width` characters; what is over ends in an ellipsis. */
function wrapped(text, width, most) {
  const lines = [''];
  for (const word of text.split(' ')) {
    const last = lines[lines.length - 1];
    if (last && last.length + 1 + word.length > width) lines.push(word);
    else lines[lines.length - 1] = last ? `${last} ${word}` : word;
  }
  const cut = (line) => (line.length > width + 2 ? `${line.slice(0, width)}…` : line);
  const shown = lines.slice(0, most).map(cut);
  if (lines.length > most) shown[most - 1] = `${shown[most - 1].slice(0, Math.max(1, width - 1))}…`;
  return shown;
}

/** Saves a text as a file. */
function save(name, text, type) {
  const link = el('a', { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Copies a text; pages opened from a disk may have no clipboard, then by a selection. */
async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = el('textarea', { value: text });
    document.body.append(area);
    area.select();
    document.execCommand('copy');
    area.remove();
  }
  const before = button.textContent;
  button.textContent = 'copied';
  setTimeout(() => { button.textContent = before; }, 1200);
}

const tip = el('div', { class: 'tip', hidden: true, role: 'status' });

/** Shows a text beside the pointer; nothing hides it. */
function hint(event, text) {
  tip.hidden = !text;
  if (!text) return;
  if (!tip.isConnected) document.body.append(tip);
  tip.textContent = text;
  const box = tip.getBoundingClientRect();
  tip.style.left = `${Math.max(4, event.clientX + 14 + box.width > innerWidth ? event.clientX - box.width - 14 : event.clientX + 14)}px`;
  tip.style.top = `${Math.max(4, Math.min(innerHeight - box.height - 4, event.clientY + 14))}px`;
}

/** All figures of the page; one that is out of sight is drawn when it comes near. */
const figures = new Set();
const near = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    const figure = entry.target.figure;
    figure.near = entry.isIntersecting;
    if (figure.near && figure.stale) figure.draw();
  }
}, { rootMargin: '150px' });

/**
 * A figure on canvas with caption and a button that saves it as SVG.
 *
 * `paint(painter, width, height)` draws it; `height` is a number or a function of the width. `still(painter, width, height)` draws on
 * top what stays until [Figure#renew], `over(painter, width, height)` what follows the pointer. `hover(x, y)` returns the text beside the pointer; `drag(x0, y0, x1, y1, ended, event)` is told of a drag
 * and, with equal ends, of a click; `wheel(x, y, event)` of the wheel, and returns whether it was meant. `least()`: the width in pixels below which it is scrolled.
 */
class Figure {
  constructor(options) {
    Object.assign(this, { near: false, stale: true, caption: '', ...options });
    this.canvas = el('canvas', { role: 'img', 'aria-label': options.title });
    const layer = () => el('canvas', { class: 'over', 'aria-hidden': 'true' });
    [this.middle, this.top] = [this.still ? layer() : '', layer()];
    this.heading = el('b', {}, options.title);
    const button = el('button', { type: 'button', title: 'Save as SVG', 'aria-label': `Save as SVG: ${options.title}`, onclick: () => this.saveSvg() }, 'SVG');
    this.node = el('figure', {}, el('figcaption', {}, this.heading, button), el('div', { class: 'paper' }, this.canvas, this.middle, this.top));
    this.node.figure = this;
    this.listen();
    figures.add(this);
    near.observe(this.node);
    new ResizeObserver(() => { if (Math.round(this.node.clientWidth) !== this.room) this.redraw(); }).observe(this.node);
  }
  retitle(title) { this.title = title; this.heading.textContent = title; this.canvas.setAttribute('aria-label', title); }
  /** Draws now if it is in sight, else when it comes there; also what else stays. */
  renew() { this.stood = 0; this.redraw(); }
  /** Draws now if it is in sight, else when it comes there. */
  redraw() { this.stale = true; if (this.near) this.draw(); }
  size(canvas) {
    const scale = Math.max(1, devicePixelRatio || 1);
    const [w, h] = [Math.round(this.width * scale), Math.round(this.tall * scale)];
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    const context = canvas.getContext('2d');
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, this.width, this.tall);
    return new CanvasPainter(context);
  }
  /** Draws in a width; `flat`: on one canvas, as paper needs it, where what lies over another canvas hides it. */
  draw(room = this.node.clientWidth, flat = false) {
    // Too narrow a figure is drawn wider and scrolled; on paper it cannot be.
    const width = Math.max(Math.round(room), flat || !room ? 0 : this.least?.() ?? 0);
    if (!width) return;
    [this.width, this.room] = [width, Math.round(room)];
    for (const layer of [this.canvas, this.middle, this.top]) if (layer) layer.style.width = width > this.room ? `${width}px` : '';
    this.canvas.style.touchAction = width > this.room ? 'auto' : '';
    this.tall = Math.round(typeof this.height === 'function' ? this.height(width) : this.height);
    this.stale = false;
    const ground = this.size(this.canvas);
    this.paint(ground, this.width, this.tall);
    if (this.still && (flat || this.stood !== width)) this.still(flat ? ground : this.size(this.middle), width, this.tall);
    this.stood = flat ? 0 : width;
    this.redrawOver();
  }
  redrawOver() { if (this.over && this.width) this.over(this.size(this.top), this.width, this.tall); }
  svg() {
    if (this.stale) this.draw();
    dress(false);
    const painter = new SvgPainter(this.width, this.tall);
    this.paint(painter, this.width, this.tall);
    this.still?.(painter, this.width, this.tall);
    dress(night.matches);
    return painter.finish();
  }
  saveSvg() { save(`${this.title.replace(/[^\p{L}\p{N}]+/gu, '_')}.svg`, this.svg(), 'image/svg+xml'); }
  listen() {
    let start = null;
    const at = (event) => {
      const box = this.canvas.getBoundingClientRect(), scale = this.width / box.width;
      return [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale];
    };
    this.canvas.addEventListener('pointerdown', (event) => {
      if (event.button !== 0 || !this.drag) return;
      start = at(event);
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener('pointermove', (event) => {
      const point = at(event);
      if (start) { hint(event, ''); this.drag(...start, ...point, false, event); }
      else if (this.hover) hint(event, this.hover(...point));
    });
    const end = (event) => {
      if (start) this.drag(...start, ...at(event), true, event);
      start = null;
    };
    this.canvas.addEventListener('pointerup', end);
    if (this.wheel) this.canvas.addEventListener('wheel', (event) => { if (this.wheel(...at(event), event)) event.preventDefault(); }, { passive: false });
    this.canvas.addEventListener('pointercancel', () => { start = null; });
    this.canvas.addEventListener('pointerleave', (event) => { hint(event, ''); if (this.left) this.left(); });
  }
}

// On paper a figure is as wide as a column of text: its letters keep their size.
const paperWidth = ({ node }) => (node.closest('.grid') ? 215 : node.closest('.pair:not(.one)') ? 338 : 690);
addEventListener('beforeprint', () => { dress(false); figures.forEach((figure) => figure.draw(paperWidth(figure), true)); });
addEventListener('afterprint', () => { dress(night.matches); figures.forEach((figure) => figure.renew()); });

/** Pixels that names below an axis take more when they stand upright. */
const UPRIGHT = 130;

/** Names of an axis with their places, [place, name]: where they would be cut short in `each` pixels every second, third ... alone. */
function named(names, each) {
  const room = 6.2 * Math.min(8, Math.max(...names.map((name) => name.length))) + 4, step = Math.max(1, Math.ceil(room / each));
  return names.map((name, i) => [i, wrapped(name, Math.max(2, Math.floor(step * each / 6.2) - 1), 1)[0]]).filter(([i]) => i % step === 0);
}

/**
 * Axes around a rectangle of a plot. `box`: left, top, width, height; `x` and `y`: { low, high, title, names }, where `names` stand for
 * 0, 1, 2 ... (`turned`: upright, each of them), `log` spaces by logarithms and `whole` marks whole numbers alone. Returns functions from values to pixels.
 */
function axes(painter, box, x, y) {
  const [across, up] = [x, y].map(({ log, low, high }) => scaled({ log, domain: [low, high] }));
  const px = (v) => box.left + across(v) * box.width, py = (v) => box.top + box.height - up(v) * box.height;
  const right = box.left + box.width, bottom = box.top + box.height;
  const marks = (axis, length, each) => {
    if (axis.names) return axis.turned ? axis.names.map((name, i) => [i, wrapped(name, 22, 1)[0]]) : named(axis.names, each);
    if (axis.log) return logTicks(axis.low, axis.high, length / each);
    return zip(ticks(axis.low, axis.high, length / each).filter((mark) => !axis.whole || Number.isInteger(mark)));
  };
  for (const [value, text] of marks(x, box.width, x.names ? box.width / x.names.length : 65)) {
    painter.line([px(value), bottom, px(value), bottom + 4], { color: SOFT });
    if (x.turned) painter.text(text, px(value), bottom + 8, { color: SOFT, size: 10, align: 'right', turned: true });
    else painter.text(text, px(value), bottom + 12, { color: SOFT, size: 10, align: 'center' });
  }
  for (const [value, text] of marks(y, box.height, y.names ? 99 : 34)) {
    painter.line([box.left, py(value), right, py(value)], { color: RULE });
    painter.text(wrapped(text, 8, 1)[0], box.left - 5, py(value), { color: SOFT, size: 10, align: 'right' });
  }
  painter.line([box.left, box.top, box.left, bottom, right, bottom], { color: SOFT });
  if (x.title) painter.text(wrapped(x.title, Math.floor(box.width / 5.8), 1)[0], box.left + box.width / 2, bottom + 27 + (x.turned ? UPRIGHT : 0), { align: 'center' });
  if (y.title) painter.text(wrapped(y.title, Math.floor(box.height / 5.8), 1)[0], Math.max(8, box.left - 56), box.top + box.height / 2, { align: 'center', turned: true });
  return { px, py };
}

function zip(marks) {
  const texts = tickTexts(marks);
  return marks.map((mark, i) => [mark, texts[i]]);
}
