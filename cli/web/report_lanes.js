// Part of report.js, which includes it (cmake/Web.cmake).
  // ---- lanes of modes: on which side switches, diodes, contacts and latches are ----------------------------------
  const laneHeight = 25, laneColour = ["c0", "c1", "c2", "c3", "c4", "soft"];
  // The stretch that holds t: its index in the beginnings xs, -1 before the first.
  const stretchAt = (xs, t) => {
    let low = -1, high = xs.length;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (xs[middle] <= t) low = middle; else high = middle;
    }
    return low;
  };
  const sideText = (lane, t) => {
    if (t == null || t > lane.stop) return "\u2013";
    const i = stretchAt(lane.xs, t), share = lane.ys[i];
    if (i < 0 || lane.kind === laneColour.length - 1) return "\u2013";
    return share === 1 ? lane.on : share === 0 ? lane.off : text(share) + " " + lane.on;
  };
  const paintLane = (u, lane, row) => {
    const c = u.ctx, ratio = u.pxRatio ?? devicePixelRatio, {left, top, width} = u.bbox;
    const from = u.scales.x.min, to = Math.min(u.scales.x.max, lane.stop), columns = Math.round(width / ratio);
    const column = (u.scales.x.max - u.scales.x.min) / columns, px = (t) => left + (t - from) / column * ratio;
    const y = top + (row * laneHeight + 14) * ratio, high = 9 * ratio, full = colour(laneColour[lane.kind]);
    c.font = `${11 * ratio}px ${getComputedStyle(document.body).fontFamily}`;
    c.textAlign = "left";
    c.textBaseline = "alphabetic";
    c.fillStyle = colour("ink");
    c.fillText(lane.text, left, y - 3 * ratio, width);
    if (!(to > from)) return;
    const fill = (a, b, style, alpha) => {
      c.globalAlpha = alpha;
      c.fillStyle = style;
      c.fillRect(px(a), y, Math.max(px(b) - px(a), 0), high);
      c.globalAlpha = 1;
    };
    const begin = Math.max(from, lane.xs[0]);
    if (begin < to) fill(begin, to, colour("line"), 1);
    // Columns that a stretch shorter than a column reaches show which part of their time is on; all else is exact.
    const fast = new Map();
    for (let i = Math.max(stretchAt(lane.xs, from), 0); i < lane.xs.length && lane.xs[i] < to; ++i) {
      const end = i + 1 < lane.xs.length ? lane.xs[i + 1] : lane.stop, share = lane.ys[i];
      const brief = i > 0 && i + 1 < lane.xs.length && end - lane.xs[i] < column;
      const a = Math.max(lane.xs[i], from), b = Math.min(end, to);
      if (!brief) {
        if (share > 0) fill(a, b, full, share === 1 ? 1 : 0.25 + 0.45 * share);
        continue;
      }
      for (let k = Math.floor((a - from) / column); k <= Math.min(Math.floor((b - from) / column), columns - 1); ++k) fast.set(k, 0);
    }
    const onTime = (a, b) => {
      let sum = 0;
      for (let i = Math.max(stretchAt(lane.xs, a), 0); i < lane.xs.length && lane.xs[i] < b; ++i) {
        const end = i + 1 < lane.xs.length ? lane.xs[i + 1] : lane.stop;
        sum += lane.ys[i] * Math.max(0, Math.min(b, end) - Math.max(a, lane.xs[i]));
      }
      return sum;
    };
    for (const k of fast.keys()) {
      const a = from + k * column, b = Math.min(a + column, to);
      fill(a, b, colour("line"), 1);
      fill(a, b, full, 0.25 + 0.45 * onTime(a, b) / column);
    }
    // Marks that cannot be told apart are one paler bar.
    const marks = lane.marks, near = 3 * column, half = 0.7 * column;
    c.fillStyle = colour("ink");
    for (let i = Math.max(stretchAt(marks, from), 0); i < marks.length && marks[i] <= to;) {
      if (marks[i] < from) { ++i; continue; }
      let last = i;
      while (last + 1 < marks.length && marks[last + 1] <= to && marks[last + 1] - marks[last] < near) ++last;
      const a = Math.max(marks[i] - half, from), b = Math.min(marks[last] + half, u.scales.x.max);
      c.globalAlpha = last > i ? 0.45 : 1;
      c.fillRect(px(a), y - 2 * ratio, px(b) - px(a), high + 2 * ratio);
      c.globalAlpha = 1;
      i = last + 1;
    }
  };
  const lanesPlot = (scene) => {
    const lanes = data.lanes.filter((lane) => lane.scene === scene)
      .map((lane) => ({...lane, xs: array(lane.t), ys: array(lane.s), marks: array(lane.marks)}));
    const tables = lanes.map((lane) => ({x: lane.xs, curves: [{name: lane.name, y: lane.ys, colour: lane.kind, lane, scene}]}));
    return {title: (many ? data.scenes[scene].name + ": m" : "M") + "odes of switches", unit: "", lanes, tables, name: data.scenes[scene].name + "_modes"};
  };
  const lanePlots = () => {
    const parent = document.getElementById("lanes");
    if (parent) for (const scene of new Set(data.lanes.map((lane) => lane.scene))) place(parent, lanesPlot(scene));
  };
  // What differs from a plot of curves.
  const laneOptions = (plot, options) => ({
    ...options,
    scales: {x: options.scales.x, y: {range: [0, 1]}},
    axes: [options.axes[0], {...options.axes[1], grid: {show: false}, ticks: {show: false}, values: () => [], size: 50}],
    hooks: {...options.hooks, draw: [(u) => {
      let row = 0;
      for (const series of u.series.slice(1)) { if (series.show) paintLane(u, series.lane, row); ++row; }
    }]},
  });
