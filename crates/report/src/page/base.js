// What all pictures share: the data, the cursor, scales and ticks, numbers for people.

const data = JSON.parse(document.getElementById("data").textContent);
const drawn = [];

// The cursor is a time; every picture over time shows it, and so does the body. The range is that
// of their zoom.
const shared = { time: null, range: null, listeners: [] };

function share(change, redraw) {
  Object.assign(shared, change);
  for (const listener of shared.listeners) listener(redraw);
}

const colour = (style) => `var(--c${style % 8})`;
// Eight colours and four dashes: the ninth curve has the colour of the first, and its own dash.
const dash = (style) => ["", "9 4", "4 3", "11 3 2.5 3"][(style + Math.floor(style / 8)) % 4];

function element(name, attributes, parent, text) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) node.setAttribute(key, attributes[key]);
  if (text !== undefined) node.textContent = text;
  if (parent) parent.appendChild(node);
  return node;
}

function html(name, parent, text, className) {
  const node = document.createElement(name);
  if (text !== undefined) node.textContent = text;
  if (className) node.className = className;
  if (parent) parent.appendChild(node);
  return node;
}

const minus = (text) => text.replace(/-/g, "−");

// Five digits, plain where that is readable.
function figure(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  const size = Math.abs(value);
  if (value !== 0 && (size < 1e-3 || size >= 1e6)) return minus(value.toExponential(3));
  return minus(String(Number(value.toPrecision(5))));
}

// Round steps on a linear axis, about so many, none shorter than `least`.
function linearTicks(low, high, count, least = 0) {
  const raw = Math.max(least, (high - low) / count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= raw * 0.999) || 10 * power;
  const ticks = [];
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const exponent = largest >= 1e5 || largest < 1e-2 ? Math.floor(Math.log10(largest)) : 0;
  const digits = Math.min(12, Math.max(0, Math.ceil(-Math.log10(step) + exponent - 1e-9)));
  for (let index = Math.ceil(low / step - 1e-9); index * step <= high + 1e-9 * step && ticks.length < 60; index++) {
    const value = index * step;
    const text = index === 0 ? "0" : (value / 10 ** exponent).toFixed(digits);
    ticks.push({ value, text: minus(text), power: index !== 0 && exponent ? exponent : null });
  }
  return ticks;
}

// The width of a text of this size, as of wide letters of a sans-serif font.
const nameWidth = (text, size) => 0.6 * size * text.length;

// Whether a line through points passes through a box: left, top, right, bottom.
function crosses(points, [left, top, right, bottom]) {
  for (let k = 1; k < points.length; k++) {
    const [[ax, ay], [bx, by]] = [points[k - 1], points[k]];
    // The part of the segment within the box, from `first` to `last`.
    let [first, last] = [0, 1];
    for (const [from, to, least, most] of [[ax, bx, left, right], [ay, by, top, bottom]]) {
      const [one, other] = [(least - from) / (to - from), (most - from) / (to - from)];
      if (from === to) last = from < least || from > most ? -1 : last;
      else [first, last] = [Math.max(first, Math.min(one, other)), Math.min(last, Math.max(one, other))];
    }
    if (first <= last) return true;
  }
  return false;
}

// A line with its points at least some pixels apart, the last one included.
function sparse(points, apart = 3) {
  const kept = [];
  points.forEach((point, k) => {
    const last = kept[kept.length - 1];
    if (!last || k === points.length - 1 || Math.hypot(point[0] - last[0], point[1] - last[1]) >= apart) {
      kept.push(point);
    }
  });
  return kept;
}

// Decades on a logarithmic axis; values are logarithms.
function logarithmicTicks(low, high, count) {
  const every = Math.max(1, Math.ceil((high - low) / count));
  const ticks = [];
  // A stretch of hardly two decades has ticks between them.
  const digits = high - low < 2.2 ? [1, 2, 5] : [1];
  for (let decade = Math.floor(low); decade <= high; decade++) {
    if (decade % every !== 0) continue;
    for (const digit of digits) {
      const value = decade + Math.log10(digit);
      if (value >= low && value <= high) ticks.push({ value, text: digit === 1 ? "10" : String(digit), power: decade });
    }
  }
  return ticks;
}

// The text of a tick; powers of ten are raised by an absolute size.
function tickText(tick, attributes, parent) {
  const text = element("text", attributes, parent);
  const whole = tick.power === null ? tick.text : tick.text === "10" ? "10" : `${tick.text}·10`;
  text.appendChild(document.createTextNode(whole));
  if (tick.power !== null) {
    element("tspan", { dy: -4, style: "font-size:9px" }, text, minus(String(tick.power)));
  }
}

// The last index at which a sorted list is at most `value`.
function indexAt(list, value) {
  let [low, high] = [0, list.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle] <= value) low = middle; else high = middle - 1;
  }
  return low;
}

// A picture is drawn anew when its width changes; in the next frame, because drawing may change the
// width again.
function onWidth(node, draw) {
  let width = 0;
  const look = () => {
    const now = Math.round(node.clientWidth);
    if (now > 0 && now !== width) {
      width = now;
      draw(width);
    }
  };
  new ResizeObserver(() => requestAnimationFrame(look)).observe(node);
  look();
}
