"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const element = (id) => document.getElementById(id);
  const video = element("video");
  const words = { bodies: "between the bodies", wall: "with the wall" };
  let corrections = data.corrections;
  const before = [];
  let chosen = null;

  // A blob can be sought in on every browser; a data address cannot on some phones.
  const bytes = Uint8Array.from(atob(video.src.split(",")[1]), (sign) => sign.charCodeAt(0));
  video.src = URL.createObjectURL(new Blob([bytes], { type: "video/mp4" }));

  // The browser's own controls would cover the strip; without this script they are there.
  video.controls = false;

  // ---- frames and times -------------------------------------------------------------------
  function rowAt(time) {
    let low = 0;
    let high = data.times.length - 1;
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (data.times[middle] <= time) low = middle; else high = middle - 1;
    }
    return low;
  }

  function rowOf(frame) {
    let best = 0;
    data.frames.forEach((value, row) => {
      if (Math.abs(value - frame) < Math.abs(data.frames[best] - frame)) best = row;
    });
    return best;
  }

  function show(row) {
    const inside = Math.min(Math.max(row, 0), data.times.length - 1);
    const next = inside + 1 < data.times.length ? data.times[inside + 1] : data.times[inside] + 0.03;
    video.pause();
    video.currentTime = (data.times[inside] + next) / 2;  // well inside: rounding cannot miss it
  }

  const row = () => rowAt(video.currentTime);

  function tellFrame() {
    element("frame").textContent = data.frames[row()];
    element("seek").value = row();
    element("play").textContent = video.paused ? "Play" : "Stop";
    element("play").setAttribute("aria-pressed", String(!video.paused));
  }

  const playOrStop = () => (video.paused ? video.play() : video.pause());

  // ---- what is there, with the corrections laid over it -----------------------------------
  const isWrong = (c) => corrections.some((k) => k.action === "wrong" && k.number === c.number);

  function entries() {
    const missed = corrections.filter((k) => k.action === "missed")
      .map((k) => ({ ...k, number: null, seen: true, in_burst: k.frame < data.burst_ends }));
    return [...data.collisions, ...missed].sort((a, b) => a.frame - b.frame);
  }

  function reviewedCount() {
    return entries().filter((c) => c.in_burst && !(c.number !== null && isWrong(c))).length;
  }

  const key = (c) => (c === null ? null : `${c.number ?? "+"}/${c.kind}/${c.frame}`);

  // ---- drawing ----------------------------------------------------------------------------
  function make(tag, attributes, ...children) {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.append(...children);
    return made;
  }

  function notes(c) {
    const told = [];
    if (c.number === null) told.push("added");
    else if (isWrong(c)) told.push("marked wrong");
    if (!c.seen) told.push("inferred");
    if (!c.in_burst) told.push("after the burst");
    return told.join(", ");
  }

  function listItem(c) {
    const removed = c.number !== null && isWrong(c);
    const button = make("button", { type: "button", "data-key": key(c) },
      make("span", {}, c.number === null ? "+" : String(c.number)),
      make("span", { class: `mark ${c.kind}${c.seen ? "" : " inferred"}`, "aria-hidden": "true" }),
      make("span", { class: removed ? "removed" : "" }, words[c.kind], " ",
        make("span", { class: "note" }, notes(c))),
      make("span", {}, c.number === null ? String(c.frame) : c.frame.toFixed(1)));
    button.setAttribute("aria-current", key(c) === key(chosen) ? "true" : "false");
    button.addEventListener("click", () => choose(c));
    return make("li", {}, button);
  }

  function draw() {
    const focused = document.activeElement?.dataset?.key;
    element("list").replaceChildren(...entries().map(listItem));
    if (focused !== undefined) focusOn(focused);
    element("undo").disabled = before.length === 0;
    element("save").disabled = corrections.length === 0;
    element("wrong").disabled = chosen === null;
    const wrong = corrections.filter((k) => k.action === "wrong").length;
    const changes = `${wrong} marked wrong, ${corrections.length - wrong} added`;
    element("reviewed").textContent =
      corrections.length ? `Reviewed count: ${reviewedCount()} (${changes})` : "";
  }

  function focusOn(wanted) {
    for (const button of element("list").querySelectorAll("button")) {
      if (button.dataset.key === wanted) button.focus({ preventScroll: true });
    }
  }

  function drawContact(c) {
    const name = c.number === null ? "Added collision" : `Collision ${c.number}`;
    element("contact-title").textContent = `${name} ${words[c.kind]}, frame ${c.frame.toFixed(1)}`;
    const cuts = (c.cuts ?? []).map((cut) => make("figure", {},
      make("img", { src: cut.picture, alt: `frame ${cut.frame}, enlarged at the contact` }),
      make("figcaption", {}, `frame ${cut.frame}`)));
    element("cuts").replaceChildren(...cuts);
  }

  // ---- doing ------------------------------------------------------------------------------
  function choose(c) {
    chosen = c;
    draw();
    drawContact(c);
    show(rowOf(c.frame));
    const current = element("list").querySelector('[aria-current="true"]');
    current?.scrollIntoView({ block: "nearest" });
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
    before.push(corrections);
    corrections = next;
    draw();
  }

  function markWrong() {
    if (chosen === null) return;
    const c = chosen;
    if (c.number === null) {  // one that was added goes away again
      chosen = null;
      change(corrections.filter((k) => !(k.action === "missed" && key({ ...k, number: null }) === key(c))));
    } else if (isWrong(c)) {
      change(corrections.filter((k) => k.number !== c.number));
    } else {
      change([...corrections, { action: "wrong", kind: c.kind, frame: c.frame, number: c.number }]);
    }
  }

  function addMissed(kind) {
    const frame = data.frames[row()];
    if (corrections.some((k) => k.action === "missed" && k.kind === kind && k.frame === frame)) return;
    change([...corrections, { action: "missed", kind, frame, number: null }]);
  }

  function undo() {
    if (before.length === 0) return;
    corrections = before.pop();
    if (chosen !== null && !entries().some((c) => key(c) === key(chosen))) chosen = null;
    draw();
  }

  function save() {
    if (corrections.length === 0) return;
    const stored = { corrections_version: 1, clip: data.clip,
      clip_sha256: data.clip_sha256, tool_count: data.count,
      reviewed_count: reviewedCount(), corrections };
    const blob = new Blob([`${JSON.stringify(stored, null, 1)}\n`], { type: "application/json" });
    const address = URL.createObjectURL(blob);
    make("a", { href: address, download: data.save_as }).click();
    setTimeout(() => URL.revokeObjectURL(address), 60000);
  }

  // ---- hands and keys ---------------------------------------------------------------------
  const keys = {
    ArrowDown: () => step(1), ArrowRight: () => step(1),
    ArrowUp: () => step(-1), ArrowLeft: () => step(-1),
    ".": () => show(row() + 1), ",": () => show(row() - 1),
    x: markWrong, b: () => addMissed("bodies"), w: () => addMissed("wall"), u: undo, s: save,
    " ": playOrStop,
  };
  document.addEventListener("keydown", (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    // The slider has arrow keys of its own, and space presses the button that has the focus.
    if (event.target.type === "range" && event.key.startsWith("Arrow")) return;
    if (event.target.tagName === "BUTTON" && event.key === " ") return;
    event.preventDefault();
    act();
  });
  element("play").addEventListener("click", playOrStop);
  video.addEventListener("click", playOrStop);
  element("seek").max = data.frames.length - 1;
  element("seek").addEventListener("input", () => show(Number(element("seek").value)));
  element("back").addEventListener("click", () => show(row() - 1));
  element("forth").addEventListener("click", () => show(row() + 1));
  element("wrong").addEventListener("click", markWrong);
  element("add-bodies").addEventListener("click", () => addMissed("bodies"));
  element("add-wall").addEventListener("click", () => addMissed("wall"));
  element("undo").addEventListener("click", undo);
  element("save").addEventListener("click", save);
  for (const event of ["timeupdate", "seeked", "loadeddata", "play", "pause"]) video.addEventListener(event, tellFrame);
  window.addEventListener("beforeunload", (event) => { if (before.length) event.preventDefault(); });
  draw();
})();
