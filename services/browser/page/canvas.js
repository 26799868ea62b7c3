// A canvas as sharp as its screen, the page's colours in it, and the ticks of an axis.

/** The room around a plot, in CSS pixels. */
export const MARGIN = { left: 52, right: 26, top: 10, bottom: 22 };
export const FONT = "11px ui-monospace, 'SFMono-Regular', 'DejaVu Sans Mono', Menlo, monospace";

/** Clears the canvas and gives its context in CSS pixels, with its size and the colours. */
export function sheet(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  const scale = devicePixelRatio;
  const [wide, high] = [Math.round(width * scale), Math.round(height * scale)];
  if (canvas.width !== wide || canvas.height !== high) {
    canvas.width = wide;
    canvas.height = high;
  }
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  context.textBaseline = "middle";
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  return { context, width, height, colour };
}

/** Round values from `least` to `most`, about `wanted` of them, and how to write them. */
export function ticks(least, most, wanted) {
  const span = most - least;
  if (!(span > 0) || !Number.isFinite(span)) {
    return { values: [], text: String };
  }
  const rough = span / Math.max(wanted, 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999) * power;
  const values = [];
  for (let k = Math.ceil(least / step - 1e-9); k * step <= most + step * 1e-9; k += 1) {
    values.push(k * step);
  }
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const plain = Math.max(Math.abs(least), Math.abs(most)) < 1e5 && digits < 5;
  const text = (value) => (plain ? value.toFixed(digits) : value.toExponential(1));
  return { values, text: (value) => text(value).replace("-", "−") };
}

/** The text of a tick centred at `x`; the last has the unit, written beside its number. */
export function tickText(context, axis, value, unit, x, y) {
  const text = axis.text(value);
  context.fillText(text, x, y);
  if (value === axis.values.at(-1)) {
    const half = context.measureText(text).width / 2;
    context.textAlign = "left";
    context.fillText(unit, x + half, y);
    context.textAlign = "center";
  }
}

/** A straight line. */
export function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
