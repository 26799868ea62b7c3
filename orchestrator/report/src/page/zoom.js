// Zooming into a panel: dygraphs in the figure's place, from the points that the page carries.
"use strict";
(() => {
  const root = document.documentElement;
  const PAN = 0.2;
  const ZOOM = 0.7;

  // Steps of an axis into its numbers; see page/trace.rs.
  const unpacked = (axis, differences) => {
    let steps = 0;
    return differences.map((difference) => {
      steps += difference;
      const value = axis.from + steps * axis.step;
      return axis.log ? 10 ** value : value;
    });
  };

  // Series with points of their own in one table: a row for each x, null where a series has none.
  const table = (panel) => {
    const rows = new Map();
    panel.series.forEach((series, nth) => {
      const y = unpacked(panel.y, series.y);
      unpacked(panel.x, series.x).forEach((x, at) => {
        if (!rows.has(x)) rows.set(x, [x, ...panel.series.map(() => null)]);
        rows.get(x)[nth + 1] = y[at];
      });
    });
    return [...rows.values()].sort((one, other) => one[0] - other[0]);
  };

  // Names are unique in dygraphs.
  const names = (panel) => {
    const seen = new Map();
    return panel.series.map(({ name }) => {
      const times = (seen.get(name) ?? 0) + 1;
      seen.set(name, times);
      return times === 1 ? name : `${name} (${times})`;
    });
  };

  // A colour of the style sheet as a canvas needs it.
  const colour = (within, name) => {
    const probe = document.createElement("span");
    probe.style.color = `var(--chart-${name})`;
    within.append(probe);
    const value = getComputedStyle(probe).color;
    probe.remove();
    return value;
  };

  const band = (canvas, plot, panel, series, fill) => {
    const x = unpacked(panel.x, series.x);
    const low = unpacked(panel.y, series.low);
    const high = unpacked(panel.y, series.high);
    canvas.globalAlpha = 0.18;
    canvas.fillStyle = fill;
    canvas.beginPath();
    x.forEach((at, nth) => canvas.lineTo(plot.toDomXCoord(at), plot.toDomYCoord(high[nth])));
    for (let nth = x.length - 1; nth >= 0; nth -= 1) {
      canvas.lineTo(plot.toDomXCoord(x[nth]), plot.toDomYCoord(low[nth]));
    }
    canvas.fill();
    canvas.globalAlpha = 1;
  };

  const guide = (canvas, area, plot, at) => {
    canvas.beginPath();
    if ("y" in at) {
      const y = plot.toDomYCoord(at.y);
      canvas.moveTo(area.x, y);
      canvas.lineTo(area.x + area.w, y);
    } else if ("x" in at) {
      const x = plot.toDomXCoord(at.x);
      canvas.moveTo(x, area.y);
      canvas.lineTo(x, area.y + area.h);
    } else {
      const [[x0, y0], [x1, y1]] = at.line;
      const slope = (y1 - y0) / (x1 - x0);
      for (const x of plot.xAxisRange()) {
        canvas.lineTo(plot.toDomXCoord(x), plot.toDomYCoord(y0 + slope * (x - x0)));
      }
    }
    canvas.stroke();
  };

  const draw = (box, legend, panel) => {
    const labels = names(panel);
    const own = Object.fromEntries(
      panel.series.map((series, nth) => [
        labels[nth],
        {
          color: colour(box, series.role),
          stepPlot: series.mark === "steps",
          drawPoints: series.mark === "dots",
          pointSize: 1.5,
          strokeWidth: series.mark === "dots" ? 0 : 1.5,
          // One is enough to see where one is; the mean of several has jumps of its own.
          showInRangeSelector: nth === 0,
        },
      ]),
    );
    const grid = colour(box, "grid");
    return new Dygraph(box, table(panel), {
      labels: [panel.x.label || "x", ...labels],
      labelsDiv: legend,
      legend: "always",
      xlabel: panel.x.label,
      ylabel: panel.y.label,
      logscale: panel.y.log,
      connectSeparatedPoints: true,
      series: own,
      axes: {
        x: { axisLineColor: grid, gridLineColor: grid, logscale: panel.x.log, drawGrid: false },
        y: { axisLineColor: grid, gridLineColor: grid, axisLabelWidth: 60 },
      },
      highlightCircleSize: 3,
      showRangeSelector: !panel.x.log,
      rangeSelectorHeight: 28,
      rangeSelectorAlpha: 0.4,
      rangeSelectorPlotFillColor: grid,
      rangeSelectorPlotFillGradientColor: "",
      rangeSelectorPlotStrokeColor: colour(box, "text"),
      rangeSelectorBackgroundStrokeColor: grid,
      underlayCallback: (canvas, area, plot) => {
        canvas.save();
        canvas.beginPath();
        canvas.rect(area.x, area.y, area.w, area.h);
        canvas.clip();
        for (const series of panel.series) {
          if (series.low) band(canvas, plot, panel, series, colour(box, series.role));
        }
        canvas.strokeStyle = colour(box, "text");
        canvas.globalAlpha = 0.6;
        canvas.setLineDash([5, 4]);
        for (const { at } of panel.guides) guide(canvas, area, plot, at);
        canvas.restore();
      },
    });
  };

  // Arrows move, + and - zoom, 0 shows all, Escape goes back.
  const steer = (event, plot, close) => {
    if (event.key === "Escape") return close();
    if (event.key === "0") return plot.resetZoom();
    const [from, to] = plot.xAxisRange();
    const moved = { ArrowLeft: -PAN, ArrowRight: PAN }[event.key];
    const scaled = { "+": ZOOM, "=": ZOOM, "-": 1 / ZOOM }[event.key];
    if (moved === undefined && scaled === undefined) return undefined;
    event.preventDefault();
    const centre = (from + to) / 2 + (moved ?? 0) * (to - from);
    const half = ((to - from) / 2) * (scaled ?? 1);
    // Not beyond the first and the last point; a move there keeps its width.
    const [first, last] = plot.xAxisExtremes();
    const left = Math.max(first, Math.min(centre - half, last - 2 * half));
    return plot.updateOptions({ dateWindow: [left, Math.min(last, left + 2 * half)] });
  };

  for (const group of document.querySelectorAll(".zoom")) {
    const still = group.parentElement.querySelector(".paper");
    const buttons = [...group.querySelectorAll("button")];
    let panels = null;
    let open = null;

    const close = () => {
      open?.plot.destroy();
      open?.frame.remove();
      open?.button.focus();
      open = null;
      still.hidden = false;
      for (const button of buttons) button.setAttribute("aria-pressed", "false");
    };

    const show = (button) => {
      close();
      panels ??= JSON.parse(document.getElementById(group.dataset.traces).textContent);
      const panel = panels[Number(button.dataset.panel)];
      const frame = document.createElement("div");
      frame.className = "plot";
      const title = document.createElement("p");
      title.className = "plot-title";
      title.textContent = panel.title;
      const legend = document.createElement("div");
      legend.className = "plot-legend";
      const box = document.createElement("div");
      box.className = "plot-box";
      box.tabIndex = 0;
      box.setAttribute("role", "application");
      box.setAttribute("aria-label", `${panel.title}: arrows move, plus and minus zoom, 0 shows all, Escape goes back`);
      const help = document.createElement("p");
      help.className = "fine";
      help.textContent =
        "Drag to zoom, shift and drag to move, double-click to see all. By keyboard: arrows, + and −, 0; Escape goes back.";
      frame.append(title, legend, box, help);
      still.after(frame);
      still.hidden = true;
      open = { frame, button, plot: draw(box, legend, panel) };
      box.addEventListener("keydown", (event) => steer(event, open.plot, close));
      button.setAttribute("aria-pressed", "true");
      box.focus({ preventScroll: true });
    };

    for (const button of buttons) {
      button.addEventListener("click", () => (open?.button === button ? close() : show(button)));
    }
    root.addEventListener("colours", () => open && show(open.button));
  }
})();
