// The panels, drawn by Plotly when they come into sight; all time axes move together.
const FEET = ["#0072B2", "#D55E00"], PIECES = 700;
const ROW = { screen: 150, paper: 120 };
const narrow = () => window.innerWidth < 620;
const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

class Plots {
  constructor(shape, place, seek) {
    Object.assign(this, { shape, place, seek, width: place.clientWidth, range: [0, shape.duration],
      drawn: [], row: ROW.screen });
    for (const panel of shape.panels) this.add(panel, place);
    const watch = new IntersectionObserver(seen => {
      for (const { target, isIntersecting } of seen)
        if (isIntersecting) { watch.unobserve(target); this.draw(target); }
    }, { rootMargin: "300px" });
    for (const plot of place.querySelectorAll(".plot")) watch.observe(plot);
    let before = narrow();
    window.addEventListener("resize", () => {
      if (before === narrow()) return;
      before = narrow();
      this.width = place.clientWidth;
      for (const plot of place.querySelectorAll(".plot")) plot.style.height = this.height(plot.panel) + "px";
      this.redraw();
    });
  }

  add(panel, place) {
    for (const { curves } of panel.cells)
      curves.forEach(curve => { curve.order = curves.filter(({ run, plan }) => run === curve.run && !plan).indexOf(curve); });
    let into = place.appendChild(document.createElement("section"));
    if (panel.folded) {
      into = into.appendChild(document.createElement("details"));
      into.appendChild(document.createElement("summary")).textContent = panel.title;
    } else into.appendChild(document.createElement("h3")).textContent = panel.title;
    into.appendChild(this.legend(panel.cells));
    const plot = into.appendChild(document.createElement("div"));
    plot.className = "plot";
    plot.panel = panel;
    plot.style.height = this.height(panel) + "px";
  }

  // A curve that has another colour in another cell is told with all of them.
  legend(cells) {
    const list = document.createElement("ul");
    list.className = "curves";
    cells[0].curves.forEach((curve, k) => {
      const entry = list.appendChild(document.createElement("li"));
      const style = { solid: "solid", dash: "dashed", dot: "dotted" }[this.dash(curve)];
      for (const colour of new Set(cells.map(cell => this.colour(cell.curves[k], name => `var(${name})`))))
        entry.appendChild(document.createElement("i")).style.borderTop = `2px ${style} ${colour}`;
      entry.append(this.name(curve));
    });
    return list;
  }

  // The first of several runs is a ghost here, too.
  ghost({ run, plan }) { return !plan && run < this.shape.runs.length - 1; }

  colour(curve, of) {
    if (this.ghost(curve)) return of("--ghost");
    return curve.colour.startsWith("#") ? curve.colour : of(`--${curve.colour}`);
  }

  // Of one ghost the lines of a cell differ; of several ghosts each has its own.
  dash(curve) {
    if (!this.ghost(curve)) return curve.dash;
    return ["solid", "dash", "dot"][(this.shape.runs.length > 2 ? curve.run : curve.order) % 3];
  }

  name({ name, plan, run }) {
    return this.shape.runs.length > 1 && !plan ? `${name}, ${this.shape.runs[run].name}` : name;
  }

  columns(panel) { return narrow() ? Math.min(panel.columns, panel.columns > 2 ? 2 : 1) : panel.columns; }

  height(panel) {
    const rows = Math.ceil(panel.cells.length / this.columns(panel)), [cell] = panel.cells;
    if (!cell.across) return rows * this.row + 50;
    if (panel.cells.length > 1) return rows * (narrow() ? 340 : 400);
    const extent = k => {
      const all = cell.outlines.flat().map(point => point[k]);
      return Math.max(...all) - Math.min(...all);
    };
    return Math.min(Math.max(this.width * extent(1) / extent(0), 120), 480) + 70;
  }

  draw(plot) {
    const { traces, layout } = this.figure(plot.panel);
    const config = { displayModeBar: false, responsive: true };
    plot.style.height = this.height(plot.panel) + "px";
    Plotly.react(plot, traces, layout, config);
    if (this.drawn.includes(plot)) return this.mark(plot);
    this.drawn.push(plot);
    if (!plot.panel.cells[0].across) {
      plot.on("plotly_click", event => this.seek(event.points[0].x));
      plot.on("plotly_relayout", change => this.zoomed(change));
    } else plot.on("plotly_click", ({ points: [{ pointNumber, data }] }) => {
      if (data.every) this.seek(pointNumber * data.every * this.shape.period);
    });
    plot.on("plotly_afterplot", () => this.mark(plot));
    this.mark(plot);
  }

  redraw() { for (const plot of this.drawn) this.draw(plot); }

  // Plotly tells both ends, or the range as one, or that all is shown again.
  zoomed(change) {
    const key = Object.keys(change).find(each => /^xaxis\d*\.(range|autorange)/.test(each));
    if (!key) return;
    const axis = key.split(".")[0];
    this.range = change[`${axis}.range`]
      || (change[`${axis}.autorange`] ? null : [change[`${axis}.range[0]`], change[`${axis}.range[1]`]])
      || [0, this.shape.duration];
    this.redraw();
  }

  figure(panel) {
    const columns = this.columns(panel), rows = Math.ceil(panel.cells.length / columns);
    const traces = [], over = !panel.cells[0].across;
    const layout = {
      height: this.height(panel), margin: { l: over ? 40 : 54, r: 10, t: 24, b: 36 }, showlegend: false,
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", dragmode: "zoom",
      font: { color: css("--ink"), size: 11.5, family: "system-ui, Helvetica Neue, Arial, sans-serif" }, hovermode: over ? "x unified" : "closest",
      hoverlabel: { bgcolor: css("--card"), bordercolor: css("--line") },
      annotations: [], shapes: [], uirevision: "kept",
    };
    const px = 1 / (this.height(panel) - 60), gap = 64 * px, wide = over ? 0.07 : 0.1;
    panel.cells.forEach((cell, i) => {
      const column = i % columns, row = Math.floor(i / columns), id = i ? String(i + 1) : "";
      const width = (1 - wide * (columns - 1)) / columns, height = 1 / rows;
      const left = column * (width + wide), top = 1 - row * height;
      const axis = { gridcolor: css("--grid"), zerolinecolor: css("--line"), linecolor: css("--line"), automargin: false };
      const bottom = top - height + (row < rows - 1 ? (over ? 26 * px : gap) : 0);
      layout[`xaxis${id}`] = { ...axis, domain: [left, left + width], anchor: `y${id}` };
      layout[`yaxis${id}`] = { ...axis, domain: [bottom, top - (row ? 8 * px : 0)], anchor: `x${id}`,
        title: { text: over ? "" : cell.unit, standoff: 4, font: { size: 11.5 } } };
      const x = layout[`xaxis${id}`], y = layout[`yaxis${id}`];
      if (over) {
        Object.assign(x, { range: [...this.range], showticklabels: row === rows - 1 });
        if (row === rows - 1) x.title = { text: "time (s)", standoff: 4, font: { size: 11.5 } };
        this.events(layout, id);
      } else {
        x.title = { text: cell.across, standoff: 4, font: { size: 11.5 } };
        if (cell.square) Object.assign(y, { scaleanchor: `x${id}`, scaleratio: 1 });
      }
      layout.annotations.push({ text: `<b>${cell.title}</b>${over ? ` (${cell.unit})` : ""}`, x: left, y: top, xref: "paper", xanchor: "left",
        yref: "paper", yanchor: "bottom", showarrow: false, font: { size: 11.5 } });
      for (const line of cell.outlines) traces.push({ x: line.map(p => p[0]).concat(line[0][0]),
        y: line.map(p => p[1]).concat(line[0][1]), xaxis: `x${id}`, yaxis: `y${id}`, mode: "lines", fill: "toself",
        fillcolor: "rgba(128,140,152,.14)", line: { color: css("--faint"), width: 0.7 }, hoverinfo: "skip" });
      for (const [x, y, text] of cell.notes) layout.annotations.push({ text, x, y, xref: `x${id}`, yref: `y${id}`,
        showarrow: false, font: { size: 10, color: css("--faint") } });
      for (const curve of cell.curves) traces.push(this.trace(curve.unpacked(), id, over));
    });
    return { traces, layout };
  }

  trace(curve, id, over) {
    const { runs, period } = this.shape, ghost = this.ghost(curve);
    const points = over ? thinned(curve, runs[curve.run].start, period, ...this.range, PIECES)
      : { x: Array.from(curve.x), y: Array.from(curve.y, v => isNaN(v) ? null : v) };
    return { ...points, every: over ? 0 : curve.every, name: this.name(curve), xaxis: `x${id}`, yaxis: `y${id}`,
      mode: "lines", hovertemplate: over ? "%{y:.4g}" : "%{x:.4g}, %{y:.4g}",
      line: { color: this.colour(curve, css), width: ghost ? 1.5 : curve.plan ? 1 : 1.6,
        dash: this.dash(curve) } };
  }

  events(layout, id) {
    const line = (x, color, dash) => layout.shapes.push({ type: "line", x0: x, x1: x, y0: 0, y1: 1, xref: `x${id}`,
      yref: `y${id} domain`, line: { color, width: 1.2, dash } });
    for (const { fall } of this.shape.runs) if (fall !== null) line(fall, css("--bad"), "solid");
    for (const { name, what, planned, time } of this.shape.events) {
      layout.shapes.push({ type: "rect", x0: Math.min(planned, time), x1: Math.max(planned, time), y0: 0, y1: 1, xref: `x${id}`,
        yref: `y${id} domain`, fillcolor: css("--ghost"), opacity: 0.25, line: { width: 0 } });
      line(time, css("--faint"), "dot");
      layout.annotations.push({ text: `<i>${name.replace(/\d+/, "<sub>$&</sub>")}</i>`, hovertext: what, x: time, xref: `x${id}`,
        y: 1, yref: `y${id} domain`, yanchor: "top", xanchor: "left", showarrow: false, font: { color: css("--faint") } });
    }
  }

  // The cursor is no part of the plot: to move it costs no drawing.
  at(time) {
    this.time = time;
    for (const plot of this.drawn) this.mark(plot);
  }

  mark(plot) {
    const layout = plot._fullLayout;
    if (!layout || !layout._subplots) return;
    const marks = plot.marks || (plot.marks = plot.panel.cells.map(cell => {
      const mark = plot.appendChild(document.createElement("div"));
      mark.className = cell.across ? "dot" : "cursor";
      return mark;
    }));
    plot.panel.cells.forEach((cell, i) => {
      const id = i ? String(i + 1) : "", x = layout[`xaxis${id}`], y = layout[`yaxis${id}`], style = marks[i].style;
      let here = this.time, there = null;
      if (cell.across) {
        const curve = cell.curves.find(c => c.run === this.shape.runs.length - 1);
        const k = Math.min(Math.round((this.time || 0) / this.shape.period / curve.every), curve.y.length - 1);
        [here, there] = [curve.x[k], curve.y[k]];
      }
      const left = x.l2p(here), top = there === null ? 0 : y.l2p(there);
      const inside = left >= -1 && left <= x._length + 1 && !isNaN(left) && !isNaN(top);
      style.display = inside ? "" : "none";
      if (!inside) return;
      style.left = x._offset + left + "px";
      style.top = y._offset + top + "px";
      if (there === null) style.height = y._length + "px";
    });
  }
}
