"use strict";
// The force network: discs, and a line per interaction whose width is the normal force.

const THIN = 0.6; // CSS pixels; below, a line is not seen
const KEY = 28; // CSS pixels below the picture for its scales
const FINE = 8; // classes of width per factor 2
const LOOKS = { compressive: "compressive", tensile: "tensile", distant: "distant", "no force": "idle" };

class Network {
  constructor(root, net) {
    this.root = root;
    this.net = net;
    this.canvas = root.querySelector("canvas");
    this.tip = root.querySelector(".tip");
    this.pinned = root.querySelector(".pinned");
    this.hidden = new Set();
    this.marks = false;
    this.widen = 1;
    this.least = 0;
    this.hovered = this.chosen = null;
    this.prepare();
    this.home();
    this.controls();
    this.picture = document.createElement("canvas");
    this.ask = later(() => this.draw());
    this.glance = later(() => this.look());
    gestures(this.canvas, this);
    new ResizeObserver(this.ask).observe(this.canvas);
    views.push(this);
  }

  // Discs and lines with the periodic images that reach into the cell, the lines in the order in which they are drawn.
  prepare() {
    this.a = this.net.decoded ??= Object.fromEntries(Object.entries(this.net.arrays).map(([name, array]) => [name, decode(array)]));
    const { x, y, d, i, j, bx, by, normal, kind } = this.a, [[x0, y0], [w, h]] = [this.net.origin, this.net.cell];
    const [px, py] = this.net.periodic;
    const shifts = (low, high, start, length, periodic) => {
      const found = [0];
      if (periodic && low < start) found.push(length);
      if (periodic && high > start + length) found.push(-length);
      return found;
    };
    this.discs = [];
    for (let k = 0; k < x.length; k++) {
      const r = d[k] / 2;
      for (const sx of shifts(x[k] - r, x[k] + r, x0, w, px)) {
        for (const sy of shifts(y[k] - r, y[k] + r, y0, h, py)) this.discs.push({ k, x: x[k] + sx, y: y[k] + sy, r });
      }
    }
    this.lines = [];
    this.of = Array.from(x, () => []);
    for (let k = 0; k < i.length; k++) {
      this.of[i[k]].push(k);
      this.of[j[k]].push(k);
      const ax = x[i[k]], ay = y[i[k]], ex = ax + bx[k], ey = ay + by[k];
      const size = Math.abs(normal[k]) / this.net.unit;
      const width = Math.round(FINE * Math.log2(Math.max(size, 1e-9)));
      for (const sx of shifts(Math.min(ax, ex), Math.max(ax, ex), x0, w, px)) {
        for (const sy of shifts(Math.min(ay, ey), Math.max(ay, ey), y0, h, py)) {
          this.lines.push({ k, size, width, kind: kind[k], ax: ax + sx, ay: ay + sy, bx: ex + sx, by: ey + sy });
        }
      }
    }
    this.lines.sort((a, b) => b.kind - a.kind || a.width - b.width);
    this.rowOf = new Map(Array.from(this.a.id, (id, k) => [id, k]));
    const lengths = Array.from(bx, (along, k) => Math.hypot(along, by[k])).sort((p, q) => p - q);
    this.usual = lengths[lengths.length >> 1] || 1;
  }

  // Another frame of the run: its arrays and cell, in a window that is as large for all frames.
  setFrame(part, window) {
    const grain = this.chosen?.grain === undefined ? null : this.a.id[this.chosen.grain];
    this.net = { ...this.net, decoded: undefined, ...part, window };
    this.prepare();
    part.decoded = this.a;
    this.hovered = null;
    this.tip.hidden = true;
    const row = this.rowOf.get(grain);
    this.choose(row === undefined ? null : { grain: row });
    if (!this.zoomed) this.home();
    for (const box of this.root.querySelectorAll("[data-kind]")) {
      const own = Number(box.dataset.kind);
      box.parentElement.querySelector("output").value = this.a.kind.reduce((sum, kind) => sum + (kind === own), 0);
    }
    const sliding = this.root.querySelector('[data-control="marks"]');
    if (sliding) sliding.parentElement.querySelector("output").value = this.a.flag.reduce((sum, flag) => sum + (flag & 1), 0);
    this.ask();
  }

  controls() {
    const find = (name) => this.root.querySelector(`[data-control="${name}"]`);
    for (const box of this.root.querySelectorAll("[data-kind]")) {
      box.addEventListener("change", () => {
        this.hidden[box.checked ? "delete" : "add"](Number(box.dataset.kind));
        this.ask();
      });
    }
    const slider = (name, set) => find(name).addEventListener("input", (event) => {
      event.target.parentElement.querySelector("output").value = set(Number(event.target.value));
      this.ask();
    });
    slider("widen", (value) => show((this.widen = 2 ** value), 2) + " ×");
    slider("least", (value) => {
      this.least = value <= -5 ? 0 : 10 ** value;
      return this.least ? `${show(this.least, 2)} ${this.net.symbol}` : "all";
    });
    find("marks")?.addEventListener("change", (event) => { this.marks = event.target.checked; this.ask(); });
    find("in").addEventListener("click", () => this.zoom(1.6, this.canvas.clientWidth / 2, this.height / 2));
    find("out").addEventListener("click", () => this.zoom(1 / 1.6, this.canvas.clientWidth / 2, this.height / 2));
    find("reset").addEventListener("click", () => this.reset());
    find("find").addEventListener("change", (event) => this.seek(Number(event.target.value)));
  }

  // ---- the view: middle [length] and pixels per length
  home() {
    const [left, bottom, right, top] = this.net.window;
    this.middle = [(left + right) / 2, (bottom + top) / 2];
    this.magnify = 1;
  }

  get dash() { return this.net.dashes.map(([on, off]) => (off ? [on * this.usual * this.scale, off * this.usual * this.scale] : [])); }

  get zoomed() { return this.magnify > 1.001; }

  get span() { return [this.net.window[2] - this.net.window[0], this.net.window[3] - this.net.window[1]]; }

  get height() {
    const [w, h] = this.span, width = this.canvas.clientWidth;
    return Math.round(Math.max(Math.min(width * h / w, 0.86 * window.innerHeight, 900), Math.min(width, 180)));
  }

  get scale() { return this.magnify * Math.min(this.canvas.clientWidth / this.span[0], this.height / this.span[1]); }

  screen(x, y) {
    const k = this.scale;
    return [(x - this.middle[0]) * k + this.canvas.clientWidth / 2, (this.middle[1] - y) * k + this.height / 2];
  }

  world(sx, sy) {
    const k = this.scale;
    return [this.middle[0] + (sx - this.canvas.clientWidth / 2) / k, this.middle[1] - (sy - this.height / 2) / k];
  }

  // The middle of the view, so that nothing beyond the window is seen where that is larger than the view.
  moveTo(x, y) {
    const [left, bottom, right, top] = this.net.window, k = 2 * this.scale;
    const inside = (v, low, high, half) => (high - low > 2 * half ? Math.min(Math.max(v, low + half), high - half) : (low + high) / 2);
    this.middle = [inside(x, left, right, this.canvas.clientWidth / k), inside(y, bottom, top, this.height / k)];
    this.ask();
  }

  zoom(factor, sx, sy) {
    const [x, y] = this.world(sx, sy);
    this.magnify = Math.min(Math.max(this.magnify * factor, 1), Math.max(...this.span) / 2);
    const [nowX, nowY] = this.world(sx, sy);
    this.moveTo(this.middle[0] + x - nowX, this.middle[1] + y - nowY);
  }

  pan(dx, dy) { this.moveTo(this.middle[0] - dx / this.scale, this.middle[1] + dy / this.scale); }

  drag(dx, dy) { this.point(null); this.pan(dx, dy); }

  step(dx, dy) { this.pan(-60 * dx, 60 * dy); }

  release() {}

  reset() { this.home(); this.ask(); }

  seek(id) {
    const row = this.rowOf.get(id);
    if (row === undefined) {
      this.pinned.replaceChildren(element("p", {}, `There is no grain ${id} in this frame.`));
      return;
    }
    this.magnify = Math.max(this.magnify, Math.max(...this.span) / 12);
    this.moveTo(this.a.x[row], this.a.y[row]);
    this.choose({ grain: row });
  }

  // ---- what is under the pointer: a grain near its centre, else the nearest line, else the grain
  visible(line) { return !this.hidden.has(line.kind) && line.size >= this.least; }

  width(line, k = this.scale) { return Math.max(2 ** (line.width / FINE) * this.net.band * this.widen * k, THIN); }

  under(sx, sy) {
    const [x, y] = this.world(sx, sy), k = this.scale;
    let inside = null;
    for (const disc of this.discs) {
      const apart = Math.hypot(disc.x - x, disc.y - y);
      if (apart < disc.r) { inside = disc; if (apart < 0.35 * disc.r) return { grain: disc.k }; }
    }
    let best = null, nearest = Infinity;
    for (const line of this.lines) {
      if (!this.visible(line)) continue;
      const ux = line.bx - line.ax, uy = line.by - line.ay;
      const part = Math.min(Math.max(((x - line.ax) * ux + (y - line.ay) * uy) / (ux * ux + uy * uy), 0), 1);
      const apart = k * Math.hypot(line.ax + part * ux - x, line.ay + part * uy - y) - this.width(line, k) / 2;
      if (apart < 5 && apart < nearest) { nearest = apart; best = { contact: line.k }; }
    }
    return best || (inside && { grain: inside.k });
  }

  hover(sx, sy) { this.point(sy < this.height ? this.under(sx, sy) : null, sx, sy); }

  leave(all) {
    this.point(null);
    if (all) this.choose(null);
  }

  tap(sx, sy) { this.choose(sy < this.height ? this.under(sx, sy) : null); }

  point(found, sx, sy) {
    this.tip.hidden = !found;
    this.canvas.style.cursor = found ? "pointer" : this.zoomed ? "grab" : "default";
    if (JSON.stringify(found) !== JSON.stringify(this.hovered)) {
      this.hovered = found;
      this.glance();
    }
    if (!found) return;
    const [title, ...rows] = this.words(found);
    this.tip.replaceChildren(element("b", {}, title), ...rows.map((row) => element("div", {}, row.join(" "))));
    const room = this.canvas.clientWidth - this.tip.offsetWidth - 4;
    this.tip.style.left = `${Math.max(Math.min(sx + 14, room), 0)}px`;
    this.tip.style.top = `${sy + 16 + this.tip.offsetHeight > this.height ? sy - this.tip.offsetHeight - 10 : sy + 16}px`;
  }

  // ---- words
  force(value) { return `${show(value / this.net.unit)} ${this.net.symbol}`; }

  words({ grain, contact }) {
    const { id, d, x, y, mark, i, j, normal, tangential, moment, gap, kind, flag } = this.a, { length } = this.net;
    if (grain !== undefined) {
      const rows = [["diameter", `${show(d[grain])} ${length}`], ["centre", `(${show(x[grain])}, ${show(y[grain])}) ${length}`],
        ["interactions", String(this.of[grain].length)]];
      return [`grain ${id[grain]}${mark[grain] ? `, ${this.net.marks[mark[grain]]}` : ""}`, ...rows];
    }
    const k = contact, state = [[1, "sliding"], [2, "rolling"]].filter(([bit]) => flag[k] & bit).map(([, word]) => `, ${word}`);
    return [`${id[i[k]]} – ${id[j[k]]}: ${this.net.kinds[kind[k]]}${state.join("")}`, ["normal force N =", this.force(normal[k])],
      ["tangential force T =", this.force(tangential[k])], ["gap h =", `${show(gap[k])} ${length}`],
      ...(this.net.rolling ? [["rolling moment =", `${show(moment[k] / this.net.unit)} ${this.net.symbol} ${length}`]] : [])];
  }

  choose(found) {
    this.chosen = found;
    this.glance();
    if (!found) return this.pinned.replaceChildren();
    const [title, ...rows] = this.words(found), parts = [element("h3", {}, title)];
    const row = ([name, value]) => element("tr", {}, element("th", { scope: "row" }, name.replace(/ =$/, "")), element("td", {}, value));
    parts.push(element("table", {}, element("tbody", {}, ...rows.map(row))));
    if (found.grain !== undefined) parts.push(this.neighbours(found.grain));
    else parts.push(element("p", {}, "of grains ", this.link(this.a.i[found.contact]), " and ", this.link(this.a.j[found.contact])));
    this.pinned.replaceChildren(...parts);
  }

  link(row) {
    const id = this.a.id[row];
    return element("button", { type: "button", "aria-label": `show grain ${id}`, onclick: () => this.seek(id) }, String(id));
  }

  neighbours(grain) {
    const { i, j, normal, tangential, kind } = this.a;
    const head = ["with", "N", "T", "kind"].map((name) => element("th", { scope: "col" }, name));
    const rows = this.of[grain].map((k) => element("tr", {},
      element("td", {}, this.link(i[k] === grain ? j[k] : i[k])), element("td", {}, show(normal[k] / this.net.unit, 4)),
      element("td", {}, show(tangential[k] / this.net.unit, 4)), element("td", {}, this.net.kinds[kind[k]])));
    return element("div", { class: "wide" }, element("table", {},
      element("caption", { class: "muted" }, `forces in ${this.net.symbol}`),
      element("thead", {}, element("tr", {}, ...head)), element("tbody", {}, ...rows)));
  }

  // ---- drawing: the network on a canvas of its own, so that a highlight costs a copy of it
  draw() {
    const height = this.height, scale = context(this.canvas, height + KEY)?.getTransform().a, width = this.canvas.clientWidth;
    if (!scale) return;
    this.picture.width = this.canvas.width;
    this.picture.height = this.canvas.height;
    const ctx = this.picture.getContext("2d"), k = this.scale;
    ctx.setTransform(scale, 0, 0, scale, 0, 0);
    ctx.fillStyle = palette.paper;
    ctx.fillRect(0, 0, width, height + KEY);
    ctx.save();
    this.clip(ctx);
    this.drawDiscs(ctx, width, height, k);
    this.drawLines(ctx, width, height, k);
    if (this.net.periodic.some(Boolean)) {
      ctx.strokeStyle = palette.edge;
      ctx.lineWidth = 1.5;
      ctx.strokeRect(...this.cell);
    }
    ctx.restore();
    this.drawKey(ctx, height, k);
    this.look();
  }

  look() {
    const ctx = this.canvas.getContext("2d");
    ctx.save();
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.picture, 0, 0);
    ctx.restore();
    ctx.save();
    this.clip(ctx);
    for (const found of [this.hovered, this.chosen]) if (found) this.highlight(ctx, found, this.scale);
    ctx.restore();
  }

  // Left, top, width and height of the cell on the canvas.
  get cell() {
    const [[x, y], [w, h]] = [this.net.origin, this.net.cell], [left, top] = this.screen(x, y + h);
    return [left, top, w * this.scale, h * this.scale];
  }

  clip(ctx) {
    const whole = [0, 0, this.canvas.clientWidth, this.height];
    for (const box of this.net.periodic.some(Boolean) ? [whole, this.cell] : [whole]) {
      ctx.beginPath();
      ctx.rect(...box);
      ctx.clip();
    }
  }

  drawDiscs(ctx, width, height, k) {
    const fills = [palette.disc, palette.grey, palette.edge], near = (disc) => {
      const [sx, sy] = this.screen(disc.x, disc.y), r = disc.r * k;
      return sx > -r && sx < width + r && sy > -r && sy < height + r ? [sx, sy, r] : null;
    };
    ctx.strokeStyle = palette.edge;
    ctx.lineWidth = Math.min(Math.max(0.03 * k, 0.3), 1);
    fills.forEach((fill, mark) => {
      ctx.beginPath();
      for (const disc of this.discs) {
        if (this.a.mark[disc.k] !== mark) continue;
        const place = near(disc);
        if (!place) continue;
        ctx.moveTo(place[0] + place[2], place[1]);
        ctx.arc(...place, 0, 2 * Math.PI);
      }
      ctx.fillStyle = fill;
      ctx.fill();
      if (k > 3) ctx.stroke();
    });
  }

  drawLines(ctx, width, height, k) {
    const dash = this.dash;
    let kind = -1, thick = -1;
    const flush = () => { if (kind >= 0) ctx.stroke(); };
    for (const line of this.lines) {
      if (!this.visible(line)) continue;
      const [ax, ay] = this.screen(line.ax, line.ay), [bx, by] = this.screen(line.bx, line.by);
      if (Math.max(ax, bx) < 0 || Math.min(ax, bx) > width || Math.max(ay, by) < 0 || Math.min(ay, by) > height) continue;
      const wide = this.width(line, k);
      if (line.kind !== kind || wide !== thick) {
        flush();
        [kind, thick] = [line.kind, wide];
        ctx.strokeStyle = palette[LOOKS[this.net.kinds[kind]]];
        ctx.lineWidth = thick;
        ctx.setLineDash(dash[kind]);
        ctx.lineCap = dash[kind].length ? "butt" : "round";
        ctx.beginPath();
      }
      ctx.moveTo(ax, ay);
      ctx.lineTo(bx, by);
    }
    flush();
    ctx.setLineDash([]);
    if (!this.marks) return;
    ctx.fillStyle = palette.extra;
    ctx.beginPath();
    for (const line of this.lines) {
      if (!this.visible(line) || !(this.a.flag[line.k] & 1)) continue;
      // the contact point, at the edge of grain i
      const part = this.a.d[this.a.i[line.k]] / 2 / Math.hypot(line.bx - line.ax, line.by - line.ay);
      const [sx, sy] = this.screen(line.ax + part * (line.bx - line.ax), line.ay + part * (line.by - line.ay));
      const r = Math.max(0.12 * k, 1.5);
      ctx.moveTo(sx + r, sy);
      ctx.arc(sx, sy, r, 0, 2 * Math.PI);
    }
    ctx.fill();
  }

  highlight(ctx, { grain, contact }, k) {
    ctx.strokeStyle = palette.link;
    ctx.lineWidth = 2.5;
    ctx.beginPath();
    if (grain !== undefined) {
      for (const disc of this.discs.filter((one) => one.k === grain)) {
        const [sx, sy] = this.screen(disc.x, disc.y);
        ctx.moveTo(sx + disc.r * k, sy);
        ctx.arc(sx, sy, disc.r * k, 0, 2 * Math.PI);
      }
    } else {
      for (const line of this.lines.filter((one) => one.k === contact)) {
        const [ax, ay] = this.screen(line.ax, line.ay), [bx, by] = this.screen(line.bx, line.by);
        const far = Math.hypot(bx - ax, by - ay), off = this.width(line, k) / 2 + 3;
        const [nx, ny] = [(-(by - ay) / far) * off, ((bx - ax) / far) * off];
        for (const side of [1, -1]) {
          ctx.moveTo(ax + side * nx, ay + side * ny);
          ctx.lineTo(bx + side * nx, by + side * ny);
        }
      }
    }
    ctx.stroke();
  }

  // A length and a force to scale, below the picture.
  drawKey(ctx, height, k) {
    const round = (value) => {
      const ten = 10 ** Math.floor(Math.log10(value));
      return [5, 2, 1].map((m) => m * ten).find((m) => m <= value);
    };
    const long = (this.key = round(110 / k)), band = this.net.band * this.widen * k, force = round(8 / band);
    ctx.font = "13px system-ui, sans-serif";
    ctx.textAlign = "left";
    ctx.lineCap = "butt";
    let x = 2;
    const part = (length, thick, colour, text) => {
      ctx.strokeStyle = colour;
      ctx.lineWidth = thick;
      ctx.beginPath();
      ctx.moveTo(x, height + KEY / 2);
      ctx.lineTo(x + length, height + KEY / 2);
      ctx.stroke();
      ctx.fillStyle = palette.ink;
      ctx.fillText(text, x + length + 8, height + KEY / 2 + 4);
      x += length + ctx.measureText(text).width + 34;
    };
    part(long * k, 1.5, palette.ink, `${show(long)} ${this.net.length}`);
    part(30, force * band, palette.compressive, `|N| = ${show(force)} ${this.net.symbol}`);
  }
}
