// One time for all: the replay, the gait and every curve show it.
const byId = id => document.getElementById(id);
const replay = { frame: null, ready: false };
let shape, plots, now = 0, playing = false, tick = 0;

function theme(chosen) {
  document.documentElement.dataset.theme = chosen;
  tell({ sky: chosen });
  if (plots) { plots.redraw(); drawGait(); }
}

function tell(message) {
  if (replay.frame) replay.frame.contentWindow.postMessage(message, "*");
}

function show(time) {
  now = Math.min(Math.max(time, 0), shape.duration);
  byId("time").textContent = `${now.toFixed(2)} s`;
  plots.at(now);
  drawGait();
}

function seek(time) {
  show(time);
  tell({ time: now });
}

function play(start) {
  playing = start;
  byId("play").textContent = start ? "❚❚ pause" : "▶ play";
  if (!start) return;
  if (now >= shape.duration) seek(0);
  let before = performance.now();
  const mine = ++tick;
  requestAnimationFrame(function step(at) {
    if (!playing || mine !== tick) return;
    seek(now + Number(byId("speed").value) * (at - before) / 1000);
    before = at;
    if (now >= shape.duration) play(false); else requestAnimationFrame(step);
  });
}

// Planned support as broad bars, closed contacts as narrow ones in them; it is the slider, too.
function drawGait() {
  const canvas = byId("gait"), scale = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  if (canvas.width !== width * scale) { canvas.width = width * scale; canvas.height = height * scale; }
  const pen = canvas.getContext("2d"), run = shape.runs[shape.runs.length - 1];
  const x = time => 14 + (width - 14) * time / shape.duration, band = (height - 14) / 2;
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = "11px system-ui, sans-serif";
  ["L", "R"].forEach((foot, i) => {
    pen.fillStyle = css("--faint");
    pen.fillText(foot, 0, i * band + band / 2 + 4);
    pen.fillStyle = FEET[i];
    const bars = (times, part) => times.forEach(([a, b]) =>
      pen.fillRect(x(a), i * band + band * (1 - part) / 2, x(b) - x(a), band * part));
    pen.globalAlpha = 0.3; bars(run.planned[i], 0.86);
    pen.globalAlpha = 1; bars(run.closed[i], 0.3);
  });
  pen.fillStyle = css("--faint");
  for (const { name, time } of shape.events) pen.fillText(name, x(time) - 5, height - 1);
  if (!shape.events.length) for (let t = 0; t <= shape.duration; t += shape.duration > 8 ? 2 : 1)
    pen.fillText(t, x(t) - (t ? 6 : 0), height - 1);
  pen.fillStyle = css("--cursor");
  pen.fillRect(x(now) - 0.75, 0, 1.5, 2 * band);
}

function connect() {
  const pick = event => seek(shape.duration * (event.offsetX - 14) / (byId("gait").clientWidth - 14));
  byId("gait").addEventListener("pointerdown", event => { play(false); pick(event); });
  byId("gait").addEventListener("pointermove", event => { if (event.buttons) pick(event); });
  byId("play").addEventListener("click", () => play(!playing));
  byId("theme").addEventListener("click", () =>
    theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  window.addEventListener("message", ({ source, data }) => {
    if (!replay.frame || source !== replay.frame.contentWindow || !data.replay) return;
    if (data.ready) {
      replay.ready = true;
      document.documentElement.dataset.ready = "replay";
      byId("play").disabled = false;
      theme(document.documentElement.dataset.theme);
      seek(now);
    } else if (data.time !== undefined && !playing) show(data.time);
  });
  window.addEventListener("resize", drawGait);
  let before;
  window.addEventListener("beforeprint", () => {
    before = document.documentElement.dataset.theme;
    for (const folded of document.querySelectorAll("details")) folded.open = true;
    plots.row = ROW.paper;
    theme("light");
    for (const plot of document.querySelectorAll(".plot")) plots.draw(plot);
  });
  window.addEventListener("afterprint", () => { plots.row = ROW.screen; theme(before); });
}

async function load() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  theme(dark.matches ? "dark" : "light");
  dark.addEventListener("change", () => theme(dark.matches ? "dark" : "light"));
  const script = document.createElement("script");
  [script.textContent, shape] = await Promise.all([unpack(byId("plotly").textContent), unpackCurves()]);
  document.head.append(script);
  plots = new Plots(shape, byId("panels"), time => { play(false); seek(time); });
  connect();
  show(shape.events.length ? shape.events[0].time : 0);
  document.documentElement.dataset.ready = "curves";
  const frame = document.createElement("iframe");
  frame.title = "replay";
  frame.srcdoc = await unpack(byId("scene").textContent);
  byId("replay").replaceChildren(frame);
  replay.frame = frame;
}

load();
