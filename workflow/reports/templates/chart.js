"use strict";
// Line charts with linear or logarithmic axes.  Charts of one group share the horizontal axis, its zoom and the cursor.

const STROKES = ["tensile", "compressive", "extra", "distant", "idle"];
const DASHES = [[], [7, 3], [8, 3, 2, 3], [2, 3], [12, 3]];
// Twenty-five lines that differ in colour or dash.
const lookOf = (k) => ({ stroke: STROKES[k % 5], dash: DASHES[(k + Math.floor(k / 5)) % 5] });
const MARGIN = { left: 58, right: 12, top: 20, bottom: 36 };

class Group {
  constructor() {
    this.charts = [];
    this.range = null;
    this.cursor = null;
    this.log = false;
  }

  draw() { for (const chart of this.charts) chart.ask(); }

  set(range) { this.range = range; this.draw(); }

  point(cursor) { this.cursor = cursor; this.draw(); }
}

class Chart {
  // spec: title, xlabel, ylabel, logy, lines [{name, x, y}] (arrays), levels [{name, y}], stages [{name, x}]
  constructor(root, spec, group) {
    Object.assign(this, { root, spec, group, hidden: new Set(), selecting: null, logy: Boolean(spec.logy) });
    const log = element("input", { type: "checkbox", onchange: (event) => { this.logy = event.target.checked; this.ask(); } });
    log.checked = this.logy;
    this.canvas = element("canvas", { tabindex: "0", role: "img", "aria-label":
      `${spec.title} against ${spec.xlabel}. Arrow keys read values, plus and minus zoom, 0 shows everything.` });
    this.keys = element("div", { class: "lines" });
    root.replaceChildren(element("figcaption", {}, spec.title, element("label", { class: "screen" }, log, "log")), this.keys, this.canvas);
    this.values = spec.lines.map((line, k) => this.key(line.name, k));
    this.draw = this.draw.bind(this);
    this.ask = later(this.draw);
    group.charts.push(this);
    views.push(this);
    gestures(this.canvas, this);
    new ResizeObserver(this.ask).observe(this.canvas);
  }

  key(name, k) {
    const value = element("span", { class: "muted" }), { stroke, dash } = lookOf(k);
    const swatch = document.createElementNS("http://www.w3.org/2000/svg", "svg"), stripe = swatch.appendChild(
      document.createElementNS("http://www.w3.org/2000/svg", "path"));
    for (const [key, text] of Object.entries({ width: 28, height: 8, "aria-hidden": true })) swatch.setAttribute(key, text);
    stripe.setAttribute("d", "M0 4H28");
    stripe.style.cssText = `stroke: var(--${stroke}); stroke-width: 2; stroke-dasharray: ${dash.join(" ") || "none"}`;
    const button = element("button", { type: "button", "aria-pressed": "true", title: "show or hide", onclick: () => {
      const shown = this.hidden.delete(k) || !this.hidden.add(k);
      button.setAttribute("aria-pressed", String(shown));
      this.ask();
    } }, swatch, element("span", {}, name), value);
    this.keys.append(button);
    return value;
  }

  // ---- the axes
  get shown() { return this.spec.lines.map((line, k) => ({ ...line, k })).filter(({ k }) => !this.hidden.has(k)); }

  // Ends of x, which ascends; a logarithmic axis begins at the first positive value.
  get extent() {
    const ends = this.spec.lines.filter(({ x }) => x.length).map(({ x }) => {
      const first = this.group.log ? x.find((value) => value > 0) : x[0];
      return first === undefined ? [x[x.length - 1], x[x.length - 1]] : [first, x[x.length - 1]];
    });
    const low = Math.min(...ends.map(([a]) => a)), high = Math.max(...ends.map(([, b]) => b));
    return low < high ? [low, high] : Number.isFinite(low) ? [low - 0.5, high + 0.5] : [0, 1];
  }

  get range() { return this.group.range || this.group.charts.map((chart) => chart.extent).reduce(([a, b], [c, d]) => [Math.min(a, c), Math.max(b, d)]); }

  get zoomed() { return Boolean(this.group.range); }

  // Lowest and highest value that is seen, with a little room.
  heights([from, to]) {
    let low = Infinity, high = -Infinity;
    const see = (value) => {
      if (!Number.isFinite(value) || (this.logy && value <= 0)) return;
      low = Math.min(low, value);
      high = Math.max(high, value);
    };
    for (const { x, y } of this.shown) for (let k = 0; k < x.length; k++) if (x[k] >= from && x[k] <= to) see(y[k]);
    for (const { y } of this.spec.levels || []) see(y);
    if (!(low <= high)) return this.logy ? [0.1, 1] : [0, 1];
    if (this.logy) return low === high ? [low / 2, high * 2] : [low / 1.2, high * 1.2];
    const room = 0.05 * (high - low) || 0.05 * Math.abs(high) || 1;
    return [low - room, high + room];
  }

  axis(range, from, to, log) {
    const f = log ? Math.log10 : Number, [low, high] = range.map(f), scale = (to - from) / (high - low || 1);
    return {
      range, log, place: (value) => from + (f(value) - low) * scale,
      value: (place) => { const v = low + (place - from) / scale; return log ? 10 ** v : v; },
    };
  }

  ticks({ range: [low, high], log }, most) {
    const decades = log ? Math.log10(high / low) : 0, found = [];
    if (log && decades > 1) {
      const every = Math.ceil(decades / most), parts = decades > 3 ? [1] : [1, 2, 5];
      for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++) {
        if (e % every) continue;
        for (const m of parts) found.push({ value: m * 10 ** e, text: this.power(m, e) });
      }
    } else {
      const raw = (high - low) / most, ten = 10 ** Math.floor(Math.log10(raw || 1)), step = [1, 2, 5, 10].map((m) => m * ten).find((s) => s >= raw);
      for (let n = Math.ceil(low / step); n * step <= high; n++) found.push({ value: n * step, text: show(n * step, 6) });
    }
    return found.filter(({ value }) => value >= low && value <= high);
  }

  power(m, e) {
    if (e >= -2 && e <= 4) return show(m * 10 ** e, 3);
    const raised = String(e).replace(/./g, (c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]));
    return `${m === 1 ? "" : `${m}·`}10${raised}`;
  }

  // ---- gestures
  zoom(factor, x) {
    const [full, [low, high]] = [this.whole(), this.range], axis = this.across, at = axis.place(axis.value(x));
    const [from, to] = [low, high].map((v) => axis.value(at + (axis.place(v) - at) / factor));
    const next = [Math.max(from, full[0]), Math.min(to, full[1])];
    if (axis.place(next[1]) - axis.place(next[0]) < 1e-9) return;
    this.group.set(next[0] <= full[0] && next[1] >= full[1] ? null : next);
  }

  whole() {
    const range = this.group.range;
    this.group.range = null;
    const full = this.range;
    this.group.range = range;
    return full;
  }

  pan(dx) {
    if (!this.zoomed) return;
    const axis = this.across, full = this.whole(), ends = this.range.map((v) => axis.place(v));
    const room = [axis.place(full[0]) - ends[0], axis.place(full[1]) - ends[1]], by = Math.min(Math.max(-dx, room[0]), room[1]);
    this.group.set(ends.map((place) => axis.value(place + by)));
  }

  drag(dx, dy, x, y, touch) {
    if (touch) return this.pan(dx);
    this.selecting = [this.selecting ? this.selecting[0] : x - dx, x];
    this.ask();
  }

  release() {
    const chosen = this.selecting;
    this.selecting = null;
    if (chosen && Math.abs(chosen[1] - chosen[0]) > 5) {
      const [low, high] = this.range, inside = (v) => Math.min(Math.max(v, low), high);
      this.group.set(chosen.sort((a, b) => a - b).map((x) => inside(this.across.value(x))));
    }
    this.ask();
  }

  hover(x) { this.group.point(this.across ? this.across.value(x) : null); }

  tap(x) { this.hover(x); }

  leave() { this.group.point(null); }

  step(dx) {
    const { x } = this.shown[0] || this.spec.lines[0], [low, high] = this.range;
    const now = this.group.cursor === null ? (dx > 0 ? -1 : x.length) : this.nearest(x, this.group.cursor);
    let k = now + dx;
    while (k >= 0 && k < x.length && x[k] < low) k++;
    while (k >= 0 && k < x.length && x[k] > high) k--;
    if (k >= 0 && k < x.length) this.group.point(x[k]);
  }

  reset() { this.group.set(null); }

  // Row whose x (ascending) is nearest.
  nearest(x, value) {
    let low = 0, high = x.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (x[middle] <= value) low = middle; else high = middle;
    }
    return Math.abs(x[high] - value) < Math.abs(x[low] - value) ? high : low;
  }

  // ---- drawing
  draw() {
    const height = 210, ctx = context(this.canvas, height), width = this.canvas.clientWidth;
    if (!ctx) return;
    const range = this.range, right = width - MARGIN.right, bottom = height - MARGIN.bottom;
    this.across = this.axis(range, MARGIN.left, right, this.group.log && range[0] > 0);
    const up = this.axis(this.heights(range), bottom, MARGIN.top, this.logy);
    ctx.font = "12px system-ui, sans-serif";
    this.grid(ctx, up, width, height);
    ctx.save();
    ctx.beginPath();
    ctx.rect(MARGIN.left, MARGIN.top - 2, right - MARGIN.left, bottom - MARGIN.top + 4);
    ctx.clip();
    for (const { x, y, k } of this.shown) this.line(ctx, up, x, y, k, range);
    ctx.restore();
    this.stages(ctx, range, bottom);
    this.levels(ctx);
    this.read(ctx, up, bottom);
  }

  grid(ctx, up, width, height) {
    const right = width - MARGIN.right, bottom = height - MARGIN.bottom;
    const stroke = (colour, dash, ...ends) => {
      ctx.strokeStyle = colour;
      ctx.setLineDash(dash);
      ctx.beginPath();
      ctx.moveTo(ends[0], ends[1]);
      ctx.lineTo(ends[2], ends[3]);
      ctx.stroke();
      ctx.setLineDash([]);
    };
    ctx.fillStyle = palette.paper;
    ctx.fillRect(0, 0, width, height);
    ctx.fillStyle = palette.muted;
    ctx.lineWidth = 1;
    ctx.textAlign = "right";
    for (const { value, text } of this.ticks(up, 5)) {
      const y = up.place(value);
      stroke(palette.line, [], MARGIN.left, y, right, y);
      ctx.fillText(text, MARGIN.left - 6, y + 4);
    }
    ctx.textAlign = "center";
    let free = -Infinity;
    for (const { value, text } of this.ticks(this.across, Math.max(Math.floor((right - MARGIN.left) / 75), 2))) {
      const x = this.across.place(value), half = ctx.measureText(text).width / 2;
      stroke(palette.edge, [], x, bottom, x, bottom + 4);
      if (x - half < free) continue;
      ctx.fillText(text, Math.min(x, width - half - 1), bottom + 16);
      free = x + half + 6;
    }
    stroke(palette.edge, [], MARGIN.left, bottom, right, bottom);
    ctx.fillStyle = palette.ink;
    ctx.textAlign = "right";
    ctx.fillText(this.spec.xlabel, right, height - 4);
    ctx.textAlign = "left";
    if (this.spec.ylabel) ctx.fillText(this.spec.ylabel, 2, 11);
    this.notes = [];
    for (const { name, y } of this.spec.levels || []) {
      const at = up.place(y);
      if (!(at >= MARGIN.top - 1 && at <= bottom + 1)) continue;
      stroke(palette.ink, [4, 4], MARGIN.left, at, right, at);
      this.notes.push([name, right, at < MARGIN.top + 16 ? at + 14 : at - 4]);
    }
  }

  line(ctx, up, x, y, k, [from, to]) {
    let pen = false;
    ctx.beginPath();
    const first = Math.max(this.nearest(x, from) - 1, 0), last = Math.min(this.nearest(x, to) + 1, x.length - 1);
    for (let n = first; n <= last; n++) {
      const bad = !Number.isFinite(y[n]) || (this.logy && y[n] <= 0) || (this.across.log && x[n] <= 0);
      if (!bad) ctx[pen ? "lineTo" : "moveTo"](this.across.place(x[n]), up.place(y[n]));
      pen = !bad;
    }
    ctx.strokeStyle = palette[lookOf(k).stroke];
    ctx.lineWidth = 1.5;
    ctx.lineJoin = "round";
    ctx.setLineDash(lookOf(k).dash);
    ctx.stroke();
    ctx.setLineDash([]);
  }

  // Names of the levels, on a halo so that they can be read on top of the curves.
  levels(ctx) {
    ctx.textAlign = "right";
    ctx.lineWidth = 3;
    ctx.strokeStyle = palette.paper;
    ctx.fillStyle = palette.ink;
    for (const note of this.notes) {
      ctx.strokeText(...note);
      ctx.fillText(...note);
    }
    ctx.lineWidth = 1;
  }

  stages(ctx, [from, to], bottom) {
    const all = this.spec.stages || [];
    all.forEach(({ name, x }, k) => {
      const begin = Math.max(x, from), end = Math.min(all[k + 1]?.x ?? to, to);
      if (begin >= end) return;
      const [left, right] = [begin, end].map(this.across.place);
      if (x > from && k) {
        ctx.strokeStyle = palette.muted;
        ctx.setLineDash([2, 3]);
        ctx.beginPath();
        ctx.moveTo(left, MARGIN.top);
        ctx.lineTo(left, bottom);
        ctx.stroke();
        ctx.setLineDash([]);
      }
      const place = Math.max(left, ctx.measureText(this.spec.ylabel || "").width + 14);
      if (right - place < ctx.measureText(name).width + 4) return;
      ctx.fillStyle = palette.muted;
      ctx.textAlign = "center";
      ctx.fillText(name, (place + right) / 2, 11);
    });
  }

  // Values at the cursor, in the legend; the last ones without a cursor.
  read(ctx, up, bottom) {
    const { cursor } = this.group;
    if (this.selecting) {
      ctx.fillStyle = palette.link;
      ctx.globalAlpha = 0.18;
      ctx.fillRect(this.selecting[0], MARGIN.top, this.selecting[1] - this.selecting[0], bottom - MARGIN.top);
      ctx.globalAlpha = 1;
    }
    if (cursor !== null) {
      const at = this.across.place(cursor);
      ctx.strokeStyle = palette.muted;
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.moveTo(at, MARGIN.top);
      ctx.lineTo(at, bottom);
      ctx.stroke();
      ctx.fillStyle = palette.ink;
      ctx.textAlign = at > this.canvas.clientWidth / 2 ? "right" : "left";
      const stage = (this.spec.stages || []).findLast((one) => one.x <= cursor);
      ctx.fillText(show(cursor, 4) + (stage ? `, ${stage.name}` : ""), at + (ctx.textAlign === "left" ? 4 : -4), bottom - 4);
    }
    this.spec.lines.forEach(({ x, y }, k) => {
      const row = cursor === null ? x.length - 1 : this.nearest(x, cursor);
      this.values[k].textContent = row >= 0 && (this.spec.time || cursor !== null) ? show(y[row], 4) : "";
      const place = up.place(y[row]);
      if (cursor === null || this.hidden.has(k) || !Number.isFinite(place)) return;
      ctx.fillStyle = palette[lookOf(k).stroke];
      ctx.beginPath();
      ctx.arc(this.across.place(x[row]), place, 3.5, 0, 2 * Math.PI);
      ctx.fill();
    });
  }
}
