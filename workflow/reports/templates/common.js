"use strict";
// The page's data, colours, number format and gestures; network.js and chart.js draw, report.js starts everything.
const data = JSON.parse(document.getElementById("data").textContent);
const TYPES = { f4: Float32Array, u4: Uint32Array, u1: Uint8Array };

function decode({ type, base64 }) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return new TYPES[type](bytes.buffer);
}

// Five digits; float32 holds seven.
function show(value, digits = 5) {
  if (!Number.isFinite(value)) return "undefined";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e5 || size < 1e-3)) return value.toExponential(digits - 1).replace(/\.?0+e/, "e");
  return String(Number(value.toPrecision(digits)));
}

// An element with attributes and children; text only ever becomes text.
function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

const probe = document.body.appendChild(element("span", { hidden: "" }));
let palette = {};
function readPalette() {
  const names = ["ink", "paper", "muted", "line", "compressive", "tensile", "distant", "extra", "idle", "disc", "grey", "edge", "link"];
  palette = {};
  for (const name of names) {
    probe.style.color = `var(--${name})`;
    palette[name] = getComputedStyle(probe).color;
  }
}

// Everything that is drawn on a canvas; `printing` draws sharper.
const views = [];
let printing = false;
function redraw() {
  readPalette();
  for (const view of views) view.draw();
}

// The canvas's context, scaled so that a unit is a CSS pixel; null while it is hidden.
function context(canvas, height) {
  const width = canvas.clientWidth, scale = printing ? 3 : window.devicePixelRatio || 1;
  if (!width) return null;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const ctx = canvas.getContext("2d");
  ctx.setTransform(scale, 0, 0, scale, 0, 0);
  return ctx;
}

// One drawing per frame of the screen, however many events ask for it.
function later(draw) {
  let asked = false;
  return () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; draw(); });
  };
}

// Mouse, touch and keyboard of a canvas.  The view has: zoomed, zoom(factor, x, y), drag(dx, dy, x, y, touch), hover(x, y),
// leave(), tap(x, y), release(), step(dx, dy), reset().
function gestures(canvas, view) {
  const down = new Map();
  let moved = 0;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  // one finger scrolls the page until the view is zoomed
  const settle = () => { canvas.style.touchAction = view.zoomed ? "none" : "pan-y"; };
  const spread = () => {
    const [[ax, ay], [bx, by]] = [...down.values()];
    return { x: (ax + bx) / 2, y: (ay + by) / 2, apart: Math.hypot(ax - bx, ay - by) || 1 };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, at(event));
    moved = down.size > 1 ? Infinity : 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const [x, y] = at(event);
    if (!down.has(event.pointerId)) return view.hover(x, y);
    const [oldX, oldY] = down.get(event.pointerId), before = down.size === 2 ? spread() : null;
    down.set(event.pointerId, [x, y]);
    moved += Math.abs(x - oldX) + Math.abs(y - oldY);
    if (before) {
      const after = spread();
      view.zoom(after.apart / before.apart, after.x, after.y);
      view.pan(after.x - before.x, after.y - before.y);
    } else if (moved > 4) view.drag(x - oldX, y - oldY, x, y, event.pointerType === "touch");
    settle();
  });
  const up = (event) => {
    if (!down.delete(event.pointerId)) return;
    if (event.type === "pointerup" && moved <= 4) view.tap(...at(event));
    if (!down.size) view.release();
    settle();
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener("pointerleave", () => view.leave());
  canvas.addEventListener("dblclick", () => { view.reset(); settle(); });
  canvas.addEventListener("wheel", (event) => {
    // the wheel scrolls the page unless the canvas was clicked; a trackpad's pinch comes with ctrlKey
    if (!event.ctrlKey && !event.metaKey && document.activeElement !== canvas) return;
    event.preventDefault();
    view.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.002)), ...at(event));
    settle();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    const keys = {
      "+": () => view.zoom(1.5, ...middle), "=": () => view.zoom(1.5, ...middle), "-": () => view.zoom(1 / 1.5, ...middle),
      "0": () => view.reset(), Home: () => view.reset(), Escape: () => view.leave(true),
      ArrowLeft: () => view.step(-1, 0), ArrowRight: () => view.step(1, 0),
      ArrowUp: () => view.step(0, 1), ArrowDown: () => view.step(0, -1),
    };
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    event.preventDefault();
    keys[event.key]();
    settle();
  });
  settle();
}
