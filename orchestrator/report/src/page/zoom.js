// Zooming into a panel: uPlot in the figure's place, from the points that the page carries.
"use strict";
(() => {
  const root = document.documentElement;
  const PAN = 0.2;
  const ZOOM = 0.7;
  const PATHS = { line: uPlot.paths.linear(), steps: uPlot.paths.stepped({ align: 1 }), dots: () => null };

  // A logarithmic axis has logarithms everywhere, and only its texts raise ten to them: thus moving and
  // zooming are the same sums on every axis.
  const placed = (axis, value) => (axis.log ? Math.log10(value) : value);
  const text = (axis, value) =>
    String(axis.log ? Number((10 ** value).toPrecision(4)) : value).replaceAll("-", "−");

  // Steps of an axis into its numbers; see page/trace.rs.
  const unpacked = (axis, differences) => {
    let steps = 0;
    return differences.map((difference) => {
      steps += difference;
      return axis.from + steps * axis.step;
    });
  };

  // Columns over one x, undefined where a series has no point. An x that a series has twice is there twice.
  const table = (panel, columns) => {
    const points = columns.flatMap(({ series, of }, nth) => {
      const y = unpacked(panel.y, series[of]);
      return unpacked(panel.x, series.x).map((x, at) => ({ x, y: y[at], nth: nth + 1 }));
    });
    const rows = [];
    for (const { x, y, nth } of points.sort((one, other) => one.x - other.x)) {
      if (rows.at(-1)?.[0] !== x || rows.at(-1)[nth] !== undefined) rows.push([x]);
      rows.at(-1)[nth] = y;
    }
    return ["x", ...columns].map((_, nth) => rows.map((row) => row[nth]));
  };

  // Ticks of a logarithmic axis: numbers of few digits near even steps of the logarithm.
  const ticks = (_plot, _axis, low, high, found) => {
    const step = found > 1 ? Math.ceil(found) : found;
    const digits = Math.max(1, -Math.floor(Math.log10(step)));
    const first = Math.ceil(low / step);
    const even = Array.from({ length: Math.floor(high / step) - first + 1 }, (_, nth) => (first + nth) * step);
    const near = even.map((at) => Math.log10(Number((10 ** at).toPrecision(digits))));
    return [...new Set(near)].filter((at) => at >= low && at <= high);
  };

  // A colour of the style sheet as a canvas needs it.
  const probe = document.body.appendChild(document.createElement("span"));
  probe.hidden = true;
  const colour = (name) => {
    probe.style.color = `var(--chart-${name})`;
    return getComputedStyle(probe).color;
  };

  const guides = ({ ctx: canvas, bbox: { left, top, width, height }, pxRatio, valToPos }, panel) => {
    const on = (key, value) => valToPos(placed(panel[key], value), key, true);
    const ends = ({ x, y, line }) => {
      if (y !== undefined) return [left, left + width].map((end) => [end, on("y", y)]);
      if (x !== undefined) return [top, top + height].map((end) => [on("x", x), end]);
      const [[x0, y0], [x1, y1]] = line.map(([x, y]) => [on("x", x), on("y", y)]);
      return [left, left + width].map((end) => [end, y0 + ((end - x0) * (y1 - y0)) / (x1 - x0)]);
    };
    canvas.save();
    canvas.beginPath();
    canvas.rect(left, top, width, height);
    canvas.clip();
    canvas.beginPath();
    for (const [from, to] of panel.guides.map(({ at }) => ends(at))) {
      canvas.moveTo(...from);
      canvas.lineTo(...to);
    }
    Object.assign(canvas, { strokeStyle: colour("text"), globalAlpha: 0.6, lineWidth: pxRatio });
    canvas.setLineDash([5 * pxRatio, 4 * pxRatio]);
    canvas.stroke();
    canvas.restore();
  };

  const draw = (box, legend, panel) => {
    // Both ends of every band come first, so that lines lie on top.
    const bands = panel.series.filter(({ low }) => low);
    const columns = [
      ...bands.flatMap((series) => [{ series, of: "high" }, { series, of: "low" }]),
      ...panel.series.map((series) => ({ series, of: "y" })),
    ];
    // y follows what is seen, and the guides if that is all, until someone zooms into y.
    let [isAll, isHeld] = [true, false];
    const levels = panel.guides.flatMap(({ at }) => ("y" in at ? [placed(panel.y, at.y)] : []));
    const follow = ({ scales: { y } }, low, high) => {
      if (low === null) return [y.min, y.max];
      const [least, most] = [Math.min(low, ...(isAll ? levels : [])), Math.max(high, ...(isAll ? levels : []))];
      const room = 0.05 * (most - least || Math.abs(most) || 1);
      return [least - room, most + room];
    };
    // Not beyond the first and the last point; a move there keeps its width.
    const within = ({ data: [x] }, from, to) => {
      const width = Math.min(Math.max(to - from, 8 * panel.x.step), x.at(-1) - x[0] || 1);
      const left = Math.max(x[0], Math.min(from, x.at(-1) - width));
      return [left, left + width];
    };
    const font = `12px ${getComputedStyle(box).fontFamily}`;
    const hair = { stroke: () => colour("grid"), width: 1 };
    const axis = (key, size) => ({
      ...{ label: panel[key].label || null, labelSize: 20, labelFont: font, font, size },
      stroke: () => colour("text"),
      grid: { ...hair, show: key === "y" },
      ticks: { ...hair, size: 5 },
      border: { ...hair, show: true },
      values: (_plot, all) => all.map((value) => text(panel[key], value)),
      ...(panel[key].log ? { splits: ticks } : {}),
    });
    // As many digits as can be told apart at this zoom.
    const value = (key) => ({ scales }, at) => {
      const digits = 3 - Math.floor(Math.log10(scales[key].max - scales[key].min));
      const short = () => Number(at.toFixed(Math.min(Math.max(digits, 0), 9)));
      return at === null || at === undefined ? "" : text(panel[key], panel[key].log ? at : short());
    };
    const drawn = ({ series: { name, role, mark }, of }) => ({
      ...{ label: name, value: value("y"), pxAlign: 0, paths: PATHS[mark], stroke: () => colour(role) },
      ...(of === "y"
        ? { class: `plot-${mark}`, width: mark === "dots" ? 0 : 1.5 }
        : { class: "plot-end", width: 0, alpha: 0.18 }),
      points: { show: mark === "dots" && of === "y", size: 3, width: 0, fill: () => colour(role) },
    });
    const tone = (_plot, nth) => `var(--chart-${columns[nth - 1].series.role})`;
    const room = (_plot, labels) => 16 + 7 * Math.max(2, ...(labels ?? []).map(({ length }) => length));
    const plot = new uPlot({
      width: box.clientWidth,
      height: box.clientHeight,
      padding: [8, 12, 0, 0],
      scales: {
        x: { time: false, range: within },
        y: {
          auto: (_plot, isReset) => {
            [isAll, isHeld] = [isReset, isHeld && !isReset];
            return !isHeld;
          },
          range: follow,
        },
      },
      axes: [axis("x", 32), axis("y", room)],
      series: [{ label: panel.x.label || "x", value: value("x") }, ...columns.map(drawn)],
      bands: bands.map(({ role }, nth) => ({ series: [2 * nth + 1, 2 * nth + 2], fill: () => colour(role) })),
      legend: { mount: (_plot, rows) => legend.append(rows), markers: { width: 0, fill: tone } },
      cursor: {
        y: false,
        hover: { prox: 1e9 },
        points: { size: 7, fill: tone },
        drag: { x: true, y: true, dist: 4, uni: 30 },
        bind: {
          mousedown: (_plot, _over, zoom) => (event) => event.button === 0 && !event.shiftKey && zoom(event),
          click: () => null,
        },
      },
      hooks: {
        drawAxes: [(plot) => guides(plot, panel)],
        setSelect: [({ select, over }) => { isHeld ||= select.height < over.clientHeight; }],
      },
    }, table(panel, columns), box);
    hands(plot, () => isHeld);
    return plot;
  };

  // Shift and drag moves, as a finger does, and two fingers zoom: what was under one stays under it.
  const hands = (plot, isHeld) => {
    const down = new Map();
    const values = ({ offsetX, offsetY }) => [plot.posToVal(offsetX, "x"), plot.posToVal(offsetY, "y")];
    plot.over.addEventListener("pointerdown", (event) => {
      if (event.pointerType === "mouse" && !event.shiftKey) return;
      plot.over.setPointerCapture(event.pointerId);
      down.set(event.pointerId, values(event));
    });
    plot.over.addEventListener("pointermove", (event) => {
      if (!down.has(event.pointerId)) return;
      const { x, y } = plot.scales;
      const [[from, high], [to, low]] = [down.get(event.pointerId), values(event)];
      const other = [...down].find(([id]) => id !== event.pointerId)?.[1][0];
      const moved = (at) => (other === undefined ? at + from - to : other + ((at - other) * (from - other)) / (to - other));
      plot.setScale("x", { min: moved(x.min), max: moved(x.max) });
      if (isHeld()) plot.setScale("y", { min: y.min + high - low, max: y.max + high - low });
    });
    for (const end of ["pointerup", "pointercancel"]) {
      plot.over.addEventListener(end, (event) => down.delete(event.pointerId));
    }
  };

  // Arrows move, + and - zoom, 0 shows all, Escape goes back.
  const steer = (event, plot, close) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return undefined;
    if (event.key === "Escape") return close();
    if (event.key === "0") return plot.setData(plot.data);
    const { min, max } = plot.scales.x;
    const moved = { ArrowLeft: -PAN, ArrowRight: PAN }[event.key];
    const scaled = { "+": ZOOM, "=": ZOOM, "-": 1 / ZOOM }[event.key];
    if (moved === undefined && scaled === undefined) return undefined;
    event.preventDefault();
    const centre = (min + max) / 2 + (moved ?? 0) * (max - min);
    const half = ((max - min) / 2) * (scaled ?? 1);
    return plot.setScale("x", { min: centre - half, max: centre + half });
  };

  const element = (name, content = "", tag = "div") =>
    Object.assign(document.createElement(tag), { className: name, textContent: content });

  for (const group of document.querySelectorAll(".zoom")) {
    const still = group.parentElement.querySelector(".paper");
    const buttons = [...group.querySelectorAll("button")];
    let panels = null;
    let open = null;

    const close = () => {
      open?.watch.disconnect();
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
      const frame = element("plot");
      const legend = element("plot-legend");
      const box = element("plot-box");
      box.tabIndex = 0;
      box.setAttribute("role", "application");
      box.setAttribute("aria-label", `${panel.title}: arrows move, plus and minus zoom, 0 shows all, Escape goes back`);
      const dashed = [...new Set(panel.guides.map(({ name }) => name))].filter(Boolean).join(", ");
      const help =
        "Drag to zoom, shift and drag to move, double-click to see all. By keyboard: arrows, + and −, 0; Escape goes back.";
      frame.append(element("plot-title", panel.title, "p"), legend, box, element("fine", help, "p"));
      still.after(frame);
      still.hidden = true;
      const plot = draw(box, legend, panel);
      if (dashed) legend.append(element("fine", `Dashed: ${dashed}`, "p"));
      const watch = new ResizeObserver(() => {
        if (box.clientWidth) plot.setSize({ width: box.clientWidth, height: box.clientHeight });
      });
      watch.observe(box);
      open = { frame, button, plot, watch };
      box.addEventListener("keydown", (event) => steer(event, plot, close));
      button.setAttribute("aria-pressed", "true");
      box.focus({ preventScroll: true });
    };

    for (const button of buttons) {
      button.addEventListener("click", () => (open?.button === button ? close() : show(button)));
    }
    root.addEventListener("colours", () => open?.plot.redraw(false));
  }
})();
