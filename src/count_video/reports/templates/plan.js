"use strict";
// Count and shortest interval of the set-up on the sliders, read from a table of simulated trials.
(() => {
  const { request, rate, table, measured, resolved, options } = JSON.parse(
    document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const MAP = { gap: [0.005, 0.1], release: [0.02, 0.2], left: 50, right: 590, top: 8, bottom: 430 };
  const RATES = [60, 120, 240, 480, 960, 2000, 4000, 8000, 16000, 32000];
  const planned = { gap: request.gap_m, release: request.release_m, clay: 0, rate };
  let values = { ...planned };

  const digits = (value, n) => String(Number(value.toPrecision(n)));
  const heavyOf = (clay) => Number((request.heavy * (1 + clay / 100)).toPrecision(8));
  const SAID = {
    gap: (v) => `${digits(1000 * v, 4)} mm`,
    release: (v) => `${digits(1000 * v, 4)} mm`,
    clay: (v) => digits(heavyOf(v), 5),
    rate: (v) => `${digits(v, 5)} frames/s`,
  };
  const NAMES = Object.keys(SAID);

  // ---- the table ----------------------------------------------------------------------------------
  // The row of a cylinder: which gap over release gives which count, and how short an interval.
  function rowOf(clay) {
    const row = table.heavy_share.findIndex((share) => Math.abs(share - 1 - clay / 100) < 1e-6);
    return { theory: table.theory[row], counts: table.count[row], shortest: table.shortest_s[row] };
  }

  // Cells from one gap over release to another; a cell reaches half of the way to its neighbours.
  function cellsOf({ counts, shortest }) {
    const shares = table.gap_share;
    return shares.map((share, k) => ({
      count: counts[k] < 0 ? null : counts[k],
      shortest: shortest[k] ?? Infinity,  // of one collision alone it is not finite
      share,
      from: k ? (shares[k - 1] + share) / 2 : 0,
      to: k + 1 < shares.length ? (share + shares[k + 1]) / 2 : 1,
    }));
  }

  // Wedges of the map: neighbouring cells of one count are one.
  function wedgesOf(cells) {
    return cells.reduce((wedges, { count, from, to }) => {
      const last = wedges[wedges.length - 1];
      if (last?.count === count) last.to = to;
      else wedges.push({ count, from, to });
      return wedges;
    }, []);
  }

  // ---- the map, in which each gap over release is a ray -----------------------------------------
  const scale = ([low, high], from, to) => (v) => from + (to - from) * (v - low) / (high - low);
  const x = scale(MAP.gap, MAP.left, MAP.right);
  const y = scale(MAP.release, MAP.bottom, MAP.top);

  function draw(name, attributes, text) {
    const made = document.createElementNS(element("map").namespaceURI, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  }

  // Where a ray leaves the map, a little inside, so that words fit there.
  function endOf(share, inside = 1) {
    const release = inside * Math.min(MAP.release[1], MAP.gap[1] / share);
    return [x(share * release), y(release)];
  }

  function drawnWedges(wedges, theory) {
    const counts = wedges.map(({ count }) => count).filter((count) => count !== null);
    const [low, high] = [Math.min(...counts), Math.max(...counts)];
    const far = 2 * MAP.release[1];
    return wedges.filter(({ count }) => count !== null).map(({ count, from, to }) => draw("path", {
      class: count === theory ? "own" : "cell",
      "fill-opacity": count === theory ? 1 : 0.25 + 0.75 * (count - low) / Math.max(1, high - low),
      d: `M${x(0)},${y(0)}L${x(from * far)},${y(far)}L${x(to * far)},${y(far)}Z`,
    }));
  }

  function drawnCounts(wedges) {
    return wedges.filter(({ count }) => count !== null).flatMap(({ count, from, to }) => {
      const middle = (Math.max(from, table.gap_share[0]) + to) / 2;
      const [across, down] = endOf(middle, 0.94);
      const release = 0.94 * Math.min(MAP.release[1], MAP.gap[1] / middle);
      const wide = Math.min(x(to * release) - x(from * release),
        y(middle * release / to) - y(middle * release / from));
      return wide < 14 ? [] : [draw("text",
        { class: "count", x: across, y: down, "font-size": Math.min(24, 10 + wide / 6) }, count)];
    });
  }

  function drawnRates(cells) {
    const written = [];
    return RATES.flatMap((fps) => {
      const enough = cells.findIndex(({ shortest }) => shortest >= resolved / fps);
      if (enough < 1 || cells[enough - 1].count === null) return [];
      const { share } = cells[enough];
      const far = 2 * MAP.release[1];
      const line = draw("line",
        { class: "rate", x1: x(0), y1: y(0), x2: x(share * far), y2: y(far) });
      const [across, down] = endOf(share, 0.8);
      const free = written.every(([a, d]) => Math.abs(a - across) > 56 || Math.abs(d - down) > 18);
      if (!free || across < MAP.left + 28) return [line];
      written.push([across, down]);
      return [line, draw("text", { x: across, y: down }, `${fps}/s`)];
    });
  }

  function drawnAxes() {
    const down = (MAP.top + MAP.bottom) / 2;
    return [
      ...[2, 4, 6, 8, 10].map((cm) => draw("text", { x: x(cm / 100), y: 450 }, cm)),
      ...[5, 10, 15, 20].map((cm) => draw("text", { x: 36, y: y(cm / 100) + 6 }, cm)),
      draw("text", { x: (MAP.left + MAP.right) / 2, y: 473 }, "gap (cm)"),
      draw("text", { x: 14, y: down, transform: `rotate(-90 14 ${down})` }, "release (cm)"),
    ];
  }

  function drawMap(cells, theory) {
    const wedges = wedgesOf(cells);
    const box = { x: MAP.left, y: MAP.top, width: MAP.right - MAP.left, height: MAP.bottom - MAP.top };
    const clip = draw("clipPath", { id: "inside" });
    clip.append(draw("rect", box));
    const inside = draw("g", { "clip-path": "url(#inside)" });
    const [across, down] = [x(values.gap), y(values.release)];
    const { gap_m: gap, release_m: release } = request.tolerances;
    inside.append(draw("rect", { class: "ground", ...box }), ...drawnWedges(wedges, theory),
      ...drawnRates(cells), ...drawnCounts(wedges),
      draw("ellipse", { class: "edge", cx: across, cy: down, rx: x(2 * gap) - x(0),
        ry: y(0) - y(2 * release) }),
      draw("circle", { class: "dot", cx: across, cy: down, r: 6 }));
    element("map").replaceChildren(clip, inside, ...drawnAxes());
  }

  // ---- words ------------------------------------------------------------------------------------
  function cameraWords({ count, shortest }) {
    const frames = shortest * values.rate;
    const like = measured.find((one) => frames >= one.shortest_frames
      && one.counts[0] <= count && count <= one.counts[1] && values.rate >= one.capture_fps);
    const shown = frames >= resolved ? "sees each collision"
      : `${digits(frames, 2)} frames from one to the next at the closest`;
    if (!like) return `${shown}; whether such a clip is counted was never measured`;
    const chance = (like.exact + 1) / (like.clips + 2);  // Laplace's rule of succession
    return `${shown}; counted exactly with a chance of ${(100 * chance).toFixed(chance < 0.99 ? 0 : 1)}% `
      + `(${like.exact} of ${like.clips} ${like.kind})`;
  }

  function theoryWords(count, theory) {
    if (values.gap > values.release) return "The gap is larger than the release.";
    if (heavyOf(values.clay) < request.light) return "The cylinder is lighter than the ball: no count.";
    if (count === undefined) return "The ball rattles to rest between cylinder and wall: no count.";
    return count === theory ? `Theory: ${theory}, the same`
      : `Theory: ${theory} for free bodies without losses`;
  }

  /** Show a command; no line is to break at the hyphens of an option. */
  function showCommand(command) {
    const parts = command.split(/(--[a-z-]+)/).map((part) => {
      if (!part.startsWith("--")) return part;
      const option = document.createElement("span");
      option.className = "option";
      option.textContent = part;
      return option;
    });
    element("command").replaceChildren(...parts);
  }

  function show() {
    for (const name of NAMES) {
      element(name).value = name === "rate" ? Math.log10(values.rate) : values[name];
      element(`${name}-value`).textContent = SAID[name](values[name]);
      element(name).setAttribute("aria-valuetext", SAID[name](values[name]));
    }
    const row = rowOf(values.clay);
    const cells = cellsOf(row);
    const share = values.gap / values.release;
    const here = cells.find(({ count, from, to }) => count !== null && from <= share && share <= to);
    const { shortest } = here ?? {};
    element("count").textContent = here?.count ?? "–";
    element("noun").textContent = here?.count === 1 ? "collision" : "collisions";
    element("theory").textContent = theoryWords(here?.count, row.theory);
    element("theory").className = `theory ${here?.count === row.theory ? "same" : "off"}`;
    element("shortest").textContent = !here ? "–" : shortest === Infinity ? "one collision alone"
      : `${digits(1000 * shortest, 3)} ms from one to the next`;
    element("needed").textContent = !here ? "–"
      : `${10 * Math.max(1, Math.ceil(resolved / shortest / 10))} frames a second to see each`;
    element("camera").textContent = here ? cameraWords(here) : "–";
    showCommand(`count-video --plan ${heavyOf(values.clay)} ${request.light} `
      + `--gap ${digits(values.gap, 4)} --release ${digits(values.release, 4)}${options} `
      + `--capture-fps ${digits(values.rate, 5)}`);
    drawMap(cells, row.theory);
  }

  // ---- hands and keys -----------------------------------------------------------------------------
  const within = (value, [low, high]) => Number(Math.min(high, Math.max(low, value)).toFixed(4));

  function moveTo(gap, release) {
    values = { ...values, gap: within(gap, MAP.gap), release: within(release, MAP.release) };
    show();
  }

  for (const name of NAMES) {
    element(name).addEventListener("input", () => {
      const raw = Number(element(name).value);
      values = { ...values, [name]: name === "rate" ? Math.round(10 ** raw) : Number(raw.toFixed(6)) };
      show();
    });
  }
  element("reset").addEventListener("click", () => { values = { ...planned }; show(); });
  element("map").addEventListener("click", (event) => {
    const at = new DOMPoint(event.clientX, event.clientY)
      .matrixTransform(element("map").getScreenCTM().inverse());
    moveTo(scale([MAP.left, MAP.right], ...MAP.gap)(at.x),
      scale([MAP.bottom, MAP.top], ...MAP.release)(at.y));
  });
  const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
  element("map").addEventListener("keydown", (event) => {
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    moveTo(values.gap + 0.001 * step[0], values.release + 0.002 * step[1]);
  });
  show();
})();
