// Curves over two axes: values at the cursor, zoom along the axis to the right, keys.

// Room around the plot; to the left as much as the numbers take.
const EDGE = { right: 14, top: 12, bottom: 42 };
const NAME = 24;
// The room for the name of a limit, above or below its line.
const LEVEL = 18;

// The place of the name of a limit, by its right end: above or below the line, as far to the right as
// no curve crosses it.
function beside(text, y, [left, right, top, bottom], lines) {
  const width = nameWidth(text, 11);
  const sides = [y - 5, y + 14].filter((below) => below - 12 >= top && below + 3 <= bottom);
  const places = [];
  for (let end = right - 6; end - width > left; end -= 24) for (const below of sides) places.push([end, below]);
  const free = ([end, below]) => lines.every((line) => !crosses(line, [end - width, below - 10, end, below + 2]));
  const [x, below] = places.find(free) || [right - 6, sides[0] ?? y - 5];
  return { x, y: below };
}

function chart(figureNode, picture) {
  const plot = figureNode.querySelector(".plot");
  const overTime = picture.x.label.startsWith("time");
  // There is no half iteration, so no tick at one.
  const counts = picture.x.label.startsWith("iteration");
  const logarithmic = picture.y.log;
  // On a logarithmic axis to the right abscissas are logarithms, and what has none is left out.
  const ratios = picture.x.log;
  const read = (curve) => {
    const x = data.grids[curve.grid];
    if (!ratios) return { ...curve, x };
    const kept = x.map((_, k) => k).filter((k) => x[k] > 0);
    return { ...curve, x: kept.map((k) => Math.log10(x[k])), y: kept.map((k) => curve.y[k]) };
  };
  let curves = picture.curves.map(read);
  const place = (value) => (logarithmic ? (value > 0 ? Math.log10(value) : null) : value);
  // Inputs of Lie–Euler begin a step later than the plan.
  const whole = overTime && data.body ? [data.body.time[0],
    data.body.time[data.body.time.length - 1]] : [Infinity, -Infinity];
  for (const { x } of curves.filter(({ x }) => x.length)) {
    whole[0] = Math.min(whole[0], x[0]);
    whole[1] = Math.max(whole[1], x[x.length - 1]);
  }
  // Charts over time share cursor and zoom; the others have their own.
  const own = { time: null, range: null };
  const state = () => (overTime ? shared : own);
  const change = (what, redraw) => {
    if (overTime) share(what, redraw);
    else {
      Object.assign(own, what);
      update(redraw);
    }
  };
  let [width, height, view, cursor] = [0, 0, null, null];
  let values = legend(figureNode.querySelector(".legend"), curves, picture);

  // Abscissas and ordinates in sight, and the pixels they take.
  function lay() {
    const [from, to] = state().range || whole;
    let [low, high] = [Infinity, -Infinity];
    const see = (value) => {
      const at = value === null ? null : place(value);
      if (at !== null && Number.isFinite(at)) [low, high] = [Math.min(low, at), Math.max(high, at)];
    };
    for (const { x, y } of curves) {
      const first = Math.max(0, indexAt(x, from));
      for (let k = first; k < x.length && x[k] <= to; k++) see(y[k]);
    }
    if (!state().range) picture.levels.forEach((level) => see(level.value));
    if (low > high) [low, high] = [0, 1];
    const up = height - EDGE.top - EDGE.bottom;
    // The name of a limit has room beyond it, where no curve is.
    const part = picture.levels.some((level) => level.label) ? Math.max(0.06, LEVEL / (up - 2 * LEVEL)) : 0.06;
    const margin = Math.max(part * (high - low), logarithmic ? 0.2 : 1e-9 * Math.max(Math.abs(low),
      Math.abs(high), 1e-12));
    [low, high] = [low - margin, high + margin];
    const ticks = (logarithmic ? logarithmicTicks : linearTicks)(low, high, Math.max(2, up / 36));
    const letters = (tick) => tick.text.length + (tick.power === null ? 0 : tick.text === "10" ? 2 : 7);
    const left = NAME + 10 + 7 * Math.max(2, ...ticks.map(letters));
    const across = width - left - EDGE.right;
    return {
      from, to, low, high, ticks, left,
      x: (value) => left + ((value - from) / (to - from || 1)) * across,
      y: (value) => EDGE.top + ((high - value) / (high - low)) * up,
      at: (pixel) => from + ((pixel - left) / across) * (to - from),
    };
  }

  function draw(now) {
    width = now;
    height = Math.round(Math.min(320, Math.max(210, 0.5 * width)));
    view = lay();
    const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, height });
    const id = `clip-${picture.key}`;
    const [left, right, top, bottom] = [view.left, width - EDGE.right, EDGE.top, height - EDGE.bottom];
    element("rect", { x: left, y: top, width: right - left, height: bottom - top }, element("clipPath", { id }, svg));
    const inside = element("g", { "clip-path": `url(#${id})` }, svg);
    const names = spanNames(picture);
    for (const span of picture.spans) {
      const [a, b] = [view.x(span.from), view.x(span.to)];
      const fill = shade(names, span.label);
      element("rect", { x: a, y: top, width: Math.max(1, b - a), height: bottom - top, fill }, inside);
      for (const x of [a, b]) element("line", { x1: x, x2: x, y1: top, y2: bottom, stroke: "var(--edge)",
        "stroke-width": 0.6 }, inside);
      // Where colours differ in meaning a span says which it is, if it has the room.
      const [from, to] = [Math.max(a, left), Math.min(b, right)];
      if (names.length > 1 && to - from > 6.5 * span.label.length) {
        element("text", { x: (from + to) / 2, y: bottom - 6, "text-anchor": "middle", class: "small" }, inside,
          span.label);
      }
    }
    const across = Math.max(2, (right - left) / 75);
    const below = ratios ? logarithmicTicks(view.from, view.to, across) : linearTicks(view.from, view.to,
      across, counts ? 1 : 0);
    for (const tick of below) {
      const x = view.x(tick.value);
      element("line", { x1: x, x2: x, y1: top, y2: bottom, stroke: "var(--grid)" }, svg);
      tickText(tick, { x, y: bottom + 17, "text-anchor": "middle" }, svg);
    }
    for (const tick of view.ticks) {
      const y = view.y(tick.value);
      element("line", { x1: left, x2: right, y1: y, y2: y, stroke: "var(--grid)" }, svg);
      tickText(tick, { x: left - 7, y: y + 4, "text-anchor": "end" }, svg);
    }
    svg.appendChild(inside);
    for (const level of picture.levels) {
      const at = place(level.value);
      if (at === null) continue;
      const y = view.y(at);
      element("line", { x1: left, x2: right, y1: y, y2: y, stroke: "var(--limit)", "stroke-dasharray": "7 4" }, inside);
    }
    for (const curve of [...curves].reverse()) {
      const attributes = {
        d: path(curve), fill: "none", stroke: colour(curve.style), "stroke-width": 1.8, "stroke-linejoin": "round",
        "stroke-dasharray": dash(curve.style), class: "curve",
      };
      element("path", attributes, inside);
      if (curve.marked) {
        curve.x.forEach((x, k) => {
          const at = curve.y[k] === null ? null : place(curve.y[k]);
          if (at !== null) element("circle", { cx: view.x(x), cy: view.y(at), r: 3.2,
            fill: colour(curve.style) }, inside);
        });
      }
    }
    const lines = curves.map((curve) => sparse(points(curve)));
    for (const level of picture.levels.filter((level) => level.label && place(level.value) !== null)) {
      const at = beside(level.label, view.y(place(level.value)), [left, right, top, bottom], lines);
      element("text", { ...at, "text-anchor": "end", class: "limit" }, inside, level.label);
    }
    element("rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none",
      stroke: "var(--line)" }, svg);
    element("text", { x: (left + right) / 2, y: height - 8, "text-anchor": "middle" }, svg, picture.x.label);
    const middle = (top + bottom) / 2;
    const turned = { x: 13, y: middle, "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` };
    element("text", turned, svg, picture.y.label);
    cursor = element("line", { y1: top, y2: bottom, stroke: "var(--ink)", "stroke-width": 1 }, svg);
    plot.replaceChildren(svg);
    point();
  }

  // The pixels of the points in sight.
  function points({ x, y }) {
    const seen = (k) => x[k] >= view.from && x[k] <= view.to && y[k] !== null && place(y[k]) !== null;
    return x.map((_, k) => k).filter(seen).map((k) => [view.x(x[k]), view.y(place(y[k]))]);
  }

  // The points in sight, and one more at each side.
  function path({ x, y }) {
    const first = Math.max(0, indexAt(x, view.from) - 1);
    let [text, pen] = ["", "M"];
    for (let k = first; k < x.length; k++) {
      const at = y[k] === null ? null : place(y[k]);
      if (at === null) pen = "M";
      else {
        text += `${pen}${view.x(x[k]).toFixed(1)} ${view.y(at).toFixed(1)}`;
        pen = "L";
      }
      if (x[k] > view.to) break;
    }
    return text;
  }

  // The cursor, and the values there.
  function point() {
    const time = state().time;
    const seen = time !== null && time >= view.from && time <= view.to;
    cursor.style.display = seen ? "" : "none";
    if (seen) cursor.setAttribute("x1", view.x(time)), cursor.setAttribute("x2", view.x(time));
    values(time);
  }

  function update(redraw) {
    if (!width) return;
    if (redraw) draw(width);
    else point();
  }
  shared.listeners.push(update);
  onWidth(plot, draw);
  control(plot, {
    whole, get view() { return view; }, state, change,
    clamp: (value) => Math.min(whole[1], Math.max(whole[0], value)),
  });
  drawn.push(picture.key);
  // Other curves in the place of these, over the same stretch.
  return (others) => {
    curves = others;
    figureNode.querySelector(".legend").replaceChildren();
    values = legend(figureNode.querySelector(".legend"), curves, picture);
    update(true);
  };
}

// Names of shaded spans, each once, and the colours that stand for them.
const spanNames = (picture) => [...new Set(picture.spans.map((span) => span.label))];
const shade = (names, label) => `var(--s${names.indexOf(label) % 4})`;

// Names with their lines, and a function that shows the values at a time.
function legend(node, curves, picture) {
  const outputs = curves.map((curve) => {
    const entry = html("span", node);
    const sample = element("svg", { viewBox: "0 0 28 10" }, entry);
    const stroke = { x1: 0, x2: 28, y1: 5, y2: 5, stroke: colour(curve.style), "stroke-width": 2 };
    element("line", { ...stroke, "stroke-dasharray": dash(curve.style) }, sample);
    const [name, ...more] = curve.name.split("\n");
    entry.appendChild(document.createTextNode(name));
    if (more.length) html("small", entry, ` ${more.join(", ")}`);
    entry.appendChild(document.createTextNode(" "));
    return html("b", entry);
  });
  const names = spanNames(picture);
  for (const label of names) {
    const entry = html("span", node);
    element("rect", { width: 28, height: 10, fill: shade(names, label), stroke: "var(--edge)" },
      element("svg", { viewBox: "0 0 28 10" }, entry));
    entry.appendChild(document.createTextNode(label));
  }
  const time = html("span", node);
  return (at) => {
    curves.forEach(({ x, y }, index) => {
      if (at === null) return void (outputs[index].textContent = "");
      const k = indexAt(x, at);
      const next = Math.min(k + 1, x.length - 1);
      const part = x[next] > x[k] ? Math.min(1, Math.max(0, (at - x[k]) / (x[next] - x[k]))) : 0;
      const inside = at >= x[0] && at <= x[x.length - 1] && y[k] !== null && y[next] !== null;
      outputs[index].textContent = inside ? figure(y[k] + part * (y[next] - y[k])) : "–";
    });
    time.textContent = at === null ? "" : `at ${figure(picture.x.log ? 10 ** at : at)}${
      picture.x.label.startsWith("time") ? " s" : ""}`;
  };
}

// Pointer and keys of a chart.
function control(plot, chart) {
  let from = null;
  const at = (event) => chart.clamp(chart.view.at(event.clientX - plot.getBoundingClientRect().left));
  const zoom = (a, b) => {
    const [low, high] = [chart.clamp(Math.min(a, b)), chart.clamp(Math.max(a, b))];
    const all = low <= chart.whole[0] && high >= chart.whole[1];
    if (high - low > 1e-6 * (chart.whole[1] - chart.whole[0])) chart.change({ range: all ? null : [low, high] }, true);
  };
  plot.addEventListener("pointerdown", (event) => {
    from = event.pointerType === "touch" ? null : at(event);
    chart.change({ time: at(event) }, false);
  });
  plot.addEventListener("pointermove", (event) => chart.change({ time: at(event) }, false));
  plot.addEventListener("pointerup", (event) => {
    const to = at(event);
    const far = from !== null && Math.abs(to - from) > 0.02 * (chart.view.to - chart.view.from);
    if (far) zoom(from, to);
    from = null;
  });
  plot.addEventListener("pointerleave", () => (from = null));
  plot.addEventListener("dblclick", () => chart.change({ range: null }, true));
  plot.addEventListener("keydown", (event) => {
    const { from: low, to: high } = chart.view;
    const time = chart.state().time ?? (low + high) / 2;
    const step = ((event.shiftKey ? 10 : 1) * (high - low)) / 200;
    const around = (factor) => zoom(time - factor * (time - low), time + factor * (high - time));
    const keys = {
      ArrowLeft: () => chart.change({ time: chart.clamp(time - step) }, false),
      ArrowRight: () => chart.change({ time: chart.clamp(time + step) }, false),
      "+": () => around(0.5), "=": () => around(0.5), "-": () => around(2),
      0: () => chart.change({ range: null }, true), Escape: () => chart.change({ range: null, time: null }, true),
    };
    if (keys[event.key]) {
      keys[event.key]();
      event.preventDefault();
    }
  });
}
