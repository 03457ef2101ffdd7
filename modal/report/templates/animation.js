(() => {
  "use strict";
  const frames = JSON.parse(document.getElementById("frames").textContent);
  const { time, along, height, across, twist, middle } = frames;
  const find = (id) => document.getElementById(id);
  const lowest = (rows) => Math.min(...rows.map((row) => Math.min(...row)));
  const highest = (rows) => Math.max(...rows.map((row) => Math.max(...row)));
  const turn = (rows) => along.map((_, node) => rows.map((row) => row[node]));
  const MARGIN = 24;

  /* A length of 1, 2 or 5 times a power of ten [m], at most the given one. */
  const roundLength = (most) => {
    const power = 10 ** Math.floor(Math.log10(most));
    return [5, 2, 1].find((digit) => digit * power <= most) * power;
  };
  const draw = (parent, kind, attributes) => {
    const made = document.createElementNS("http://www.w3.org/2000/svg", kind);
    Object.entries(attributes).forEach(([name, value]) => made.setAttribute(name, value));
    return parent.appendChild(made);
  };
  const points = (x, y) => x.map((value, k) => `${value.toFixed(1)},${y[k].toFixed(1)}`).join(" ");

  /* A picture whose axes map metres to its box, with equal scales if asked. */
  const view = (id, across, up, equal) => {
    const svg = find(id), box = svg.viewBox.baseVal;
    const wide = Math.max(across[1] - across[0], 1e-3), high = Math.max(up[1] - up[0], 1e-3);
    let sx = (box.width - 2 * MARGIN) / wide, sy = (box.height - 2 * MARGIN) / high;
    if (equal) sx = sy = Math.min(sx, sy);
    const x = (value) => box.width / 2 + sx * (value - (across[0] + across[1]) / 2);
    const y = (value) => box.height / 2 - sy * (value - (up[0] + up[1]) / 2);
    const bar = roundLength((box.height - 2 * MARGIN) / sy / 3);
    draw(svg, "line", { class: "bar", x1: 10, x2: 10, y1: box.height - 10, y2: box.height - 10 - bar * sy });
    return { svg, x, y, sx, sy, bar };
  };

  const heights = [lowest(height), highest(height)], sides = [lowest(across), highest(across)];
  const side = view("side", [along[0], along[along.length - 1]], heights, false);
  const end = view("end", sides, heights, true);
  find("side-scale").textContent =
    `Heights are drawn ${(side.sy / side.sx).toPrecision(2)} times larger than lengths; the bar is ${side.bar} m high.`;
  find("end-scale").textContent = `Equal scales; the bar is ${end.bar} m high.`;

  const flat = along.map(side.x), columns = turn(height);
  const top = columns.map((column) => side.y(Math.max(...column)));
  const bottom = columns.map((column) => side.y(Math.min(...column)));
  draw(side.svg, "polygon", { class: "reach", points: `${points(flat, top)} ${points([...flat].reverse(), bottom.reverse())}` });
  draw(end.svg, "polyline", {
    class: "trail",
    points: points(across.map((row) => end.x(row[middle])), height.map((row) => end.y(row[middle]))),
  });
  const shapes = [side, end].map(({ svg }) => draw(svg, "polyline", { class: "now" }));
  const bar = draw(end.svg, "line", { class: "twist" });
  const dots = [side, end].map(({ svg }) => draw(svg, "circle", { r: 4 }));

  const clock = find("clock"), button = find("play");
  const show = (now) => {
    let next = time.findIndex((value) => value >= now);
    next = next < 0 ? time.length - 1 : Math.max(next, Math.min(1, time.length - 1));
    const before = Math.max(next - 1, 0), gap = time[next] - time[before];
    const share = gap > 0 ? Math.min(Math.max((now - time[before]) / gap, 0), 1) : 0;
    /* Cubic interpolation between four positions (Catmull-Rom): smooth motion between records. */
    const four = [Math.max(before - 1, 0), before, next, Math.min(next + 1, time.length - 1)];
    const s = share, weights = [
      ((2 - s) * s - 1) * s / 2, ((3 * s - 5) * s * s + 2) / 2, ((4 - 3 * s) * s + 1) * s / 2, (s - 1) * s * s / 2,
    ];
    const blend = (pick) => four.reduce((sum, row, k) => sum + weights[k] * pick(row), 0);
    const mix = (rows) => along.map((_, node) => blend((row) => rows[row][node]));
    const up = mix(height), out = mix(across), angle = blend((row) => twist[row]);
    shapes[0].setAttribute("points", points(flat, up.map(side.y)));
    shapes[1].setAttribute("points", points(out.map(end.x), up.map(end.y)));
    const place = [end.x(out[middle]), end.y(up[middle])], reach = [18 * Math.cos(angle), 18 * Math.sin(angle)];
    /* Seen from the left end, wind to the right: a positive twist lifts the windward (left) side. */
    Object.entries({ x1: place[0] - reach[0], y1: place[1] - reach[1], x2: place[0] + reach[0], y2: place[1] + reach[1] })
      .forEach(([name, value]) => bar.setAttribute(name, value.toFixed(2)));
    [[flat[middle], side.y(up[middle])], place].forEach(([x, y], k) => {
      dots[k].setAttribute("cx", x.toFixed(2));
      dots[k].setAttribute("cy", y.toFixed(2));
    });
    clock.value = now;
    clock.setAttribute("aria-valuetext", `${now.toFixed(2)} seconds`);
    find("now").textContent = `${now.toFixed(2)} s`;
  };

  let playing = false, last = null;
  const tick = (stamp) => {
    if (!playing) return;
    const span = time[time.length - 1] - time[0];
    let now = Number(clock.value) + (last === null ? 0 : Math.min((stamp - last) / 1000, 0.1));
    if (now >= time[time.length - 1]) now = span > 0 ? time[0] : now;
    last = stamp;
    show(now);
    requestAnimationFrame(tick);
  };
  const play = (wanted) => {
    playing = wanted;
    last = null;
    button.textContent = playing ? "Pause" : "Play";
    if (playing) requestAnimationFrame(tick);
  };
  button.addEventListener("click", () => play(!playing));
  clock.addEventListener("input", () => { play(false); show(Number(clock.value)); });
  addEventListener("beforeprint", () => play(false));
  show(time[time.length - 1]);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
})();
