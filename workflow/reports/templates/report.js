"use strict";
// Starts the views of a run when it is shown, and the controls of the page.

const started = new Set();

function specOf(run, chart) {
  const arrays = (run.decoded ??= Object.fromEntries(Object.entries(run.arrays).map(([name, array]) => [name, decode(array)])));
  return { ...chart, lines: chart.lines.map(({ name, x, y }) => ({ name, x: arrays[x], y: arrays[y] })) };
}

function start(article) {
  const number = Number(article.dataset.run), run = data.runs[number];
  if (!run || started.has(number)) return;
  started.add(number);
  for (const root of article.querySelectorAll(".network")) {
    const network = new Network(root, run.network), player = root.querySelector(".player");
    if (player) new Player(player, network, run.film);
  }
  for (const box of article.querySelectorAll("[data-group]")) {
    const group = new Group();
    for (const root of box.querySelectorAll("[data-chart]")) new Chart(root, specOf(run, run.charts[Number(root.dataset.chart)]), group);
    groupControls(box.parentElement, group);
  }
}

function groupControls(section, group) {
  section.querySelector('[data-control="logx"]')?.addEventListener("change", (event) => {
    group.log = event.target.checked;
    group.set(null);
  });
  section.querySelector('[data-control="whole"]')?.addEventListener("click", () => group.set(null));
}

// ---- several runs: one is shown at a time
function select(number) {
  for (const article of document.querySelectorAll("article[data-run]")) article.hidden = Number(article.dataset.run) !== number;
  for (const row of document.querySelectorAll("tr[data-run]")) {
    if (Number(row.dataset.run) === number) row.setAttribute("aria-current", "true"); else row.removeAttribute("aria-current");
  }
  start(document.querySelector(`article[data-run="${number}"]`));
  redraw();
}

function follow() {
  const place = document.getElementById(location.hash.slice(1)), article = place?.closest("article[data-run]");
  if (!article || data.runs.length < 2) return;
  select(Number(article.dataset.run));
  place.scrollIntoView();
}

function sortable(table) {
  table.querySelectorAll("thead button").forEach((button) => button.addEventListener("click", () => {
    const head = button.parentElement, column = head.cellIndex, up = head.getAttribute("aria-sort") !== "ascending";
    for (const other of table.querySelectorAll("thead th")) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => row.cells[column]?.dataset.value ?? row.cells[column]?.textContent ?? "";
    const compare = (a, b) => {
      const [p, q] = [key(a), key(b)], [m, n] = [p, q].map(Number);
      if (p === "" || q === "") return p === q ? 0 : p === "" ? 1 : -1; // what is not known stays below
      const order = Number.isNaN(m) || Number.isNaN(n) ? p.localeCompare(q, "en", { numeric: true }) : m - n;
      return up ? order : -order;
    };
    const body = table.tBodies[0];
    body.append(...[...body.rows].sort(compare));
  }));
}

// One quantity of all runs.
function compare(section) {
  const root = section.querySelector("[data-compare]"), choice = section.querySelector("select");
  let group = null;
  const show = () => {
    for (const chart of group?.charts ?? []) views.splice(views.indexOf(chart), 1);
    const log = section.querySelector('[data-control="logx"]').checked, lines = [];
    let spec = null;
    group = new Group();
    group.log = log;
    for (const run of data.runs) {
      const chart = run.charts.find((one) => one.time && one.title === choice.value);
      if (!chart) continue;
      spec = spec || chart;
      const [line] = specOf(run, chart).lines;
      lines.push({ ...line, name: run.label });
    }
    new Chart(root, { ...spec, lines, stages: [] }, group);
    redraw();
  };
  choice.addEventListener("change", show);
  section.querySelector('[data-control="logx"]').addEventListener("change", show);
  section.querySelector('[data-control="whole"]').addEventListener("click", () => group.set(null));
  show();
}

// ---- colours
const theme = document.querySelector('[data-control="theme"]'), prefersDark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (document.documentElement.dataset.theme ?? (prefersDark.matches ? "dark" : "light")) === "dark";
function setTheme(name) {
  if (name) document.documentElement.dataset.theme = name; else delete document.documentElement.dataset.theme;
  theme.textContent = isDark() ? "Light colours" : "Dark colours";
  redraw();
}
theme.addEventListener("click", () => setTheme(isDark() ? "light" : "dark"));
prefersDark.addEventListener("change", () => setTheme(document.documentElement.dataset.theme));

// Paper is white and finer than a screen.
let before;
addEventListener("beforeprint", () => {
  before = document.documentElement.dataset.theme;
  printing = true;
  setTheme("light");
});
addEventListener("afterprint", () => {
  printing = false;
  setTheme(before);
});

readPalette();
document.querySelectorAll("table.sortable").forEach(sortable);
const comparison = document.getElementById("compare");
if (comparison) compare(comparison);
const first = document.querySelector("article[data-run]");
if (first) select(Number(first.dataset.run));
setTheme();
addEventListener("hashchange", follow);
follow();
// when the first picture is there, for those who measure it
requestAnimationFrame(() => setTimeout(() => { document.documentElement.dataset.ready = String(Math.round(performance.now())); }));
