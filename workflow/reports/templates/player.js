"use strict";
// Plays the frames of a run in its drawing.

const LASTS = 8000, PAUSES = [80, 700]; // milliseconds of a film, and of one frame at least and at most

class Player {
  // film: {frames [{label, arrays, cell, origin, window}], shown}; the arrays of the frame shown are those of the network
  constructor(root, network, film) {
    Object.assign(this, { network, film, timer: null, now: film.shown });
    film.frames[film.shown].arrays = network.net.arrays;
    this.slider = root.querySelector("input");
    this.output = root.querySelector("output");
    this.button = root.querySelector("button");
    const spans = film.frames.map(({ window: [left, bottom, right, top] }) => [right - left, top - bottom]);
    this.span = [0, 1].map((axis) => Math.max(...spans.map((span) => span[axis])));
    this.slider.addEventListener("input", () => { this.stop(); this.show(Number(this.slider.value)); });
    this.button.addEventListener("click", () => (this.timer === null ? this.play() : this.stop()));
  }

  // The window of a frame: as large as the largest, round the middle of its own.
  window({ window: [left, bottom, right, top] }) {
    const [x, y] = [(left + right) / 2, (bottom + top) / 2], [w, h] = this.span;
    return [x - w / 2, y - h / 2, x + w / 2, y + h / 2];
  }

  show(k) {
    const frame = this.film.frames[k];
    this.now = k;
    this.slider.value = String(k);
    this.slider.setAttribute("aria-valuetext", frame.label);
    this.output.value = frame.label;
    this.network.setFrame(frame, this.window(frame));
  }

  play() {
    const last = this.film.frames.length - 1, pause = Math.min(Math.max(LASTS / (last + 1), PAUSES[0]), PAUSES[1]);
    const next = (k) => {
      this.show(k);
      if (k === last) this.stop(); else this.timer = setTimeout(() => next(k + 1), pause);
    };
    this.button.textContent = "Pause";
    next(this.now === last ? 0 : this.now + 1);
  }

  stop() {
    clearTimeout(this.timer);
    this.timer = null;
    this.button.textContent = "Play";
  }
}
