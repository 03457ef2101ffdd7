(() => {
  "use strict";
  const frames = JSON.parse(document.getElementById("frames").textContent);
  const { time, along, height, across, twist, middle } = frames;
  const { cubic, draw, find, play, points, view } = animationParts;
  const lowest = (rows) => Math.min(...rows.map((row) => Math.min(...row)));
  const highest = (rows) => Math.max(...rows.map((row) => Math.max(...row)));
  const turn = (rows) => along.map((_, node) => rows.map((row) => row[node]));

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

  play(time, (now) => {
    const { four, weights } = cubic(time, now);
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
  });
})();
