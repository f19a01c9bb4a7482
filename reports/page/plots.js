// Error against time, and the convergence of fits.
"use strict";
(() => {
  const note = (div, text) => { div.style.height = "auto"; div.textContent = text; };
  const look = () => {
    const dark = opaline.dark();
    return {
      text: dark ? "#e6eaee" : "#1c2229", grid: dark ? "#333c45" : "#dde2e7", ground: dark ? "#14181c" : "#ffffff",
      // After Okabe and Ito: distinct with any colour vision, and dark or light enough for the ground.
      series: dark ? ["#56b4e9", "#e69f00", "#2fc49a", "#e08fc0", "#f0e442", "#ff8a50", "#9db4ff", "#c8c8c8"]
                   : ["#0072b2", "#b35a00", "#00795a", "#a8447f", "#8a7500", "#c03000", "#4a4fc4", "#555555"],
    };
  };
  const symbols = ["circle", "square", "diamond", "triangle-up", "cross", "star", "triangle-down", "hexagon"];
  const axis = (title, l) => ({
    title: { text: title }, type: "log", gridcolor: l.grid, zeroline: false, exponentformat: "power", automargin: true, minor: { ticks: "outside", ticklen: 3, tickcolor: l.grid },
  });
  const layout = (x, y) => {
    const l = look();
    return {
      xaxis: axis(x, l), yaxis: axis(y, l), font: { color: l.text, size: 13 }, paper_bgcolor: l.ground, plot_bgcolor: l.ground,
      margin: { l: 60, r: 15, t: 15, b: 50 }, hovermode: "closest",
      hoverlabel: { align: "left", bgcolor: l.ground, font: { color: l.text } },
      // On paper the legend stands for the switches, and the width is the paper's (A4 less its margins, at 96 dpi).
      showlegend: opaline.printing(), legend: { orientation: "h", y: -0.22 }, width: opaline.printing() ? 690 : undefined, autosize: true,
      // Dragging on a touch screen scrolls the page.
      dragmode: matchMedia("(pointer: coarse)").matches ? false : "zoom",
    };
  };
  // No button that sends anything anywhere; on a touch screen there is no room for any.
  const config = {
    responsive: true, displaylogo: false, displayModeBar: matchMedia("(pointer: coarse)").matches ? false : "hover",
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"]],
  };

  // Each plot is drawn when it comes near the window, and all of them before printing.
  const waiting = new Map();
  const draw = (div) => { const f = waiting.get(div); waiting.delete(div); seen.unobserve(div); if (f) f(); };
  const seen = new IntersectionObserver((entries) => { for (const e of entries) if (e.isIntersecting) draw(e.target); }, { rootMargin: "400px" });
  const later = (div, f) => { waiting.set(div, f); seen.observe(div); };
  addEventListener("beforeprint", () => { for (const div of [...waiting.keys()]) draw(div); });

  const time = (s) => s >= 1 ? `${s.toPrecision(3)} s` : s >= 1e-3 ? `${(s * 1e3).toPrecision(3)} ms` : `${(s * 1e6).toPrecision(3)} µs`;
  const escape = (text) => String(text).replace(/[&<>"']/g, (c) => `&#${c.charCodeAt(0)};`);

  const errorPlot = (div) => {
    const data = opaline.json("plot-data");
    const { element, select } = opaline;
    const hidden = { technique: new Set(), backend: new Set() };
    let shown = [];  // points of the plot, fastest first: {point, x, y, curve, index}
    let at = -1;

    const axes = ["frame", "prepare + frame", "irradiance + prepare + frame"];
    const metricTitle = (name) => name.startsWith("truth:") ? `${name.slice(6)} against truth` : name;
    const redraw = () => { at = -1; if (!waiting.has(div)) show(); };
    const scene = select("Scene", data.groups, redraw, "plot-scene");
    const metric = select("Error", data.metrics.map((m) => metricTitle(m).replaceAll("_", " ")), redraw, "plot-metric");
    const timing = select("Time", axes, redraw, "plot-time");
    document.getElementById("plot-controls").append(scene.label, metric.label, timing.label);

    const swatches = [];
    const toggles = (id, key, names) => {
      const all = names.map((name, i) => {
        const box = element("input", { type: "checkbox", checked: true, value: name });
        box.addEventListener("change", () => { box.checked ? hidden[key].delete(name) : hidden[key].add(name); redraw(); });
        const label = element("label", {}, [box]);
        if (key === "technique") { const s = element("span", { className: "swatch" }); s.setAttribute("aria-hidden", "true"); swatches.push([s, i]); label.append(s); }
        label.append(key === "technique" ? name : `${name} (${name === "gpu" ? "open" : "filled"} marks)`);
        return label;
      });
      document.getElementById(id).append(...all);
    };
    toggles("technique-toggles", "technique", data.techniques);
    toggles("backend-toggles", "backend", [...new Set(data.points.map((p) => p.backend))].sort());

    const x = (p) => p.render + (timing.list.selectedIndex > 0 ? p.prepare : 0) + (timing.list.selectedIndex > 1 ? p.irradiance : 0);
    const y = (p) => p.errors[metric.list.selectedIndex];
    const wanted = () => data.points.filter((p) => p.group === scene.list.selectedIndex && !hidden.technique.has(p.technique) &&
      !hidden.backend.has(p.backend) && x(p) > 0 && y(p) !== null);
    // Larger is better for these two; a front of "least error" makes no sense there.
    const rising = () => /psnr|ssim/.test(data.metrics[metric.list.selectedIndex]);
    const front = (points) => {
      const best = [];
      const value = (p) => (rising() ? -1 : 1) * Math.abs(y(p));
      for (const p of [...points].sort((a, b) => x(a) - x(b) || value(a) - value(b)))
        if (!best.length || value(p) < value(best.at(-1))) best.push(p);
      return best;
    };
    const label = (p) => `${p.technique}, ${p.backend}, ${p.settings}: ${metricTitle(data.metrics[metric.list.selectedIndex])} ${y(p) === 0 ? "0, the same image" : y(p).toPrecision(3)}, ${time(x(p))}`;

    const show = () => {
      const l = look();
      const points = wanted();
      // No logarithm of 0 or below: such points sit at the lower edge (0) or show their size (signed errors).
      const sizes = points.map((p) => Math.abs(y(p))).filter((v) => v > 0);
      const floor = sizes.length ? Math.min(...sizes) / 3 : 1e-6;
      const height = (p) => Math.abs(y(p)) || floor;
      const traces = [];
      shown = [];
      data.techniques.forEach((technique, i) => {
        for (const backend of ["cpu", "gpu"]) {
          const mine = points.filter((p) => p.technique === technique && (p.backend === "gpu") === (backend === "gpu"));
          if (!mine.length) continue;
          mine.forEach((p, index) => shown.push({ p, curve: traces.length, index }));
          traces.push({
            type: "scatter", mode: "markers", name: `${technique}, ${mine[0].backend}`, x: mine.map(x), y: mine.map(height), customdata: mine.map((p) => p.id),
            text: mine.map((p) => escape(label(p)).replace(": ", "<br>")), hovertemplate: "%{text}<extra></extra>",
            marker: { size: 10, color: l.series[i % l.series.length], symbol: symbols[i % symbols.length] + (backend === "gpu" ? "-open" : ""), line: { width: backend === "gpu" ? 2 : 1 } },
          });
        }
      });
      const best = front(points);
      div.frontIds = best.map((p) => p.id);
      traces.push({ type: "scatter", mode: "lines", name: "Pareto front", x: best.map(x), y: best.map(height), line: { shape: "hv", color: l.text, width: 1.5, dash: "dot" }, hoverinfo: "skip" });
      shown.sort((a, b) => x(a.p) - x(b.p));
      for (const [s, i] of swatches) s.style.background = l.series[i % l.series.length];
      Plotly.react(div, traces, layout(`time of ${axes[timing.list.selectedIndex]} [s]`, metricTitle(data.metrics[metric.list.selectedIndex]).replaceAll("_", " ")), config);
      const absent = data.points.filter((p) => p.group === scene.list.selectedIndex && y(p) === null).length;
      status(`${points.length} points, ${best.length} on the front.` + (absent ? ` ${absent} have no such error.` : ""));
      if (!div.bound) bind();
    };
    const status = (text) => { document.getElementById("plot-status").textContent = text; };
    const bind = () => {
      div.bound = true;
      div.on("plotly_click", (event) => { if (event.points[0].customdata) location.hash = event.points[0].customdata; });
    };
    div.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      if (step && shown.length) {
        event.preventDefault();
        at = at < 0 ? (step > 0 ? 0 : shown.length - 1) : (at + step + shown.length) % shown.length;
        Plotly.Fx.hover(div, [{ curveNumber: shown[at].curve, pointNumber: shown[at].index }]);
        status(`Point ${at + 1} of ${shown.length}: ${label(shown[at].p)}`);
      } else if (event.key === "Enter" && at >= 0) location.hash = shown[at].p.id;
    });
    document.addEventListener("opaline-theme", () => { if (!waiting.has(div)) show(); });
    later(div, show);
  };

  const convergencePlot = (script) => {
    const div = document.getElementById(script.dataset.plot);
    const histories = JSON.parse(script.textContent);
    const longest = Math.max(...histories.map((h) => h.length));
    const show = () => {
      const l = look();
      Plotly.react(div, histories.map((costs, i) => ({
        type: "scatter", mode: "lines+markers", name: `start ${i + 1}`, y: costs, x: costs.map((_, k) => k),
        line: { color: l.series[i % l.series.length], width: 1.5 }, marker: { size: 4 }, hovertemplate: `start ${i + 1}, iteration %{x}: %{y:.6g}<extra></extra>`,
      })), { ...layout("iteration", "cost"), xaxis: { ...axis("iteration", l), type: "linear", minor: {}, dtick: Math.max(1, Math.ceil(longest / 10)) } }, config);
    };
    document.addEventListener("opaline-theme", () => { if (!waiting.has(div)) show(); });
    later(div, show);
  };

  const plot = document.getElementById("error-plot");
  const convergence = [...document.querySelectorAll(".convergence-data")];
  if (typeof Plotly === "undefined") {
    for (const div of document.querySelectorAll(".plot")) note(div, "This program was built without its plotting library; the tables hold the same numbers.");
    return;
  }
  if (plot) errorPlot(plot);
  convergence.forEach(convergencePlot);
})();
