// What runs tells ten times a second how it is; here it becomes numbers, and lines at the ports.
const KEPT = 100, SPARK = [50, 11], REGULAR = 30;
const SVG = "http://www.w3.org/2000/svg";
const byId = id => document.getElementById(id);
const history = {};
let about = null, chosen = null;

function add(parent, tag, text) {
  const child = parent.appendChild(document.createElement(tag));
  if (text !== undefined) child.textContent = text;
  return child;
}

function addShape(parent, tag, attributes) {
  const child = parent.appendChild(document.createElementNS(SVG, tag));
  for (const [name, value] of Object.entries(attributes)) child.setAttribute(name, value);
  return child;
}

function view(name) {
  document.body.dataset.view = name;
  location.replace(`#${name}`);
  if (name === "diagram") prepare();
}

function describe(told) {
  about = told;
  for (const name of ["keys", "sliders", "gains"]) {
    byId(name).replaceChildren();
    for (const [what, text] of told.controls[name]) {
      const row = add(byId(name), "tr");
      add(row, "td", what);
      add(row, "td", text);
    }
  }
  byId("legend").replaceChildren();
  for (const [colour, text] of told.legend) {
    const entry = add(byId("legend"), "li");
    add(entry, "i").style.background = colour;
    entry.append(text);
  }
  for (const name of Object.keys(history)) delete history[name];
}

const fixed = (value, digits) => value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");
const number = value => value === null ? "–" : Math.abs(value) >= 1e5 || (value && Math.abs(value) < 1e-3)
  ? value.toExponential(1) : String(Number(value.toPrecision(4)));

function show(now) {
  byId("time").textContent = `${fixed(now.time, 1)} s`;
  byId("place").textContent = `${now.position.map(x => fixed(x, 2)).join(", ")} m`;
  byId("heading").textContent = `${fixed(now.heading, 1)}°`;
  byId("speed").textContent = `${fixed(now.speed, 2)} m/s`;
  byId("lean").textContent = `${now.lean.map(x => fixed(x, 2)).join("°, ")}°`;
  byId("pace").textContent = `× ${fixed(now.pace, 2)}`;
  byId("pace").parentNode.title = `could be × ${fixed(now.possible, 1)}`;
  byId("state").textContent = `${now.state}; it could run at × ${fixed(now.possible, 1)}`;
  for (const [name, values] of Object.entries(now.signals)) {
    const past = history[name] ||= [];
    past.push(values);
    if (past.length > KEPT) past.shift();
  }
  if (document.body.dataset.view === "diagram") { for (const port of ports) draw(port); detail(); }
  document.documentElement.dataset.told = String(1 + Number(document.documentElement.dataset.told || 0));
}

// At a port stands the entry that the reader has chosen, or else the one that moves most.
function liveliest(past) {
  const part = past[0].map((_, i) => {
    const all = past.map(values => values[i]).filter(value => value !== null);
    const low = Math.min(...all), high = Math.max(...all);
    return Math.min((high - low) / (Math.max(Math.abs(low), Math.abs(high)) + 1e-9), 1);
  });
  return part.indexOf(Math.max(...part));
}

function line(past, i, [width, height]) {
  const all = past.map(values => values[i]).filter(value => value !== null);
  const low = Math.min(...all), span = Math.max(...all) - low;
  return past.map((values, k) => values[i] === null ? "" : `${k && past[k - 1][i] !== null ? "L" : "M"}` +
    `${(width * (k + KEPT - past.length) / (KEPT - 1)).toFixed(1)} ` +
    `${(span ? height * (1 - (values[i] - low) / span) : height / 2).toFixed(1)}`).join("");
}

let ports = [];
const entryAt = {};
function prepare() {
  if (ports.length) return;
  for (const group of document.querySelectorAll("#diagram_view g[data-signal]")) {
    const name = group.dataset.signal, texts = [...group.querySelectorAll("text")].map(t => t.getBBox());
    if (!name) continue;
    const left = Math.min(...texts.map(t => t.x)), right = Math.max(...texts.map(t => t.x + t.width));
    const top = Math.min(...texts.map(t => t.y)), below = Math.max(...texts.map(t => t.y + t.height)) + 1;
    const path = addShape(group, "path", { class: "spark", transform: `translate(${right - SPARK[0]} ${below})` });
    const value = addShape(group, "text", { class: "value", x: left, y: below + 9 });
    addShape(group, "rect", { x: left, y: top, width: right - left, height: below + 12 - top, fill: "transparent" });
    group.addEventListener("click", () => {
      for (const each of ports) each.group.classList.toggle("chosen", each.name === name);
      chosen = name;
      detail();
    });
    ports.push({ group, name, path, value });
  }
}

function draw({ name, path, value }) {
  const past = history[name];
  if (!past) return;
  if (!entryAt[name] || !entryAt[name].mine && past.length % REGULAR === 0) entryAt[name] = { at: liveliest(past) };
  const { at } = entryAt[name], { entries, units } = about.signals[name];
  path.setAttribute("d", line(past, at, SPARK));
  const unit = /^(-|0\/1)?$/.test(units[at]) ? "" : ` ${units[at]}`;
  const entry = entries[at].split(".").pop(), text = number(past[past.length - 1][at]) + unit;
  value.textContent = entry.length + text.length < 15 ? `${entry} ${text}` : text;
}

function choose(name, i) {
  entryAt[name] = { at: i, mine: true };
  for (const port of ports) if (port.name === name) draw(port);
}

function detail() {
  if (!chosen || !history[chosen]) return;
  const past = history[chosen], { doc, entries, units } = about.signals[chosen];
  const place = byId("port");
  if (place.dataset.signal !== chosen) {
    place.dataset.signal = chosen;
    place.replaceChildren();
    add(place, "h2", chosen);
    add(place, "p", `${doc} Click an entry to have it at the port.`);
    const table = add(place, "table");
    entries.forEach((name, i) => {
      const row = add(table, "tr");
      add(row, "td", name);
      add(row, "td");
      addShape(addShape(add(row, "td"), "svg", { viewBox: "-1 -1 98 18" }), "path", { class: "spark" });
      row.addEventListener("click", () => choose(chosen, i));
    });
  }
  place.querySelectorAll("tr").forEach((row, i) => {
    row.children[1].textContent = `${number(past[past.length - 1][i])} ${units[i]}`;
    row.querySelector("path").setAttribute("d", line(past, i, [96, 16]));
    row.classList.toggle("shown", entryAt[chosen]?.at === i);
  });
}

function begin() {
  for (const name of ["scene", "diagram"]) byId(`${name}_button`).addEventListener("click", () => view(name));
  const frame = document.createElement("iframe");
  frame.title = "scene";
  frame.src = `${location.protocol}//${location.hostname}:${document.body.dataset.scene}`;
  frame.addEventListener("load", () => frame.focus());
  byId("scene_view").append(frame);
  view(location.hash === "#diagram" ? "diagram" : "scene");
  const stream = new EventSource(`events${location.search}`);
  stream.addEventListener("about", ({ data }) => describe(JSON.parse(data)));
  stream.addEventListener("now", ({ data }) => show(JSON.parse(data)));
  stream.addEventListener("error", () => { byId("state").textContent = "The simulation has ended."; });
}

begin();
