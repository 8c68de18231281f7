// Every trial a plot; of all contenders the quantity that is chosen, over the trial's size.
const byId = id => document.getElementById(id);
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const hidden = new Set();
let content;

function theme(chosen) {
  document.documentElement.dataset.theme = chosen;
  if (content) draw();
}

// Of many contenders each has a paler band, or all would be mud.
function faint(colour) {
  const shown = content.contenders.length - hidden.size, part = Math.min(0.11, 0.4 / shown);
  return colour + Math.round(255 * part).toString(16).padStart(2, "0");
}

function traces(trial, key) {
  const found = [];
  content.contenders.forEach(({ name, colour, dash }) => {
    const curve = content.trials[trial].curves[name];
    if (!curve || hidden.has(name)) return;
    const x = curve.map(p => p.size), line = { color: colour, width: 2, dash };
    const percent = values => key === "share" ? values.map(v => 100 * v) : values;
    if (key === "share") found.push({
      x: [...x, ...[...x].reverse()],
      y: percent([...curve.map(p => p.high), ...[...curve].reverse().map(p => p.low)]),
      fill: "toself", fillcolor: faint(colour), line: { width: 0 }, hoverinfo: "skip", mode: "lines" });
    found.push({ x, y: percent(curve.map(p => p[key])), name, mode: "lines+markers", line,
      marker: { size: 5 }, hovertemplate: "%{y:.3g}" });
  });
  return found;
}

function draw() {
  const key = byId("what").value, label = byId("what").selectedOptions[0].textContent;
  for (const plot of document.querySelectorAll(".plot")) {
    const { unit } = content.trials[plot.dataset.trial];
    const axis = { gridcolor: css("--grid"), zerolinecolor: css("--line"), linecolor: css("--line") };
    Plotly.react(plot, traces(plot.dataset.trial, key), {
      height: 230, margin: { l: 46, r: 10, t: 8, b: 38 }, showlegend: false, hovermode: "x unified",
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: css("--ink"), size: 11.5, family: "system-ui, Helvetica Neue, Arial, sans-serif" },
      hoverlabel: { bgcolor: css("--card"), bordercolor: css("--line") },
      xaxis: { ...axis, title: { text: unit, standoff: 4 } },
      yaxis: { ...axis, title: { text: label, standoff: 4, font: { size: 11 } }, range: key === "share" ? [-4, 104] : undefined,
        rangemode: "tozero" },
    }, { displayModeBar: false, responsive: true });
  }
  drawPushes();
  document.documentElement.dataset.ready = "curves";
}

// Pushes, over their direction: the impulse at which half fall, or the largest that was tried.
function drawPushes() {
  const pushes = Object.values(content.trials).filter(trial => trial.direction !== null)
    .sort((a, b) => a.direction - b.direction);
  if (pushes.length < 3) return;
  const found = content.contenders.filter(({ name }) => !hidden.has(name) && pushes[0].curves[name])
    .map(({ name, colour, dash }) => {
      const reach = pushes.map(({ halves, curves }) =>
        halves[name] === null ? curves[name].at(-1).size : halves[name]);
      return { type: "scatterpolar", name, mode: "lines+markers", line: { color: colour, width: 2, dash },
        marker: { size: 4 }, theta: [...pushes, pushes[0]].map(push => push.direction), r: [...reach, reach[0]],
        hovertemplate: `%{r:.3g} ${pushes[0].unit}` };
    });
  const axis = { gridcolor: css("--grid"), linecolor: css("--line") };
  Plotly.react(byId("pushes"), found, {
    height: 400, margin: { l: 60, r: 60, t: 34, b: 34 }, showlegend: false, paper_bgcolor: "rgba(0,0,0,0)",
    font: { color: css("--ink"), size: 11.5, family: "system-ui, Helvetica Neue, Arial, sans-serif" },
    polar: { bgcolor: "rgba(0,0,0,0)", radialaxis: { ...axis, angle: 22, ticksuffix: ` ${pushes[0].unit}`, rangemode: "tozero" },
      angularaxis: { ...axis, rotation: 90, tickvals: [0, 90, 180, 270], ticktext: ["forward", "left", "backward", "right"] } },
  }, { displayModeBar: false, responsive: true });
}

function names() {
  for (const { name, colour, dash } of content.contenders) {
    const entry = byId("names").appendChild(document.createElement("li"));
    const line = entry.appendChild(document.createElement("i"));
    line.style.borderTop = `2px ${dash === "dash" ? "dashed" : "solid"} ${colour}`;
    entry.append(name);
    const mark = () => [...byId("names").children].forEach((each, i) =>
      each.classList.toggle("off", hidden.has(content.contenders[i].name)));
    entry.addEventListener("click", () => { hidden.delete(name) || hidden.add(name); mark(); draw(); });
    entry.addEventListener("dblclick", () => {
      hidden.clear();
      for (const other of content.contenders) if (other.name !== name) hidden.add(other.name);
      mark(); draw();
    });
  }
}

async function load() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  theme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));
  const script = document.createElement("script");
  [script.textContent, content] = await Promise.all([unpack(byId("plotly").textContent),
    unpack(byId("content").textContent).then(JSON.parse)]);
  document.head.append(script);
  names();
  for (const trial of Object.keys(content.trials)) {
    const section = byId("trials").appendChild(document.createElement("section"));
    section.appendChild(document.createElement("h3")).textContent = trial;
    const plot = section.appendChild(document.createElement("div"));
    plot.className = "plot";
    plot.dataset.trial = trial;
  }
  byId("what").addEventListener("change", draw);
  byId("theme").addEventListener("click", () =>
    theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  let before;
  window.addEventListener("beforeprint", () => {
    before = document.documentElement.dataset.theme;
    theme("light");
  });
  window.addEventListener("afterprint", () => theme(before));
  draw();
}

load();
