"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const NAMES = ["gap", "release", "heavy", "light", "heavyThread", "lightThread", "restitution",
    "rate"];
  const LOGARITHMIC = new Set(["heavy", "light", "rate"]);
  const USUAL_RATES = [60, 120, 240, 480, 960, 2000, 4000, 8000, 16000, 32000];
  const TRIALS = 300;
  const planned = Object.fromEntries(NAMES.map((name) => [name, data.planned[name]]));
  // The planned values themselves, not where the sliders' steps put them, until one is moved.
  let values = { ...planned };
  let wedges = null;

  // ---- values ---------------------------------------------------------------------------------
  const digits = (value, n) => String(Number(value.toPrecision(n)));
  const rounded = (name, value) => (name === "rate" ? Math.round(value) : Number(value.toPrecision(4)));
  const SAID = {
    gap: (v) => `${digits(1000 * v, 4)} mm`,
    release: (v) => `${digits(1000 * v, 4)} mm`,
    heavy: (v) => digits(v, 5),
    light: (v) => digits(v, 5),
    heavyThread: (v) => `${digits(v, 4)} m`,
    lightThread: (v) => `${digits(v, 4)} m`,
    restitution: (v) => v.toFixed(3),
    rate: (v) => `${digits(v, 5)} frames/s`,
  };

  function setupOf(at) {
    return {
      ratio: at.heavy / at.light, gap: at.gap, release: at.release,
      heavyThread: at.heavyThread, lightThread: at.lightThread, damping: data.damping,
      restitutionBodies: at.restitution, restitutionWall: at.restitution,
    };
  }

  function nonsense(at) {
    if (at.gap > at.release) return "The gap is larger than the release.";
    if (at.heavy < at.light) return "The cylinder is lighter than the ball.";
    return "";
  }

  // ---- colours and canvases -------------------------------------------------------------------
  const colour = (name) => getComputedStyle(document.documentElement)
    .getPropertyValue(`--${name}`).trim();

  function pen(id) {
    const canvas = element(id);
    const box = canvas.getBoundingClientRect();
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(box.width * scale);
    canvas.height = Math.round(box.height * scale);
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    context.font = "13px system-ui, 'DejaVu Sans', sans-serif";
    context.fillStyle = colour("paper");
    context.fillRect(0, 0, box.width, box.height);
    return { context, width: box.width, height: box.height };
  }

  function write(context, text, x, y, size = 13, weight = "400", fill = "ink") {
    context.font = `${weight} ${size}px system-ui, 'DejaVu Sans', sans-serif`;
    context.lineWidth = 3;
    context.lineJoin = "round";
    context.strokeStyle = colour("paper");
    context.strokeText(text, x, y);
    context.fillStyle = colour(fill);
    context.fillText(text, x, y);
  }

  function mixed(share) {
    const parts = (name) => colour(name).match(/[0-9a-f]{2}/gi).map((hex) => parseInt(hex, 16));
    const [low, high] = [parts("low"), parts("high")];
    return `rgb(${low.map((part, k) => Math.round(part + share * (high[k] - part))).join(",")})`;
  }

  // ---- the map ----------------------------------------------------------------------------------
  // The pendulums are linear: counts and times hang on gap over release alone, so that regions of
  // one count are wedges, and one scan of that ratio is the whole map.
  const MAP = { gap: [0.005, 0.1], release: [0.02, 0.2], left: 46, right: 8, top: 8, bottom: 40 };
  const MOST_RATIOS = 500;

  function scan() {
    const setup = setupOf(values);
    const key = JSON.stringify({ ...setup, gap: 0, release: 0 });
    if (wedges && wedges.key === key) return wedges;
    const rows = [];
    const least = MAP.gap[0] / MAP.release[1];
    // Fewer steps where each takes long, so that a slider stays quick.
    const steps = Math.max(60, Math.min(MOST_RATIOS, 40000 / planCore.theory(setup.ratio)));
    for (let k = 0; k < steps; k += 1) {
      const ratio = Math.min(1, least + (1 - least) * (k / (steps - 1)) ** 1.5);
      const found = planCore.facts({ ...setup, release: 0.1, gap: 0.1 * ratio });
      rows.push({ ratio, count: found.endless ? null : found.count, shortest: found.shortest });
    }
    wedges = { key, rows };
    return wedges;
  }

  function mapScale(width, height) {
    const across = width - MAP.left - MAP.right;
    const down = height - MAP.top - MAP.bottom;
    const [g0, g1] = MAP.gap;
    const [r0, r1] = MAP.release;
    return {
      x: (gap) => MAP.left + across * (gap - g0) / (g1 - g0),
      y: (release) => MAP.top + down * (r1 - release) / (r1 - r0),
      gap: (x) => g0 + (g1 - g0) * (x - MAP.left) / across,
      release: (y) => r1 - (r1 - r0) * (y - MAP.top) / down,
    };
  }

  function drawMap(theory) {
    const { context, width, height } = pen("map");
    const scale = mapScale(width, height);
    const { rows } = scan();
    const counts = rows.map((row) => row.count).filter((count) => count !== null);
    const low = Math.min(...counts);
    const high = Math.max(...counts);
    context.save();
    context.beginPath();
    context.rect(scale.x(MAP.gap[0]), scale.y(MAP.release[1]),
      scale.x(MAP.gap[1]) - scale.x(MAP.gap[0]), scale.y(MAP.release[0]) - scale.y(MAP.release[1]));
    context.fillStyle = colour("none");
    context.fill();
    context.clip();
    const regions = [];
    for (let k = 0; k < rows.length;) {
      let last = k;
      while (last + 1 < rows.length && rows[last + 1].count === rows[k].count) last += 1;
      const from = k ? (rows[k - 1].ratio + rows[k].ratio) / 2 : 0;
      const to = last + 1 < rows.length ? (rows[last].ratio + rows[last + 1].ratio) / 2 : 1;
      regions.push({ count: rows[k].count, from, to });
      k = last + 1;
    }
    const edge = MAP.release[1];
    for (const { count, from, to } of regions) {
      if (count === null) continue;
      context.beginPath();
      context.moveTo(scale.x(0), scale.y(0));
      context.lineTo(scale.x(from * edge), scale.y(edge));
      context.lineTo(scale.x(to * edge), scale.y(edge));
      context.closePath();
      context.fillStyle = count === theory ? colour("own")
        : mixed(high > low ? (count - low) / (high - low) : 0.5);
      context.fill();
    }
    drawRates(context, scale, rows);
    drawCounts(context, scale, regions);
    context.restore();
    drawAxes(context, scale, width, height);
    drawDot(context, scale);
  }

  function drawRates(context, scale, rows) {
    context.textAlign = "center";
    const written = [];
    for (const rate of USUAL_RATES) {
      const shortest = planCore.RESOLVED_FRAMES / rate;
      for (let k = 1; k < rows.length; k += 1) {
        const [a, b] = [rows[k - 1], rows[k]];
        if (!(a.shortest < shortest && b.shortest >= shortest)) continue;
        const ratio = a.ratio + (b.ratio - a.ratio) * (shortest - a.shortest)
          / (b.shortest - a.shortest);
        context.beginPath();
        context.moveTo(scale.x(0), scale.y(0));
        context.lineTo(scale.x(ratio * 0.25), scale.y(0.25));
        context.strokeStyle = colour("ink");
        context.lineWidth = 1;
        context.setLineDash([5, 4]);
        context.stroke();
        context.setLineDash([]);
        const release = Math.min(0.16, 0.082 / ratio);
        const [x, y] = [scale.x(ratio * release), scale.y(release)];
        const free = written.every((p) => Math.abs(p[0] - x) > 44 || Math.abs(p[1] - y) > 15);
        if (free && x > MAP.left + 22) {
          write(context, `${rate}/s`, x, y, 12);
          written.push([x, y]);
        }
        break;
      }
    }
  }

  function drawCounts(context, scale, regions) {
    context.textAlign = "center";
    context.textBaseline = "middle";
    for (const { count, from, to } of regions) {
      if (count === null) continue;
      const middle = (from + to) / 2;
      const release = Math.min(0.19, 0.094 / middle);
      const wide = Math.abs(scale.x(to * release) - scale.x(from * release));
      const tall = Math.abs(scale.y(middle * release / to) - scale.y(middle * release / from));
      if (Math.min(wide, tall) < 13) continue;
      write(context, String(count), scale.x(middle * release), scale.y(release),
        Math.min(22, 10 + Math.min(wide, tall) / 6), "700");
    }
    context.textBaseline = "alphabetic";
  }

  function drawAxes(context, scale, width, height) {
    context.textAlign = "center";
    for (let cm = 2; cm <= 10; cm += 2) write(context, String(cm), scale.x(cm / 100), height - 23);
    write(context, "gap (cm)", (MAP.left + width) / 2, height - 6);
    context.textAlign = "right";
    for (let cm = 5; cm <= 20; cm += 5) write(context, String(cm), MAP.left - 6, scale.y(cm / 100) + 4);
    context.save();
    context.translate(13, height / 2);
    context.rotate(-Math.PI / 2);
    context.textAlign = "center";
    write(context, "release (cm)", 0, 0);
    context.restore();
  }

  function drawDot(context, scale) {
    const [x, y] = [scale.x(values.gap), scale.y(values.release)];
    context.strokeStyle = colour("vermilion");
    context.lineWidth = 2;
    context.beginPath();
    context.ellipse(x, y, Math.abs(scale.x(2 * data.tolerances.gap_m) - scale.x(0)),
      Math.abs(scale.y(2 * data.tolerances.release_m) - scale.y(0)), 0, 0, 2 * Math.PI);
    context.stroke();
    context.beginPath();
    context.arc(x, y, 5, 0, 2 * Math.PI);
    context.fillStyle = colour("vermilion");
    context.fill();
  }

  // ---- space and time, and the phase circle -------------------------------------------------------
  function isClear(found, k) {
    const clear = planCore.RESOLVED_FRAMES / values.rate;
    const gaps = [Infinity, ...found.intervals, Infinity];
    return Math.min(gaps[k], gaps[k + 1]) >= clear;
  }

  function densest(found) {
    const times = found.collisions.map((c) => c.time);
    const whole = [times[0], times[times.length - 1]];
    if (times.length < 3) return whole;
    const held = Math.max(3, Math.round(0.6 * times.length));
    let best = 0;
    for (let k = 0; k + held <= times.length; k += 1) {
      if (times[k + held - 1] - times[k] < times[best + held - 1] - times[best]) best = k;
    }
    return [times[best], times[best + held - 1]];
  }

  function drawPaths(id, found, span, frame) {
    const { context, width, height } = pen(id);
    const margin = 0.06 * (span[1] - span[0]) + 1e-4;
    const [from, to] = [span[0] - margin, span[1] + margin];
    const diameter = data.ballDiameter;
    const times = Array.from({ length: 700 }, (_, k) => from + (to - from) * k / 699);
    found.states.forEach((state) => { if (state.time > from && state.time < to) times.push(state.time); });
    times.sort((a, b) => a - b);
    const places = times.map((time) => planCore.at(found, time));
    const top = Math.max(...places.map((place) => place.heavy)) + 1.4 * diameter;
    const bottom = -0.3 * diameter;
    const x = (time) => 44 + (width - 52) * (time - from) / (to - from);
    const y = (place) => 8 + (height - 44) * (top - place) / (top - bottom);
    const area = (name, outline, upper, lower) => {
      context.beginPath();
      places.forEach((place, k) => context.lineTo(x(times[k]), y(upper(place))));
      [...places].reverse().forEach((place, k) => context
        .lineTo(x(times[times.length - 1 - k]), y(lower(place))));
      context.closePath();
      context.fillStyle = colour(name);
      context.fill();
      context.beginPath();
      places.forEach((place, k) => context.lineTo(x(times[k]), y(lower(place))));
      context.strokeStyle = colour(outline);
      context.lineWidth = 1.5;
      context.stroke();
    };
    area("heavy-fill", "heavy", () => top, (place) => place.heavy + diameter);
    area("ball-fill", "ball", (place) => place.ball + diameter, (place) => place.ball);
    context.fillStyle = colour("wall");
    context.fillRect(x(from), y(0), x(to) - x(from), y(bottom) - y(0));
    if (frame) {
      context.strokeStyle = colour("vermilion");
      context.strokeRect(x(frame[0]), 9, x(frame[1]) - x(frame[0]), height - 46);
    }
    drawMarks(context, found, { x, y, from, to, few: !frame, diameter });
    context.textAlign = "center";
    const step = roundStep(1000 * (to - from) / Math.max(3, width / 110));
    for (let ms = Math.ceil(1000 * from / step) * step; ms < 1000 * to; ms += step) {
      write(context, digits(ms, 7), x(ms / 1000), height - 20);
    }
    write(context, "ms from the release", width / 2, height - 5, 12);
    context.textAlign = "right";
    for (let mm = 0; mm < 1000 * top; mm += 1000 * top > 120 ? 40 : 20) {
      write(context, String(mm), 40, y(mm / 1000) + 4, 12);
    }
  }

  // The next of 1, 2, 5, 10, 20 ... from a number on.
  function roundStep(least) {
    const power = 10 ** Math.floor(Math.log10(least));
    return power * [1, 2, 5, 10].find((factor) => factor * power >= least * (1 - 1e-9));
  }

  function drawMarks(context, found, { x, y, from, to, few, diameter }) {
    const last = { bodies: -100, wall: -100 };
    context.textAlign = "center";
    found.collisions.forEach((c, k) => {
      if (c.time < from || c.time > to) return;
      const bodies = c.kind === "bodies";
      const [px, py] = [x(c.time), y(bodies ? c.place + diameter : 0)];
      const ink = colour(bodies ? "vermilion" : "blue");
      context.beginPath();
      if (bodies) context.arc(px, py, 5, 0, 2 * Math.PI); else context.rect(px - 4.5, py - 4.5, 9, 9);
      context.lineWidth = 2;
      context.fillStyle = isClear(found, k) ? ink : colour("paper");
      context.fill();
      context.strokeStyle = ink;
      context.stroke();
      if (px - last[c.kind] < (few ? 18 : 26)) return;
      last[c.kind] = px;
      write(context, String(k + 1), px, bodies ? py - 9 : py + 18, 12, "700");
    });
  }

  function drawCircle(found, ratio, theory) {
    const { context, width, height } = pen("circle");
    const radius = Math.min(width, height) / 2.5;
    const [cx, cy] = [width / 2, height / 2];
    const theta = Math.atan(Math.sqrt(1 / ratio));
    context.beginPath();
    context.moveTo(cx, cy);
    context.arc(cx, cy, radius, -theta, 0);
    context.closePath();
    context.fillStyle = colour("ball-fill");
    context.fill();
    context.strokeStyle = colour("line");
    context.lineWidth = 1;
    if (theory < 120) {
      context.beginPath();
      for (let k = 0; k <= theory; k += 1) {
        const angle = Math.ceil(k / 2) * 2 * theta;
        const side = k % 2 ? 1 : -1;
        context.lineTo(cx - radius * Math.cos(angle), cy + side * radius * Math.sin(angle));
      }
      context.stroke();
    }
    context.strokeStyle = colour("ink");
    context.beginPath();
    context.arc(cx, cy, radius, 0, 2 * Math.PI);
    context.stroke();
    if (!found.collisions.length) return;
    const first = found.collisions[0].before;
    const length = Math.hypot(Math.sqrt(ratio) * first.heavyVelocity, first.ballVelocity);
    context.textAlign = "center";
    found.collisions.forEach((c, k) => {
      const v1 = Math.sqrt(ratio) * c.after.heavyVelocity / length;
      const v2 = c.after.ballVelocity / length;
      const [x, y] = [cx + radius * v1, cy - radius * v2];
      context.beginPath();
      if (c.kind === "bodies") context.arc(x, y, 4, 0, 2 * Math.PI); else context.rect(x - 3.5, y - 3.5, 7, 7);
      context.fillStyle = colour(c.kind === "bodies" ? "vermilion" : "blue");
      context.fill();
      const away = 1 + 16 / Math.max(30, radius * Math.hypot(v1, v2));
      if (found.collisions.length <= 45 || k % 20 === 0) {
        write(context, String(k + 1), cx + (x - cx) * away, cy + (y - cy) * away + 4, 11);
      }
    });
    write(context, `M : m = ${digits(ratio, 4)} : 1`, cx, cy + 0.4 * radius, 13);
    write(context, `theory counts ${theory}`, cx, cy + 0.4 * radius + 18, 13);
    write(context, "V₁ = √M v₁ to the right, V₂ = √m v₂ upward", cx, height - 6, 12);
  }

  // ---- words ----------------------------------------------------------------------------------
  function list(rows) {
    element("facts").replaceChildren(...rows.flatMap(([label, text]) => {
      const [term, said] = [document.createElement("dt"), document.createElement("dd")];
      term.textContent = label;
      said.textContent = text;
      return [term, said];
    }));
  }

  function way(count, frames, rate) {
    const first = data.likenesses.find((like) => frames >= like.shortest_frames
      && like.counts[0] <= count && count <= like.counts[1] && rate >= like.capture_fps);
    return first ? first.measured : null;
  }

  function cameraWords(found) {
    const frames = found.shortest * values.rate;
    const close = found.intervals
      .filter((s) => s * values.rate < planCore.RESOLVED_FRAMES).length;
    const like = way(found.count, frames, values.rate);
    const shown = close ? `${close} closer than 2.5 frames to the one before` : "sees each collision";
    if (like === null) return `${shown}; whether such a clip is counted was never measured`;
    const chance = (like.exact + 1) / (like.clips + 2);  // Laplace's rule of succession
    return `${shown}; counted exactly with a chance of ${(100 * chance).toFixed(chance < 0.99 ? 0 : 1)}% `
      + `(${like.exact} of ${like.clips} ${like.kind})`;
  }

  function factsOf(found) {
    const last = found.collisions[found.collisions.length - 1];
    const first = found.collisions[0];
    const end = found.turn === Infinity ? last.time : found.turn;
    const hops = found.collisions.slice(1)
      .map((c, k) => (c.kind === found.collisions[k].kind ? Infinity
        : Math.abs(c.place - found.collisions[k].place)))
      .filter((hop) => hop < Infinity);
    const ms = found.shortest === Infinity ? "one collision alone"
      : `${digits(1000 * found.shortest, 3)} ms`;
    return [
      ["Kinds", `${found.bodies} between the bodies, ${found.count - found.bodies} with the wall`],
      ["Shortest", ms],
      ["Film at", `${found.needed} frames a second to see each`],
      ["Camera", cameraWords(found)],
      ["Burst", `${first.time.toFixed(2)} to ${last.time.toFixed(2)} s after the release`],
      ["Run until", `${end.toFixed(2)} s, when the cylinder turns round, `
        + `${digits(1000 * (planCore.at(found, end).heavy - values.gap), 3)} mm beyond its rest`],
      ["Last", `${digits(1000 * last.place, 3)} mm from the wall, closing at `
        + `${digits(1000 * Math.abs(last.approach), 3)} mm/s`],
      ["Shortest hop", hops.length ? `${digits(1000 * Math.min(...hops), 3)} mm` : "none"],
    ];
  }

  // ---- trials with the planned tolerances --------------------------------------------------------
  // Mulberry32, a small generator with a seed, and normal numbers by Box and Muller.
  function chance(seed) {
    let state = seed >>> 0;
    const even = () => {
      state = (state + 0x6D2B79F5) >>> 0;
      let t = state;
      t = Math.imul(t ^ (t >>> 15), t | 1);
      t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
      return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
    };
    const normal = () => Math.sqrt(-2 * Math.log(1 - even())) * Math.cos(2 * Math.PI * even());
    return { even, normal };
  }

  function drawn(trial) {
    const { even, normal } = chance(7919 * trial + data.seed + 1);
    const off = data.tolerances;
    const at = setupOf(values);
    const high = Math.min(1, values.restitution + off.restitution / 2);
    const low = Math.max(0, high - off.restitution);
    return planCore.burst({
      ...at,
      ratio: at.ratio * (1 + off.mass * normal()) / (1 + off.mass * normal()),
      gap: Math.max(1e-4, at.gap + off.gap_m * normal()),
      release: Math.max(1e-4, at.release + off.release_m * normal()),
      heavyThread: at.heavyThread + off.thread_m * normal(),
      lightThread: at.lightThread + off.thread_m * normal(),
      restitutionBodies: low + (high - low) * even(),
      restitutionWall: low + (high - low) * even(),
    }, () => off.scatter * normal());
  }

  function showTrials(theory) {
    const trials = Math.max(40, Math.min(TRIALS, Math.round(20000 / Math.max(1, theory))));
    const histogram = new Map();
    let endless = 0;
    for (let k = 0; k < trials; k += 1) {
      const found = drawn(k);
      if (found.endless) endless += 1;
      else histogram.set(found.collisions.length, (histogram.get(found.collisions.length) || 0) + 1);
    }
    const rows = [...histogram].sort((a, b) => b[1] - a[1]).slice(0, 7).sort((a, b) => b[0] - a[0]);
    element("sure").textContent = `${trials} simulated trials with the planned tolerances`
      + `${endless ? `; in ${endless} the ball rattles to rest and nothing is counted` : ""}:`;
    element("bars").replaceChildren(...rows.map(([count, number]) => {
      const row = document.createElement("li");
      if (count === theory) row.className = "own";
      const parts = ["span", "span", "span"].map((tag) => document.createElement(tag));
      parts[0].textContent = count;
      parts[1].className = "bar";
      parts[1].style.width = `${100 * number / trials}%`;
      parts[2].textContent = `${Math.round(100 * number / trials)}%`;
      row.append(...parts);
      return row;
    }));
  }

  // ---- everything -------------------------------------------------------------------------------
  function show() {
    for (const name of NAMES) element(`${name}-value`).textContent = SAID[name](values[name]);
    const threads = values.heavyThread === values.lightThread ? [values.heavyThread]
      : [values.heavyThread, values.lightThread];
    element("command").textContent = `count-video --plan ${digits(values.heavy, 6)} `
      + `${digits(values.light, 6)} --gap ${digits(values.gap, 4)} `
      + `--release ${digits(values.release, 4)} --thread ${threads.join(" ")} `
      + `--restitution ${digits(values.restitution, 4)} --capture-fps ${digits(values.rate, 5)}`
      + data.options;
    const wrong = nonsense(values);
    const line = element("theory");
    const found = wrong ? null : planCore.facts(setupOf(values));
    const theory = planCore.theory(values.heavy / values.light);
    document.body.dataset.count = found && !found.endless ? found.count : "";
    if (!found || found.endless || !found.count) {
      element("count").textContent = "–";
      line.textContent = wrong || "The ball rattles to rest between cylinder and wall: no count.";
      line.className = "theory off";
      list([]);
      element("bars").replaceChildren();
      element("sure").textContent = "";
      for (const id of ["whole", "enlarged", "circle"]) pen(id);
    } else {
      element("count").textContent = found.count;
      element("noun").textContent = found.count === 1 ? "collision" : "collisions";
      line.textContent = found.count === theory ? `Theory: ${theory}, the same`
        : `Theory: ${theory} for free bodies without losses`;
      line.className = `theory ${found.count === theory ? "same" : "off"}`;
      list(factsOf(found));
      showTrials(theory);
      const middle = densest(found);
      const times = found.collisions.map((c) => c.time);
      drawPaths("whole", found, [times[0], times[times.length - 1]], middle);
      drawPaths("enlarged", found, middle, null);
      drawCircle(found, values.heavy / values.light, theory);
    }
    drawMap(theory);
  }

  let waiting = false;
  function soon() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; show(); });
  }

  function place(name) {
    element(name).value = LOGARITHMIC.has(name) ? Math.log10(values[name]) : values[name];
  }

  function set(name, value) {
    values[name] = value;
    if (element("alike").checked && name === "heavyThread") values.lightThread = value;
    if (element("alike").checked && name === "lightThread") values.heavyThread = value;
    NAMES.forEach(place);
    soon();
  }

  for (const name of NAMES) {
    element(name).addEventListener("input", () => {
      const raw = Number(element(name).value);
      set(name, LOGARITHMIC.has(name) ? rounded(name, 10 ** raw) : Number(raw.toFixed(6)));
    });
  }
  element("alike").addEventListener("change", () => set("heavyThread", values.heavyThread));
  element("reset").addEventListener("click", () => {
    values = { ...planned };
    element("alike").checked = planned.heavyThread === planned.lightThread;
    NAMES.forEach(place);
    soon();
  });

  const within = (value, [low, high]) => Math.min(high, Math.max(low, value));
  function moveTo(gap, release) {
    values.gap = Number(within(gap, MAP.gap).toFixed(4));
    values.release = Number(within(release, MAP.release).toFixed(4));
    NAMES.forEach(place);
    soon();
  }
  element("map").addEventListener("click", (event) => {
    const box = element("map").getBoundingClientRect();
    const scale = mapScale(box.width, box.height);
    moveTo(scale.gap(event.clientX - box.left), scale.release(event.clientY - box.top));
  });
  const STEPS = { ArrowLeft: [-0.001, 0], ArrowRight: [0.001, 0], ArrowUp: [0, 0.002],
    ArrowDown: [0, -0.002] };
  element("map").addEventListener("keydown", (event) => {
    const step = STEPS[event.key];
    if (!step) return;
    event.preventDefault();
    moveTo(values.gap + step[0], values.release + step[1]);
  });
  window.addEventListener("resize", soon);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", soon);
  NAMES.forEach(place);
  show();
})();
