const animationParts = (() => {
  "use strict";
  const find = (id) => document.getElementById(id);
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

  /* Numbers of the four records around a time, and their weights: cubic interpolation (Catmull-Rom),
   * so that the motion between records is smooth. */
  const cubic = (time, now) => {
    let next = time.findIndex((value) => value >= now);
    next = next < 0 ? time.length - 1 : Math.max(next, Math.min(1, time.length - 1));
    const before = Math.max(next - 1, 0), gap = time[next] - time[before];
    const share = gap > 0 ? Math.min(Math.max((now - time[before]) / gap, 0), 1) : 0;
    const four = [Math.max(before - 1, 0), before, next, Math.min(next + 1, time.length - 1)];
    const s = share, weights = [
      ((2 - s) * s - 1) * s / 2, ((3 * s - 5) * s * s + 2) / 2, ((4 - 3 * s) * s + 1) * s / 2, (s - 1) * s * s / 2,
    ];
    return { four, weights };
  };

  /* Connects button and slider with a function that shows an instant. */
  const play = (time, showMotion) => {
    const clock = find("clock"), button = find("play");
    const show = (now) => {
      showMotion(now);
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
    const start = (wanted) => {
      playing = wanted;
      last = null;
      button.textContent = playing ? "Pause" : "Play";
      if (playing) requestAnimationFrame(tick);
    };
    button.addEventListener("click", () => start(!playing));
    clock.addEventListener("input", () => { start(false); show(Number(clock.value)); });
    addEventListener("beforeprint", () => start(false));
    show(time[time.length - 1]);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) start(true);
  };
  return { cubic, draw, find, play, points, view };
})();
