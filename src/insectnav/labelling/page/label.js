// The page: tools, keys and pointer, the picture with its layers, and talk with the program.
import { ERASE, GROUND, Layer, Painting, ring, SKY } from "./painting.js";
import { ask, packed, unpacked } from "./talk.js";

const at = id => document.getElementById(id);
const canvas = at("canvas"), context = canvas.getContext("2d"), stage = at("stage");
const BRUSHES = { sky: SKY, ground: GROUND, erase: ERASE };
const VIEWS = ["tint", "mask", "plain"];
const STROKE = [[0, 0, 0, 0], [213, 94, 0, 255], [0, 114, 178, 255]];
const TINT = [[255, 255, 255, 0], [230, 159, 0, 64], [86, 180, 233, 120]];
const MASK = [[128, 128, 128, 255], [0, 0, 0, 255], [255, 255, 255, 255]];
const GROWING = "Growing the strokes; the very first time on a machine takes some seconds more";
const SMALLEST = 1, LARGEST = 400; // [pixel of the picture] diameter of the brush
const DEEPEST = 32; // zoom

let brush = "sky", view = "tint";
let pictures = [], current = -1, open = null; // open: the picture with its painting and layers
let zoom = 1, left = 0, top_ = 0; // [CSS pixel] of the stage, where the picture's corner is
let pointer = null, stroke = null, drag = null, spaceDown = false;
let growing = false, growAgain = false, drawAsked = false, ended = false;

// Strokes go to the program, masks come back.

function say(words, isError = false) {
  at("status").textContent = words;
  at("status").className = isError ? "error" : "";
}

async function trying(action) {
  try {
    return await action();
  } catch (error) {
    say(error.message, true);
    return false;
  }
}

// Grow the strokes; while one answer is awaited, only the latest state waits behind it.
async function grow() {
  if (growing) {
    growAgain = true;
    return;
  }
  growing = true;
  let before = null; // what the words took the place of
  const slow = setTimeout(() => {
    before = [at("status").textContent, at("status").className === "error"];
    say(GROWING);
  }, 1500);
  do {
    growAgain = false;
    if (open) await trying(() => growOnce(open));
  } while (growAgain);
  growing = false;
  clearTimeout(slow);
  if (before && at("status").textContent === GROWING) say(...before);
}

async function growOnce(picture) {
  if (picture.painting.isEmpty()) {
    picture.labels = null;
    picture.tint.clear();
    picture.mask.clear();
    showShares();
    return redraw();
  }
  const answer = await ask(`grow/${picture.number}`, { method: "POST", body: await packed(picture.painting.labels) });
  const labels = await unpacked(await answer.arrayBuffer());
  if (picture !== open) return;
  if (picture.painting.isEmpty()) growAgain = true;
  picture.labels = labels;
  picture.tint.show(labels);
  picture.mask.show(labels);
  showShares();
  redraw();
}

async function save() {
  const picture = open;
  if (picture.painting.isEmpty()) {
    say("Nothing is painted yet, so there is no mask to save", true);
    return false;
  }
  return trying(async () => {
    const state = picture.painting.done.at(-1);
    const answer = await ask(`save/${picture.number}`, { method: "POST", body: await packed(picture.painting.labels) });
    const { mask, unreached } = await answer.json();
    if (picture.painting.done.at(-1) === state) picture.dirty = false;
    pictures[picture.number].labelled = true;
    showList();
    say(`Saved ${mask}` + (unreached ? `; ${unreached} pixels that no stroke reaches are 128 in it` : ""));
    return true;
  });
}

async function go(number) {
  if (number < 0 || number >= pictures.length || stroke) return;
  if (open?.dirty && !open.painting.isEmpty() && !(await save())) return;
  say(`Opening ${pictures[number].name}`);
  current = number;
  open = null;
  showList();
  await trying(async () => {
    const bitmap = await createImageBitmap(await (await ask(`picture/${number}`)).blob());
    const saved = await savedStrokes(number);
    if (current !== number) return;
    const { width, height } = bitmap, layer = colours => new Layer(width, height, colours);
    open = { number, bitmap, painting: new Painting(width, height, saved.labels), strokes: layer(STROKE),
             tint: layer(TINT), mask: layer(MASK), labels: null, dirty: false };
    fit();
    showShares();
    say(saved.words, saved.isError);
    if (!saved.labels) return;
    open.strokes.show(saved.labels);
    await grow();
    showButtons();
  });
}

// Strokes saved earlier, if any, and what to say of them; a picture without them is no less to be painted on.
async function savedStrokes(number) {
  try {
    const answer = await ask(`strokes/${number}`);
    if (answer.status === 204) return { words: "Paint some sky and some ground; the right button paints the other one" };
    return { labels: await unpacked(await answer.arrayBuffer()), words: "These strokes were saved earlier" };
  } catch (error) {
    return { words: error.message, isError: true };
  }
}

async function finish() {
  if (open?.dirty && !open.painting.isEmpty() && !(await save())) return;
  await trying(async () => {
    await ask("finish", { method: "POST" });
    const n = pictures.filter(picture => picture.labelled).length;
    end(pictures.length === 1 ? "Done. You can close this page." : `Done: ${n} of ${pictures.length} pictures have a mask. You can close this page.`);
  });
}

function end(words) {
  ended = true;
  if (open) open.dirty = false;
  at("end-words").textContent = words;
  at("end").hidden = false;
}

// What is shown.

function redraw() {
  if (drawAsked) return;
  drawAsked = true;
  requestAnimationFrame(() => {
    drawAsked = false;
    draw();
  });
}

function draw() {
  const ratio = devicePixelRatio, width = Math.round(stage.clientWidth * ratio), height = Math.round(stage.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.clearRect(0, 0, width, height);
  if (!open) return;
  context.setTransform(zoom * ratio, 0, 0, zoom * ratio, left * ratio, top_ * ratio);
  context.imageSmoothingEnabled = zoom * ratio < 3;
  if (view === "mask" && open.labels) {
    context.drawImage(open.mask.canvas, 0, 0);
  } else {
    context.drawImage(open.bitmap, 0, 0);
    if (view === "tint" && open.labels) context.drawImage(open.tint.canvas, 0, 0);
    context.globalAlpha = 0.85;
    context.drawImage(open.strokes.canvas, 0, 0);
    context.globalAlpha = 1;
  }
  drawBrush(ratio);
}

function drawBrush(ratio) {
  if (!pointer || drag || spaceDown) return;
  const label = stroke ? stroke.label : BRUSHES[brush];
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  ring(context, pointer, Math.max(2, zoom * size() / 2), ["#fff", "#ffc04d", "#8fd0ff"][label]);
}

function showList() {
  if (at("list").children.length !== pictures.length) {
    at("list").replaceChildren(...pictures.map(({ name }, number) => {
      const item = document.createElement("li"), button = document.createElement("button"), words = document.createElement("span");
      words.textContent = button.title = name;
      button.append(words);
      button.onclick = () => go(number);
      item.append(button);
      return item;
    }));
  }
  pictures.forEach((picture, number) => {
    const item = at("list").children[number], isCurrent = number === current;
    item.className = isCurrent && open?.dirty ? "unsaved" : picture.labelled ? "labelled" : "";
    if (isCurrent && item.getAttribute("aria-current") !== "true") item.scrollIntoView({ block: "nearest" });
    item.setAttribute("aria-current", isCurrent);
  });
  at("progress").textContent = `${pictures.filter(picture => picture.labelled).length} of ${pictures.length} have a mask`;
  document.title = current >= 0 ? `${pictures[current].name} – insectnav label` : "insectnav label";
  showButtons();
}

function showShares() {
  const counts = [0, 0, 0];
  if (open?.labels) for (const label of open.labels) counts[label]++;
  const share = label => `${(100 * counts[label] / open.labels.length).toFixed(1)} %`;
  at("shares").textContent = open?.labels
    ? `sky ${share(SKY)} · ground ${share(GROUND)}` + (counts[0] ? ` · not reached ${counts[0]} pixels` : "") : "";
}

function showButtons() {
  for (const name in BRUSHES) at(name).setAttribute("aria-checked", name === brush);
  for (const name of VIEWS) at(name).setAttribute("aria-checked", name === view);
  at("undo").disabled = !open?.painting.done.length;
  at("redo").disabled = !open?.painting.undone.length;
  at("save").disabled = !open;
  at("previous").disabled = current <= 0;
  at("next").disabled = current >= pictures.length - 1;
  at("size-shown").textContent = `${size()} px`;
  at("zoom").textContent = open ? `${Math.round(100 * zoom)} %` : "";
}

// Tools.

function size() {
  return Math.round(SMALLEST * (LARGEST / SMALLEST) ** (at("size").value / 100));
}

function choose(name) {
  if (name in BRUSHES) brush = name;
  else view = name;
  showButtons();
  redraw();
}

function changed(box) {
  if (!box) return;
  open.strokes.show(open.painting.labels, box);
  if (open.dirty) {
    showButtons();
  } else {
    open.dirty = true;
    showList();
  }
  redraw();
  grow();
}

function resize(step) {
  const before = size();
  do at("size").valueAsNumber += step;
  while (size() === before && at("size").value > 0 && at("size").value < 100);
  showButtons();
  redraw();
}

function fit() {
  const { width, height } = open.bitmap, margin = 16;
  zoom = Math.min((stage.clientWidth - margin) / width, (stage.clientHeight - margin) / height, 4);
  left = (stage.clientWidth - zoom * width) / 2;
  top_ = (stage.clientHeight - zoom * height) / 2;
  showButtons();
  redraw();
}

function zoomBy(factor, [x, y] = [stage.clientWidth / 2, stage.clientHeight / 2]) {
  if (!open) return;
  const next = Math.min(DEEPEST, Math.max(0.02, zoom * factor));
  left = x - (x - left) * next / zoom;
  top_ = y - (y - top_) * next / zoom;
  zoom = next;
  showButtons();
  redraw();
}

// The pointer.

const place = event => [event.offsetX, event.offsetY];
const onPicture = ([x, y]) => [(x - left) / zoom, (y - top_) / zoom];

canvas.addEventListener("pointerdown", event => {
  if (!open || stroke || drag) return;
  event.preventDefault();
  canvas.focus();
  canvas.setPointerCapture(event.pointerId);
  pointer = place(event);
  if (event.button === 1 || spaceDown) {
    drag = pointer;
  } else if (event.button === 0 || event.button === 2) {
    const label = BRUSHES[brush];
    stroke = { label: event.button === 2 && label !== ERASE ? SKY + GROUND - label : label, from: onPicture(pointer) };
    open.painting.begin();
    paintTo(stroke.from);
  }
});

canvas.addEventListener("pointermove", event => {
  const events = stroke ? event.getCoalescedEvents?.() ?? [] : [];
  if (stroke) for (const part of events.length ? events : [event]) paintTo(onPicture(place(part)));
  const next = place(event);
  if (drag) {
    left += next[0] - drag[0];
    top_ += next[1] - drag[1];
    drag = next;
  }
  pointer = next;
  redraw();
});

function paintTo(point) {
  const box = open.painting.line(stroke.from, point, size() / 2, stroke.label);
  stroke.from = point;
  changed(box);
}

function lift() {
  if (stroke) open.painting.finish();
  stroke = drag = null;
  showButtons();
  redraw();
}

canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("pointerleave", () => {
  pointer = null;
  redraw();
});
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  if (event.shiftKey) resize(Math.sign(event.deltaY || event.deltaX) * -3);
  else zoomBy(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), place(event));
}, { passive: false });

// Buttons and keys.

for (const name in BRUSHES) at(name).onclick = () => choose(name);
for (const name of VIEWS) at(name).onclick = () => choose(name);
at("size").oninput = () => (showButtons(), redraw());
at("undo").onclick = () => open && !stroke && changed(open.painting.undo());
at("redo").onclick = () => open && !stroke && changed(open.painting.redo());
at("smaller").onclick = () => zoomBy(1 / 1.25);
at("larger").onclick = () => zoomBy(1.25);
at("fit").onclick = () => open && fit();
at("help").onclick = () => at("keys").showModal();
at("save").onclick = save;
at("finish").onclick = finish;
at("previous").onclick = () => go(current - 1);
at("next").onclick = () => go(current + 1);

const KEYS = {
  s: () => choose("sky"), g: () => choose("ground"), e: () => choose("erase"),
  m: () => choose(VIEWS[(VIEWS.indexOf(view) + 1) % VIEWS.length]),
  "[": () => resize(-3), "]": () => resize(3), "+": () => zoomBy(1.25), "=": () => zoomBy(1.25), "-": () => zoomBy(1 / 1.25),
  0: () => at("fit").click(), n: () => go(current + 1), p: () => go(current - 1), "?": () => at("help").click(),
};

addEventListener("keydown", event => {
  if (at("keys").open || ended) return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    const action = { z: event.shiftKey ? "redo" : "undo", y: "redo", s: "save" }[key];
    if (!action) return;
    event.preventDefault();
    at(action).click();
  } else if (key === " ") {
    if (event.target.tagName === "BUTTON" && event.target !== document.body) event.target.blur();
    event.preventDefault();
    spaceDown = true;
    canvas.classList.add("moves");
    redraw();
  } else if (KEYS[key] && !event.altKey) {
    KEYS[key]();
  }
});
addEventListener("keyup", event => {
  if (event.key !== " ") return;
  spaceDown = false;
  canvas.classList.remove("moves");
  redraw();
});
addEventListener("beforeunload", event => {
  if (open?.dirty && !open.painting.isEmpty()) event.preventDefault();
});
new ResizeObserver(redraw).observe(stage);

// The stream tells this page that the program lives, and the program that this page is open.
const alive = new EventSource("alive");
alive.onerror = () => {
  if (ended) return alive.close();
  setTimeout(() => {
    if (!ended && alive.readyState !== EventSource.OPEN) say("The program was ended; what was not saved is only on this page", true);
  }, 2000);
};

await trying(async () => {
  pictures = (await (await ask("desk")).json()).pictures;
  document.body.classList.toggle("single", pictures.length === 1);
  const first = pictures.findIndex(picture => !picture.labelled);
  await go(Math.max(0, first));
});
