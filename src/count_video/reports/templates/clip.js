"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const video = element("video");
  const collisions = data.result.collisions
    .map((c) => ({ ...c, in_burst: c.number <= data.burst_size, cuts: data.cuts[c.number] }));
  const msAFrame = data.result.capture_fps === null ? null : 1000 / data.result.capture_fps;
  const correction = ({ action, kind, frame, number }) => (
    { action, kind, frame, number: action === "wrong" ? number : null });
  const words = { bodies: "between the bodies", wall: "with the wall" };
  // What a person changed; each change replaces it as a whole, so that undo is the one before.
  let review = { corrections: data.result.corrections.map(correction), notes: { ...data.result.notes } };
  const before = [];
  let chosen = null;

  // A blob can be sought in on every browser; a data address cannot on some phones.
  const bytes = Uint8Array.from(atob(video.src.split(",")[1]), (sign) => sign.charCodeAt(0));
  video.src = URL.createObjectURL(new Blob([bytes], { type: "video/mp4" }));

  // The browser's own controls would cover the strip; without this script they are there.
  video.controls = false;

  // ---- frames and times -------------------------------------------------------------------
  const rowAt = (time) => Math.max(0, data.times.findLastIndex((begins) => begins <= time));

  // Place of the frame that is nearest to one.
  const nearest = (frames, frame) => frames.reduce((best, value, place) => (
    Math.abs(value - frame) < Math.abs(frames[best] - frame) ? place : best), 0);

  function show(row) {
    const inside = Math.min(Math.max(row, 0), data.times.length - 1);
    const next = inside + 1 < data.times.length ? data.times[inside + 1] : data.times[inside] + 0.03;
    video.pause();
    video.currentTime = (data.times[inside] + next) / 2;  // well inside: rounding cannot miss it
  }

  const row = () => rowAt(video.currentTime);

  function showFrame() {
    element("frame").textContent = data.frames[row()];
    element("seek").value = row();
    element("play").textContent = video.paused ? "Play" : "Stop";
    element("play").setAttribute("aria-pressed", String(!video.paused));
  }

  // A film that is stopped before it began to play says so by an error.
  const playOrStop = () => (video.paused ? video.play().catch(() => {}) : video.pause());

  // ---- what is there, with the corrections laid over it -----------------------------------
  const isWrong = (c) => review.corrections
    .some((k) => k.action === "wrong" && k.number === c.number);

  function entries() {
    const missed = review.corrections.filter((k) => k.action === "missed")
      .map((k) => ({ ...k, number: null, seen: true, in_burst: k.frame < data.burst_ends }));
    return [...collisions, ...missed].sort((a, b) => a.frame - b.frame);
  }

  function reviewedCount() {
    return entries().filter((c) => c.in_burst && !(c.number !== null && isWrong(c))).length;
  }

  const key = (c) => (c === null ? "" : `${c.number ?? "+"}/${c.kind}/${c.frame}`);
  const nameOf = (c) => (c === null ? "the clip"
    : c.number === null ? "the added collision" : `collision ${c.number}`);

  // ---- drawing ----------------------------------------------------------------------------
  function make(tag, attributes, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  }

  function remarks(c) {
    const change = c.number === null ? "added" : isWrong(c) && "marked wrong";
    return [change, !c.seen && "inferred", !c.in_burst && "after the burst",
      review.notes[key(c)] && "note"].filter(Boolean).join(", ");
  }

  const placed = (c) => (msAFrame === null
    ? (c.number === null ? String(c.frame) : c.frame.toFixed(1))
    : `${c.frame.toFixed(1)} · ${(c.frame * msAFrame).toFixed(1)} ms`);

  function listItem(c) {
    const removed = c.number !== null && isWrong(c);
    const button = make("button", { type: "button", "data-key": key(c) },
      make("span", {}, c.number === null ? "+" : String(c.number)),
      make("span", { class: `mark ${c.kind}${c.seen ? "" : " inferred"}`, "aria-hidden": "true" }),
      make("span", {}, make("span", { class: removed ? "removed" : "" }, c.kind), " ",
        make("span", { class: "note" }, remarks(c))),
      make("span", {}, placed(c)));
    button.setAttribute("aria-current", key(c) === key(chosen) ? "true" : "false");
    // One stop of the tab key for the whole list; arrow keys go through it.
    button.tabIndex = key(c) === key(chosen ?? entries()[0]) ? 0 : -1;
    button.addEventListener("click", () => choose(c));
    return make("li", {}, button);
  }

  function draw() {
    const focused = document.activeElement?.dataset?.key;
    const scrolled = element("list").scrollTop;
    element("list").replaceChildren(...entries().map(listItem));
    element("list").scrollTop = scrolled;
    if (focused !== undefined) focusOn(focused);
    const { corrections } = review;
    element("undo").disabled = before.length === 0;
    // A file may take back what one before it says.
    element("save").disabled = asText(review) === saved && corrections.length === 0
      && Object.keys(review.notes).length === 0;
    element("wrong").disabled = chosen === null;
    const added = chosen !== null && chosen.number === null;
    element("wrong").firstChild.textContent = added ? "Take away "
      : chosen !== null && isWrong(chosen) ? "Mark right " : "Mark wrong ";
    const wrong = corrections.filter((k) => k.action === "wrong").length;
    const changes = `${wrong} marked wrong, ${corrections.length - wrong} added`;
    element("reviewed").textContent =
      corrections.length ? `Reviewed count: ${reviewedCount()} (${changes})` : "";
    element("note-on").textContent = nameOf(chosen);
    if (document.activeElement !== element("note")) element("note").value = review.notes[key(chosen)] ?? "";
    element("listed").textContent = `${entries().length} in the list`;
    if (chosen === null) {
      element("contact-title").textContent = entries().length
        ? "Choose a collision to see its frames" : "No collision to show";
      element("cuts").replaceChildren();
    }
    drawState();
  }

  function focusOn(wanted) {
    for (const button of element("list").querySelectorAll("button")) {
      if (button.dataset.key === wanted) button.focus({ preventScroll: true });
    }
  }

  function drawContact(c) {
    const name = c.number === null ? "Added collision" : `Collision ${c.number}`;
    element("contact-title").textContent = `${name} ${words[c.kind]}, frame ${placed(c)}`;
    const cuts = (c.cuts ?? []).map(([frame, picture]) => make("figure", {},
      make("img", { src: picture, alt: `frame ${frame}, enlarged at the contact` }),
      make("figcaption", {}, `frame ${frame}`)));
    element("cuts").replaceChildren(...cuts);
  }

  // ---- keeping: in this browser at every change, and as a file ------------------------------
  const shelf = `count-video ${data.clip_sha256 || data.clip}`;
  const asText = (one) => JSON.stringify([one.corrections, one.notes]);
  let saved = asText(review);
  const opened = saved;

  function drawState(trouble) {
    const dirty = asText(review) !== saved;
    const kept = dirty && remember() ? "; kept in this browser" : "";
    element("state").className = dirty || trouble ? "state" : "state saved";
    element("state").textContent = trouble ?? (dirty ? `Not saved to a file yet${kept}`
      : saved === opened ? "" : "Saved to a file");
  }

  function remember() {
    try {
      localStorage.setItem(shelf, JSON.stringify({ clip: data.clip, ...review, saved }));
      return true;
    } catch {
      return false;  // a browser that keeps nothing
    }
  }

  // Only what a review of this clip can hold is taken from outside; null if it is none.
  function readReview(text) {
    try {
      const { clip, clip_sha256: digest, corrections, notes = {}, saved: inFile } = JSON.parse(text);
      const sound = corrections.every((k) => Object.hasOwn(words, k.kind) && Number.isFinite(k.frame)
        && (k.action === "missed" || (k.action === "wrong"
          && collisions.some((c) => c.number === k.number && c.kind === k.kind
            && Math.abs(c.frame - k.frame) <= data.same_frames))));
      const written = Object.values(notes).every((note) => typeof note === "string");
      const another = clip !== data.clip || (digest && data.clip_sha256 && digest !== data.clip_sha256);
      if (another || !sound || !written) return null;
      return [{ notes, corrections: corrections.map(correction) }, inFile];
    } catch {
      return null;
    }
  }

  function recall() {
    let kept = null;
    try {
      kept = readReview(localStorage.getItem(shelf));
    } catch {
      // a browser that keeps nothing
    }
    if (kept === null || asText(kept[0]) === saved) return;
    before.push(review);
    [review] = kept;
    saved = String(kept[1]);
  }

  function save() {
    if (element("save").disabled) return;
    const stored = { corrections_version: 1, clip: data.clip,
      clip_sha256: data.clip_sha256, tool_count: data.result.count,
      reviewed_count: reviewedCount(), corrections: review.corrections, notes: review.notes };
    const blob = new Blob([`${JSON.stringify(stored, null, 1)}\n`], { type: "application/json" });
    const address = URL.createObjectURL(blob);
    make("a", { href: address, download: data.save_as }).click();
    setTimeout(() => URL.revokeObjectURL(address), 60000);
    saved = asText(review);
    remember();
    drawState();
  }

  async function load() {
    const [file] = element("load").files;
    if (file === undefined) return;
    const found = readReview(await file.text());
    if (found !== null) {
      change(found[0]);
      saved = asText(review);
    }
    drawState(found === null ? `${file.name} holds no corrections of this clip` : undefined);
    element("load").value = "";
  }

  // ---- doing ------------------------------------------------------------------------------
  function choose(c) {
    chosen = c;
    draw();
    drawContact(c);
    show(nearest(data.frames, c.frame));
    element("list").querySelector('[aria-current="true"]')?.scrollIntoView({ block: "nearest" });
    element("contact").scrollIntoView({ block: "nearest" });
  }

  function step(by) {
    const all = entries();
    const at = all.findIndex((c) => key(c) === key(chosen));
    const next = at < 0 ? (by > 0 ? 0 : all.length - 1) : at + by;
    if (all[next] === undefined) return;
    choose(all[next]);
    if (element("list").contains(document.activeElement)) focusOn(key(all[next]));
  }

  function change(next) {
    before.push(review);
    review = { ...review, ...next };
    draw();
  }

  // A correction that is there already is taken back.
  function toggle(action, { kind, frame, number }) {
    const { corrections } = review;
    const rest = corrections.filter((k) => k.action !== action || k.kind !== kind
      || (number === null ? k.frame !== frame : k.number !== number));
    const added = rest.length < corrections.length ? [] : [{ action, kind, frame, number }];
    const notes = { ...review.notes };
    if (action === "missed" && !added.length) {  // one that was added goes away, with its note
      const gone = key({ kind, frame, number });
      delete notes[gone];
      if (key(chosen) === gone) chosen = null;
    }
    change({ corrections: [...rest, ...added], notes });
  }

  function markWrong() {
    const c = chosen;
    if (c === null) return;
    toggle(c.number === null ? "missed" : "wrong", c);
  }

  const addMissed = (kind) => toggle("missed", { kind, frame: data.frames[row()], number: null });

  // Every letter is kept at once; undo takes back what was typed from one visit to the next.
  function writeNote() {
    const notes = { ...review.notes, [key(chosen)]: element("note").value };
    if (notes[key(chosen)] === "") delete notes[key(chosen)];
    review = { ...review, notes };
    draw();
  }

  function leaveNote() {
    if (before.length && asText(before[before.length - 1]) === asText(review)) before.pop();
    draw();
  }

  function undo() {
    if (before.length === 0) return;
    review = before.pop();
    if (chosen !== null && !entries().some((c) => key(c) === key(chosen))) chosen = null;
    draw();
    remember();
  }

  function goThere(event) {
    const box = element("picture").getBoundingClientRect();
    const x = (event.clientX - box.left) / box.width;
    const y = (event.clientY - box.top) / box.height;
    const panel = data.panels.find(({ box: [left, top, right, bottom] }) => (
      left <= x && x <= right && top <= y && y <= bottom));
    if (panel === undefined) return;
    const [from, to] = panel.frames;
    const frame = from + (to - from) * (x - panel.box[0]) / (panel.box[2] - panel.box[0]);
    const all = entries();
    if (all.length) choose(all[nearest(all.map((c) => c.frame), frame)]);
  }

  // ---- hands and keys ---------------------------------------------------------------------
  const keys = {
    arrowdown: () => step(1), arrowright: () => step(1),
    arrowup: () => step(-1), arrowleft: () => step(-1),
    ".": () => show(row() + 1), ",": () => show(row() - 1),
    x: markWrong, b: () => addMissed("bodies"), w: () => addMissed("wall"), u: undo, s: save,
    " ": playOrStop,
  };
  document.addEventListener("keydown", (event) => {
    const act = keys[event.key.toLowerCase()];
    const { target } = event;
    if (!act || event.ctrlKey || event.metaKey || event.altKey || target.tagName === "TEXTAREA") return;
    // The slider and the picture have arrow keys of their own, and space presses a focused button.
    const arrow = event.key.startsWith("Arrow");
    if (arrow && (target.type === "range" || target.id === "sheet")) return;
    if (arrow && target.tagName === "PRE") return;
    if (event.key === " " && (target.tagName === "BUTTON"
      || ["file", "checkbox"].includes(target.type))) return;
    event.preventDefault();
    act();
  });
  for (const button of document.querySelectorAll("[data-act]")) {
    button.addEventListener("click", () => keys[button.dataset.act]());
  }
  video.addEventListener("click", playOrStop);
  element("seek").max = data.frames.length - 1;
  element("seek").addEventListener("input", () => show(Number(element("seek").value)));
  element("note").addEventListener("focus", () => before.push(review));
  element("note").addEventListener("input", writeNote);
  element("note").addEventListener("blur", leaveNote);
  element("load").addEventListener("change", load);
  element("picture")?.addEventListener("click", goThere);
  for (const event of ["timeupdate", "seeked", "loadeddata", "play", "pause"]) video.addEventListener(event, showFrame);
  window.addEventListener("beforeunload", (event) => { if (asText(review) !== saved) event.preventDefault(); });
  if (msAFrame !== null) element("unit").textContent = "frame · time";
  recall();
  draw();
  if (collisions.length) choose(collisions[0]);  // before it, there is little to judge
})();
