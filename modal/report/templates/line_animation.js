(() => {
  "use strict";
  const { time, rest, conductors, strings, shapes, amplitude, lowest, highest } =
    JSON.parse(document.getElementById("frames").textContent);
  const { cubic, draw, find, play, points, view } = animationParts;
  const column = (rows, k) => rows.map((row) => row[k]);
  const part = (values, [first, last]) => values.slice(first, last + 1);
  const along = column(rest, 0), length = [Math.min(...along), Math.max(...along)];

  /* Elevation (0) and plan (1): view, and for each conductor the line that moves. */
  const panels = ["side", "plan"].map((id, k) => {
    const towers = strings.map(([point]) => point[k + 1]);
    const least = Math.min(...column(lowest, k), ...towers), most = Math.max(...column(highest, k), ...towers);
    const room = Math.max(1 - (most - least), 0) / 2;
    const panel = view(id, length, [least - room, most + room], false);
    const flat = along.map(panel.x);
    conductors.forEach((own) => {
      const xs = part(flat, own);
      const up = part(column(highest, k), own).map(panel.y), down = part(column(lowest, k), own).map(panel.y);
      draw(panel.svg, "polygon", { class: "reach", points: `${points(xs, up)} ${points([...xs].reverse(), down.reverse())}` });
      draw(panel.svg, "polyline", { class: "rest", points: points(xs, part(column(rest, k + 1), own).map(panel.y)) });
    });
    strings.forEach(([point]) => draw(panel.svg, "circle", { class: "tower", r: 3, cx: panel.x(point[0]), cy: panel.y(point[k + 1]) }));
    find(`${id}-scale`).textContent =
      `Drawn ${Number((panel.sy / panel.sx).toPrecision(2))} times larger than lengths along the line; the bar is ${panel.bar} m.`;
    return {
      ...panel,
      flat,
      lines: conductors.map(() => draw(panel.svg, "polyline", { class: "now" })),
      bars: strings.map(() => draw(panel.svg, "line", { class: "string" })),
    };
  });

  /* The place of each point is that at rest and the sum of shapes times amplitudes. */
  play(time, (now) => {
    const { four, weights } = cubic(time, now);
    const sizes = shapes.map((_, s) => four.reduce((sum, row, k) => sum + weights[k] * amplitude[row][s], 0));
    panels.forEach(({ x, y, flat, lines, bars }, k) => {
      const place = rest.map((point, p) => y(sizes.reduce((sum, size, s) => sum + size * shapes[s][p][k], point[k + 1])));
      lines.forEach((line, c) => line.setAttribute("points", points(part(flat, conductors[c]), part(place, conductors[c]))));
      bars.forEach((bar, b) => {
        const [point, clamp] = strings[b];
        Object.entries({ x1: x(point[0]), y1: y(point[k + 1]), x2: flat[clamp], y2: place[clamp] })
          .forEach(([name, value]) => bar.setAttribute(name, value.toFixed(2)));
      });
    });
  });
})();
