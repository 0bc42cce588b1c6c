// The body in motion: a box, its axes and boresights, and the cones on a sphere around it; or along
// its path.

// A vector of body axes in reference axes, by a quaternion [w, x, y, z].
function turned([w, x, y, z], v) {
  const t = scaled(2, cross([x, y, z], v));
  return plus(plus(v, scaled(w, t)), cross([x, y, z], t));
}

// Of the list of a body, where a time is: index, and part of the way to the next.
function between(time) {
  const times = data.body.time;
  const k = Math.min(indexAt(times, time), times.length - 2);
  return k < 0 ? [0, 0] : [k, Math.min(1, Math.max(0, (time - times[k]) / (times[k + 1] - times[k] || 1)))];
}

function attitudeAt(time) {
  const [k, part] = between(time);
  const all = data.body.quaternion;
  const [a, b] = [all[k], all[Math.min(k + 1, all.length - 1)]];
  const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
  const mixed = a.map((value, index) => (1 - part) * value + sign * part * b[index]);
  return scaled(1 / Math.hypot(...mixed), mixed);
}

function positionAt(time) {
  const [k, part] = between(time);
  const all = data.body.position;
  if (!all.length) return [0, 0, 0];
  return plus(scaled(1 - part, all[k]), scaled(part, all[Math.min(k + 1, all.length - 1)]));
}

// Faces of the box by their corners, counted in binary.
const FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];

// How far the first view is from that of the map, so that boresights in its middle are seen from a
// side.
const ASIDE = 0.45;

function stage() {
  const body = data.body;
  const canvas = document.getElementById("stage");
  const slider = document.getElementById("slider");
  const play = document.getElementById("play");
  const clock = document.getElementById("clock");
  const end = body.time[body.time.length - 1];
  const moving = body.position.length > 0;
  // The reader stands where the map of the sphere has its middle, a little aside.
  const map = data.charts.find((picture) => picture.key === "sky");
  const faced = map && !moving ? map.view.middle : null;
  const view = {
    yaw: faced ? Math.atan2(faced[1], faced[0]) - ASIDE : 0.9,
    pitch: faced ? Math.max(-1, Math.min(1, Math.asin(faced[2]) + 0.5 * ASIDE)) : 0.35,
    width: 0,
  };
  // The path, if there is one, is brought to the unit sphere about its middle.
  let [middle, extent] = [[0, 0, 0], 1];
  if (moving) {
    const seen = body.attracted ? [...body.position, [0, 0, 0]] : body.position;
    const of = (pick) => [0, 1, 2].map((axis) => seen.reduce((best, at) => pick(best, at[axis]), seen[0][axis]));
    const [low, high] = [of(Math.min), of(Math.max)];
    middle = scaled(0.5, plus(low, high));
    extent = 0.5 * Math.hypot(...plus(high, scaled(-1, low))) || 1;
  }
  const boxSize = moving ? 0.16 : 0.36;
  const time = () => shared.time ?? 0;

  function draw() {
    const width = view.width;
    const height = Math.min(width, 520);
    const ratio = window.devicePixelRatio || 1;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    canvas.style.height = `${height}px`;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.lineJoin = "round";
    const style = getComputedStyle(document.documentElement);
    const tint = (name) => style.getPropertyValue(`--${name}`).trim();
    // The body's axes stay within the picture wherever on the path it is.
    const radius = moving ? Math.min(0.46 * width, (0.5 * height) / (1 + 2.2 * boxSize)) : 0.44 * height;
    const [cy, sy, cp, sp] = [Math.cos(view.yaw), Math.sin(view.yaw), Math.cos(view.pitch), Math.sin(view.pitch)];
    const [right, up, near] = [[-sy, cy, 0], [-sp * cy, -sp * sy, cp], [cp * cy, cp * sy, sp]];
    const place = (at) => [width / 2 + radius * dot(at, right), height / 2 - radius * dot(at, up)];
    const polyline = (points) => {
      pen.beginPath();
      points.forEach((at, k) => (k ? pen.lineTo(...place(at)) : pen.moveTo(...place(at))));
    };
    const stroke = (points, colour, lineWidth, alpha) => {
      pen.globalAlpha = alpha;
      pen.strokeStyle = colour;
      pen.lineWidth = lineWidth;
      polyline(points);
      pen.stroke();
      pen.globalAlpha = 1;
    };
    // What is behind the middle first and fainter, then the rest.
    const halves = (points, front, colour, lineWidth, alpha) => {
      let part = [];
      for (const at of [...points, null]) {
        const here = at !== null && dot(at, near) >= 0 === front;
        if (here) part.push(at);
        if (!here || at === null) {
          if (part.length > 1) stroke(part, colour, lineWidth, front ? alpha : 0.35 * alpha);
          part = [];
        }
      }
    };
    // Names stand above everything: they are written last.
    const names = naming([width, height], moving ? [] : tracks.map((track) => sparse(track.map(place))));
    const words = [];
    const word = (...what) => words.push(what);
    const written = ([text, at, colour, size = 12]) => {
      pen.fillStyle = colour;
      pen.font = `${size}px system-ui, "DejaVu Sans", sans-serif`;
      const where = names.beside(...place(at), pen.measureText(text).width, size);
      pen.strokeStyle = tint("paper");
      pen.lineWidth = 2.5;
      pen.strokeText(text, ...where);
      pen.fillText(text, ...where);
    };
    pen.clearRect(0, 0, width, height);
    const attitude = attitudeAt(time());
    const origin = moving ? scaled(1 / extent, plus(positionAt(time()), scaled(-1, middle))) : [0, 0, 0];
    const part = end ? time() / end : 0;
    const standing = (thing) => {
      const [axis, half_angle] = alongWay(thing.way, part);
      return { ...thing, axis, half_angle };
    };
    const cones = body.cones.map((cone) => (cone.way.length ? standing(cone) : cone));
    const discs = body.discs.map(standing);

    const sphere = (front) => {
      if (moving) return;
      for (const line of graticule()) halves(line, front, tint("line"), 0.8, 0.7);
      for (const disc of discs) {
        const [here, colour] = [dot(disc.axis, near) >= 0 === front, tint(disc.kind)];
        if (disc.half_angle > 0.02) {
          const edge = circle(disc.axis, disc.half_angle);
          if (here) {
            pen.globalAlpha = front ? 0.18 : 0.09;
            pen.fillStyle = colour;
            polyline(edge);
            pen.fill();
            pen.globalAlpha = 1;
          }
          halves(edge, front, colour, 1.4, 1);
        } else if (here) {
          const [x, y] = place(disc.axis);
          pen.fillStyle = colour;
          pen.beginPath();
          pen.arc(x, y, 5, 0, 2 * Math.PI);
          pen.fill();
        }
        halves(disc.way.map((at) => at.slice(0, 3)), front, colour, 1.2, 0.8);
        if (here) word(disc.name, disc.axis, colour, 11);
      }
      for (const cone of cones) {
        const edge = circle(cone.axis, cone.half_angle);
        if (dot(cone.axis, near) >= 0 === front && cone.asks === "keep out" && coneActs(cone, part)) {
          pen.globalAlpha = front ? 0.16 : 0.07;
          pen.fillStyle = tint("limit");
          polyline(edge);
          pen.fill();
          pen.globalAlpha = 1;
        }
        halves(edge, front, tint("limit"), 1.6, 1);
        if (dot(cone.axis, near) >= 0 === front) word(cone.name, cone.axis, tint("limit"), 11);
      }
      body.boresights.forEach((boresight, index) => halves(tracks[index], front, tint(`c${index % 8}`), 2, 0.9));
    };
    sphere(false);
    if (moving) {
      stroke(body.position.map((at) => scaled(1 / extent, plus(at, scaled(-1, middle)))), tint("c0"), 1.8, 0.9);
      if (body.attracted) {
        const [x, y] = place(scaled(-1 / extent, middle));
        pen.fillStyle = tint("ink");
        pen.beginPath();
        pen.arc(x, y, 6, 0, 2 * Math.PI);
        pen.fill();
        word("center of attraction", scaled(-1 / extent, middle), tint("faint"), 11);
      }
    } else {
      pen.strokeStyle = tint("line");
      pen.beginPath();
      pen.arc(width / 2, height / 2, radius, 0, 2 * Math.PI);
      pen.stroke();
    }
    ["X", "Y", "Z"].forEach((name, axis) => {
      const tip = [0, 1, 2].map((k) => (k === axis ? (moving ? 0.16 : 1.0) : 0));
      // Beside a path they stand in a corner of the picture.
      const corner = plus(scaled(0.5 * width - 60, right), scaled(0.5 * height - 60, up));
      const foot = moving ? scaled(-1 / radius, corner) : [0, 0, 0];
      stroke([foot, plus(foot, tip)], tint("faint"), 1, 0.7);
      word(name, plus(foot, tip), tint("faint"));
    });

    // The box, its far faces first.
    const corners = body.corners.map((corner) => plus(origin, scaled(boxSize, turned(attitude, corner))));
    const depth = (face) => face.reduce((sum, k) => sum + dot(corners[k], near), 0);
    for (const face of [...FACES].sort((a, b) => depth(a) - depth(b))) {
      const normal = unit(cross(plus(corners[face[1]], scaled(-1, corners[face[0]])),
        plus(corners[face[3]], scaled(-1, corners[face[0]]))));
      const light = Math.abs(dot(normal, unit([0.4, 0.3, 1])));
      polyline(face.map((k) => corners[k]));
      pen.closePath();
      pen.globalAlpha = 0.9;
      pen.fillStyle = `hsl(208 22% ${Math.round(38 + 34 * light)}%)`;
      pen.fill();
      pen.globalAlpha = 1;
      pen.strokeStyle = tint("ink");
      pen.lineWidth = 1;
      pen.stroke();
    }
    ["x", "y", "z"].forEach((name, axis) => {
      const tip = plus(origin, scaled(1.7 * boxSize, turned(attitude, [0, 1, 2].map((k) => (k === axis ? 1 : 0)))));
      stroke([origin, tip], tint("ink"), 1.4, 0.8);
      word(name, tip, tint("ink"));
    });
    body.boresights.forEach((boresight, index) => {
      const direction = turned(attitude, boresight.vector);
      const tip = plus(origin, scaled(moving ? 2.2 * boxSize : 1, direction));
      stroke([origin, tip], tint(`c${index % 8}`), 2.4, 1);
      const [x, y] = place(tip);
      pen.fillStyle = tint(`c${index % 8}`);
      pen.beginPath();
      pen.arc(x, y, 4.5, 0, 2 * Math.PI);
      pen.fill();
      names.keepClear(x, y, 6);
    });
    sphere(true);
    words.forEach(written);
  }

  const tracks = body.boresights.map((boresight) => body.quaternion.map((q) => turned(q, boresight.vector)));
  const update = () => {
    slider.value = String(Math.round((1000 * time()) / end));
    clock.textContent = `${figure(Number(time().toPrecision(4)))} s`;
    if (view.width) draw();
  };
  shared.listeners.push(update);
  onWidth(canvas.parentElement, (width) => {
    view.width = width;
    update();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", update);
  const node = document.getElementById("stage-legend");
  body.boresights.forEach((boresight, index) => {
    const entry = html("span", node);
    const stroke = { x1: 0, x2: 28, y1: 5, y2: 5, stroke: colour(index), "stroke-width": 2.4 };
    element("line", stroke, element("svg", { viewBox: "0 0 28 10" }, entry));
    entry.appendChild(document.createTextNode(boresight.name));
  });
  stageControls(canvas, slider, play, view, end, update);
  update();
}

// Slider, play, and turning by hand.
function stageControls(canvas, slider, play, view, end, update) {
  slider.addEventListener("input", () => share({ time: (end * Number(slider.value)) / 1000 }, false));
  let [began, running] = [0, false];
  const SECONDS = 12;
  const frame = (now) => {
    if (!running) return;
    const part = Math.min(1, (now - began) / (1000 * SECONDS));
    share({ time: part * end }, false);
    if (part < 1) requestAnimationFrame(frame);
    else stop();
  };
  const stop = () => {
    running = false;
    play.textContent = "Play";
  };
  play.addEventListener("click", () => {
    if (running) return stop();
    const at = (shared.time ?? 0) / end;
    running = true;
    play.textContent = "Pause";
    began = performance.now() - 1000 * SECONDS * (at < 1 ? at : 0);
    requestAnimationFrame(frame);
  });
  const turn = (yaw, pitch) => {
    view.yaw -= yaw;
    view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch + pitch));
    update();
  };
  let last = null;
  canvas.addEventListener("pointerdown", (event) => {
    last = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!last) return;
    turn(0.01 * (event.clientX - last[0]), 0.01 * (event.clientY - last[1]));
    last = [event.clientX, event.clientY];
  });
  canvas.addEventListener("pointerup", () => (last = null));
  canvas.addEventListener("keydown", (event) => {
    const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    if (keys[event.key]) {
      turn(...keys[event.key]);
      event.preventDefault();
    }
  });
}
