// The sphere of directions as a map: azimuthal equidistant about the middle of what is shown, seen
// from outside, like the body in motion.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (factor, a) => a.map((part) => factor * part);
const plus = (a, b) => a.map((part, k) => part + b[k]);
const unit = (a) => scaled(1 / Math.hypot(...a), a);
const onSphere = (tilt, about) => [Math.cos(tilt) * Math.cos(about), Math.cos(tilt) * Math.sin(about), Math.sin(tilt)];

// The directions at an angle from an axis.
function circle(axis, angle) {
  const u = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
  const v = cross(axis, u);
  return Array.from({ length: 181 }, (_, k) => {
    const turn = (2 * Math.PI * k) / 180;
    const aside = plus(scaled(Math.cos(turn), u), scaled(Math.sin(turn), v));
    return plus(scaled(Math.cos(angle), axis), scaled(Math.sin(angle), aside));
  });
}

// The farthest that two points of a line lie apart on the screen, in pixels, and the most times that
// an arc between them is halved.
const LINE_STEP = 8;
const LINE_HALVINGS = 7;

// Meridians and parallels every 30 degrees.
function graticule() {
  const degree = Math.PI / 180;
  const along = (count, at) => Array.from({ length: count + 1 }, (_, k) => at(k / count));
  const lines = [];
  for (let tilt = -60; tilt <= 60; tilt += 30) lines.push(along(90,
    (part) => onSphere(tilt * degree, 2 * Math.PI * part)));
  for (let about = 0; about < 360; about += 30) lines.push(along(90,
    (part) => onSphere(Math.PI * (part - 0.5), about * degree)));
  return lines;
}

// Where names stand: each beside what it names, right or left, in the nearest row within the
// picture that no other one covers, and off the `lines` if there is such a row.
function naming([wide, high], lines, taken = []) {
  const box = (x, y, width, size) => [x, y - size, x + width, y + 0.25 * size];
  const free = (b) => b[0] >= 0 && b[1] >= 0 && b[2] <= wide && b[3] <= high &&
    taken.every((other) => b[0] >= other[2] || b[2] <= other[0] || b[1] >= other[3] || b[3] <= other[1]);
  const clear = (b) => lines.every((line) => !crosses(line, b));
  return {
    taken,
    keepClear(x, y, by) {
      taken.push([x - by, y - by, x + by, y + by]);
    },
    ifFree(x, y, width, size) {
      const wanted = box(x, y, width, size);
      return free(wanted) && clear(wanted) && taken.push(wanted) > 0;
    },
    beside(x, y, width, size) {
      const places = [];
      for (let row = 0; row < 12; row += 1) {
        for (const k of [row + 1, -row]) for (const left of [x + 7, x - 7 - width]) places.push([left,
          y + k * (size + 2)]);
      }
      const open = places.filter(([left, below]) => free(box(left, below, width, size)));
      const place = open.find(([left, below]) => clear(box(left, below, width, size))) || open[0] || places[0];
      taken.push(box(...place, width, size));
      return place;
    },
  };
}
// Whether a cone acts after a part of the motion.
const coneActs = (cone, part) => !cone.acts || cone.acts.some(([from, to]) => from <= part && part <= to);
const coneMoves = (cone) => cone.way.length > 0 || cone.acts !== null;

// The least radius of a disc on the screen: the Sun would be half a pixel.
const LEAST_DISC = 4;

// Axis and angle on a way at equal steps of time, after a part of it.
function alongWay(way, part) {
  const at = Math.max(0, Math.min(1, part)) * (way.length - 1);
  const k = Math.min(Math.floor(at), Math.max(0, way.length - 2));
  const [a, b] = [way[k], way[Math.min(k + 1, way.length - 1)]];
  const mixed = a.map((value, index) => value + (at - k) * (b[index] - value));
  return [unit(mixed.slice(0, 3)), mixed[3]];
}

function sky(figureNode, picture) {
  const plot = figureNode.querySelector(".plot");
  const { middle, right, up, reach } = picture.view;
  const body = data.body;
  let [place, dots, drawMoving, moving] = [null, [], null, null];

  function draw(width) {
    const radius = Math.min(290, width / 2 - 14);
    const [cx, cy] = [width / 2, radius + 12];
    const height = 2 * radius + 24;
    place = (direction) => {
      const [x, y, z] = [dot(direction, right), dot(direction, up), dot(direction, middle)];
      const across = Math.hypot(x, y);
      const distance = across ? (radius * Math.atan2(across, z)) / reach / across : 0;
      return [cx + distance * x, cy - distance * y];
    };
    const trace = (points) => points.map(place).map(([x, y],
      k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
    // Points close together on the screen: near the point opposite to the middle the map is
    // stretched, and the arcs between `points` are halved by `half`.
    const dense = (points, half) => {
      const fine = [points[0]];
      const add = (a, b, halvings) => {
        const [[ax, ay], [bx, by]] = [place(a), place(b)];
        if (halvings && Math.hypot(bx - ax, by - ay) > LINE_STEP) {
          const between = half(a, b);
          add(a, between, halvings - 1);
          add(between, b, halvings - 1);
        } else fine.push(b);
      };
      for (let k = 1; k < points.length; k++) add(points[k - 1], points[k], LINE_HALVINGS);
      return fine;
    };
    const curve = (points) => trace(dense(points, (a, b) => unit(plus(a, b))));
    // The closed outline of a cone or a disc.
    const outline = (axis, angle) => {
      const centre = scaled(Math.cos(angle), axis);
      const half = (a, b) => plus(centre, scaled(Math.sin(angle), unit(plus(plus(a, b), scaled(-2, centre)))));
      return `${trace(dense(circle(axis, angle), half))}Z`;
    };
    // A track is torn where it passes behind the middle: as SkyView::tears.
    const tears = (a, b) => {
      const along = (direction) => [dot(direction, right), dot(direction, up)];
      const [[ax, ay], [bx, by]] = [along(a), along(b)];
      const behind = dot(a, middle) < 0 && dot(b, middle) < 0;
      return behind && ax * bx + ay * by < Math.SQRT1_2 * Math.hypot(ax, ay) * Math.hypot(bx, by);
    };
    const stretches = (points) => {
      const parts = [];
      points.forEach((point, k) => {
        if (k && !tears(points[k - 1], point)) parts[parts.length - 1].push(point);
        else parts.push([point]);
      });
      return parts;
    };
    const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, height });
    element("circle", { cx, cy, r: radius }, element("clipPath", { id: `clip-${picture.key}` }, svg));
    const inside = element("g", { "clip-path": `url(#clip-${picture.key})` }, svg);
    for (const line of graticule()) {
      // Near the point opposite to the middle the map is torn.
      let part = [];
      for (const direction of [...line, null]) {
        if (direction && dot(direction, middle) > -0.995) part.push(direction);
        else {
          if (part.length > 1) element("path", { d: trace(part), fill: "none", stroke: "var(--grid)" }, inside);
          part = [];
        }
      }
    }
    const out = radius + 2;
    const rim = `M${cx - out} ${cy}a${out} ${out} 0 1 0 ${2 * out} 0a${out} ${out} 0 1 0 ${-2 * out} 0Z`;
    const holdsOpposite = (axis, angle) => Math.acos(Math.max(-1, Math.min(1, -dot(axis, middle)))) < angle;
    // Names stand above everything, and are not cut at the rim.
    const words = element("g", {});
    const lines = picture.tracks.flatMap((track) => stretches(track.points)).map((part) => sparse(part.map(place)));
    let [names, moved] = [naming([width, height], lines), null];
    for (const mark of picture.marks) names.keepClear(...place(mark.at), 5);
    for (const track of picture.tracks) {
      for (const end of [track.points[0], track.points[track.points.length - 1]]) names.keepClear(...place(end), 7);
    }
    const name = (text, at, kind, parent, size = 11) => {
      if (Math.hypot(...place(at).map((pixel, k) => pixel - [cx, cy][k])) > radius) return;
      const [x, y] = names.beside(...place(at), nameWidth(text, size), size);
      element("text", { x, y, ...kind }, parent, text);
    };
    const drawCone = (cone, axis, angle, acts, parent) => {
      const edge = outline(axis, angle);
      const d = holdsOpposite(axis, angle) === (cone.asks === "keep out") ? edge + rim : edge;
      const shaded = acts && cone.asks !== "hold on";
      if (shaded) element("path", { d, fill: "var(--limit)", "fill-opacity": 0.14, "fill-rule": "evenodd" }, parent);
      const line = { fill: "none", stroke: "var(--limit)", "stroke-width": 1.4 };
      element("path", { d: edge, ...line, ...(acts ? {} : { "stroke-dasharray": "2 4" }) }, parent);
      name(cone.name, axis, { class: "limit" }, parent === inside ? words : moved);
    };
    const drawDisc = (disc, axis, angle, parent) => {
      const tint = `var(--${disc.kind})`;
      const [x, y] = place(axis);
      if ((radius * angle) / reach < LEAST_DISC) element("circle", { cx: x, cy: y, r: LEAST_DISC, fill: tint }, parent);
      else {
        const edge = outline(axis, angle);
        const d = holdsOpposite(axis, angle) ? edge + rim : edge;
        element("path", { d, fill: tint, "fill-opacity": 0.22, "fill-rule": "evenodd" }, parent);
        element("path", { d: edge, fill: "none", stroke: tint, "stroke-width": 1.4 }, parent);
      }
      if (disc.name) name(disc.name, axis, { class: "small" }, moved);
    };
    for (const disc of picture.discs) {
      const middles = disc.way.map((at) => at.slice(0, 3));
      element("path", { d: stretches(middles).map(trace).join(""), fill: "none", stroke: `var(--${disc.kind})`,
        "stroke-width": 1.2 }, inside);
      const [axis, angle] = alongWay(disc.way, 0);
      const dashed = { fill: "none", stroke: `var(--${disc.kind})`, "stroke-dasharray": "3 3" };
      const [cx, cy] = place(axis);
      if ((radius * angle) / reach < LEAST_DISC) element("circle", { cx, cy, r: LEAST_DISC, ...dashed }, inside);
      else element("path", { d: outline(axis, angle), ...dashed }, inside);
    }
    for (const mark of picture.marks) {
      const [x, y] = place(mark.at);
      element("path", { d: `M${x - 5} ${y}h10M${x} ${y - 5}v10`, stroke: "var(--ink)", "stroke-width": 1.5 }, inside);
      if (mark.name) name(mark.name, mark.at, {}, words, 13);
    }
    for (const cone of picture.cones) if (!coneMoves(cone)) drawCone(cone, cone.axis, cone.half_angle, true, inside);
    for (const label of picture.labels) {
      const [x, y] = place(label.at);
      if (names.ifFree(x + 3, y - 3, nameWidth(label.text, 11), 11)) element("text",
        { x: x + 3, y: y - 3, class: "small" }, words, label.text);
    }
    moving = element("g", {}, inside);
    moved = element("g", {}, words);
    const standing = names.taken;
    drawMoving = () => {
      moving.replaceChildren();
      moved.replaceChildren();
      names = naming([width, height], lines, [...standing]);
      // Without a cursor as at the end.
      const last = body ? body.time[body.time.length - 1] : 0;
      const part = shared.time === null || !last ? 1 : shared.time / last;
      for (const disc of picture.discs) drawDisc(disc, ...alongWay(disc.way, part), moving);
      for (const cone of picture.cones.filter(coneMoves)) {
        const at = cone.way.length ? alongWay(cone.way, part) : [cone.axis, cone.half_angle];
        drawCone(cone, ...at, coneActs(cone, part), moving);
      }
    };
    for (const ring of picture.rings) {
      if (ring.points.some((point, k) => tears(point, ring.points[(k + 1) % ring.points.length]))) continue;
      const drawn = { fill: colour(ring.style), "fill-opacity": ring.filled ? 0.35 : 0, stroke: colour(ring.style) };
      element("path", { d: `${trace(ring.points)}Z`, ...drawn, "stroke-width": 0.9, "stroke-opacity": 0.75 }, inside);
    }
    for (const track of [...picture.tracks].reverse()) {
      const stroke = { fill: "none", stroke: colour(track.style), "stroke-width": 2.2, class: "curve" };
      element("path", { d: stretches(track.points).map(curve).join(""), ...stroke,
        "stroke-dasharray": dash(track.style) }, inside);
    }
    element("circle", { cx, cy, r: radius, fill: "none", stroke: "var(--line)" }, svg);
    for (const track of picture.tracks) {
      const [start, end] = [place(track.points[0]), place(track.points[track.points.length - 1])];
      const ring = { r: 4.5, fill: "var(--paper)", stroke: colour(track.style), "stroke-width": 2 };
      element("circle", { cx: start[0], cy: start[1], ...ring }, svg);
      element("circle", { cx: end[0], cy: end[1], r: 5, fill: colour(track.style) }, svg);
    }
    svg.appendChild(words);
    dots = picture.tracks.map((track) => element("circle",
      { r: 6, fill: "none", stroke: "var(--ink)", "stroke-width": 2 }, svg));
    plot.replaceChildren(svg);
    update();
  }

  // Where the boresights are at the time of the cursor.
  function update() {
    if (picture.discs.length || picture.cones.some(coneMoves)) drawMoving();
    dots.forEach((ring, index) => {
      const seen = shared.time !== null && body;
      ring.style.display = seen ? "" : "none";
      if (!seen) return;
      const [x, y] = place(turned(attitudeAt(shared.time), body.boresights[index].vector));
      ring.setAttribute("cx", x);
      ring.setAttribute("cy", y);
    });
  }
  const node = figureNode.querySelector(".legend");
  for (const track of picture.tracks) {
    const entry = html("span", node);
    const sample = element("svg", { viewBox: "0 0 28 10" }, entry);
    const stroke = { x1: 0, x2: 28, y1: 5, y2: 5, stroke: colour(track.style), "stroke-width": 2.4 };
    element("line", { ...stroke, "stroke-dasharray": dash(track.style) }, sample);
    entry.appendChild(document.createTextNode(track.name));
  }
  html("span", node, "○ start   ● end");
  for (const cone of picture.cones) {
    const when = cone.when ? `, ${cone.when}` : "";
    html("span", node, `${cone.name}: ${cone.asks}, ${figure((cone.half_angle * 180) / Math.PI)}°${when}`);
  }
  for (const disc of picture.discs) {
    const entry = html("span", node);
    const sample = element("svg", { viewBox: "0 0 28 10" }, entry);
    element("circle", { cx: 14, cy: 5, r: 4.5, fill: `var(--${disc.kind})` }, sample);
    entry.appendChild(document.createTextNode(disc.name));
  }
  shared.listeners.push(update);
  onWidth(plot, draw);
  drawn.push(picture.key);
}
