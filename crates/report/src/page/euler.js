// Euler angles of any sequence: the page is written with one, the reader may choose another.

const SEQUENCES = ["xyz", "xzy", "yxz", "yzx", "zxy", "zyx", "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"];
const ORDINALS = ["first", "second", "third"];

// Intrinsic angles in degrees: R = R_i(a) R_j(b) R_k(c). Of three axes with handedness s
//   R e_k = (s sin b, −s sin a cos b, cos a cos b),   and where the last is the first again
//   R e_i = (cos b, sin a sin b, −s cos a sin b),     in components along i, j and the third.
function eulerAngles(q, sequence) {
  const [i, j, last] = [...sequence].map((axis) => "xyz".indexOf(axis));
  const k = 3 - i - j;
  const s = (i + 1) % 3 === j ? 1 : -1;
  const columns = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((axis) => turned(q, axis));
  const r = (row, column) => columns[column][row];
  const a = last === i ? Math.atan2(r(j, i), -s * r(k, i)) : Math.atan2(-s * r(j, k), r(k, k));
  // What is left without the first turn: R_j(b) R_k(c).
  const [sin, cos] = [Math.sin(a), Math.cos(a)];
  const rowJ = (column) => cos * r(j, column) + s * sin * r(k, column);
  const rowK = (column) => cos * r(k, column) - s * sin * r(j, column);
  const [b, c] =
    last === i
      ? [Math.atan2(-s * rowK(i), r(i, i)), Math.atan2(-s * rowJ(k), rowJ(j))]
      : [Math.atan2(s * r(i, k), rowK(k)), Math.atan2(s * rowJ(i), rowJ(j))];
  return [a, b, c].map((angle) => (angle * 180) / Math.PI);
}

// Curves of a sequence, without jumps of a turn.
function eulerCurves(sequence) {
  const angles = data.body.quaternion.map((q) => eulerAngles(q, sequence));
  for (let row = 1; row < angles.length; row++) {
    angles[row] = angles[row].map((angle, k) => angle + 360 * Math.round((angles[row - 1][k] - angle) / 360));
  }
  const name = (k) => `${ORDINALS[k]}, about ${sequence[k]}`;
  return ORDINALS.map((_, k) => ({ name: name(k), style: k, x: data.body.time, y: angles.map((angle) => angle[k]) }));
}

// The choice in the caption. `replace` takes other curves into the chart.
function eulerChoice(figureNode, picture, replace) {
  const written = picture.title.slice(-3);
  const caption = figureNode.querySelector("figcaption");
  const label = html("label", caption, " sequence ");
  const select = html("select", label);
  for (const sequence of SEQUENCES) {
    const option = html("option", select, sequence);
    option.value = sequence;
    option.selected = sequence === written;
  }
  const original = picture.curves.map((curve) => ({ ...curve, x: data.grids[curve.grid] }));
  select.addEventListener("change", () => {
    const sequence = select.value;
    replace(sequence === written ? original : eulerCurves(sequence));
    caption.querySelector("b").textContent = `Euler angles ${sequence}`;
    const rotations = [...sequence].map((axis) => `R${axis}`).join(" ");
    caption.querySelector(".remark").textContent = `intrinsic: R = ${rotations}; continued over full turns`;
  });
}
