// Curves over time beside the view, drawn on canvases; a click chooses the time.

const INK = "#39424a";
const GRID = "#dde2e6";
const LEFT = 46;
const RIGHT = 8;
const TOP = 8;
const BOTTOM = 18;

/** Round numbers within a range. */
export function ticks(low, high, most) {
  const raw = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
  return found;
}

/** Text of a tick: 0.25, 300k, 1.5M. */
function short(value) {
  const [, letter] = [
    [1e6, "M"],
    [1e4, "k"],
    [0, ""],
  ].find(([least]) => Math.abs(value) >= least);
  const unit = { M: 1e6, k: 1e3 }[letter] ?? 1;
  return `${Number((value / unit).toPrecision(4))}${letter}`;
}

/** A frame with axes, and curves in it. */
export class Plot {
  /** @param {HTMLElement} place */
  constructor(place, height = 110) {
    this.canvas = document.createElement("canvas");
    this.height = height;
    place.append(this.canvas);
  }

  /**
   * Draws curves.
   * @param {{color: string, points: [number, number][]}[]} curves
   * @param {[number, number]} span of the horizontal axis
   * @param {{x: number, color: string}[]} marks vertical lines
   */
  draw(curves, span, marks) {
    const width = this.canvas.parentElement.clientWidth || 280;
    const scale = devicePixelRatio;
    this.canvas.style.width = `${width}px`;
    this.canvas.style.height = `${this.height}px`;
    this.canvas.width = width * scale;
    this.canvas.height = this.height * scale;
    const pen = this.canvas.getContext("2d");
    pen.scale(scale, scale);
    pen.font = "10px system-ui, sans-serif";
    this.span = span;
    this.right = width - RIGHT;
    const [low, high] = extremes(curves);
    const bottom = this.height - BOTTOM;
    const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - TOP);
    this.axes(pen, low, high, y, bottom);
    for (const { color, points } of curves) this.curve(pen, color, points, y);
    for (const mark of marks) {
      line(pen, mark.color, this.x(mark.x), TOP, this.x(mark.x), bottom);
    }
  }

  axes(pen, low, high, y, bottom) {
    pen.fillStyle = INK;
    pen.textAlign = "right";
    for (const tick of ticks(low, high, 4)) {
      line(pen, GRID, LEFT, y(tick), this.right, y(tick));
      pen.fillText(short(tick), LEFT - 5, y(tick) + 3);
    }
    pen.textAlign = "center";
    for (const tick of ticks(...this.span, 5)) {
      line(pen, GRID, this.x(tick), TOP, this.x(tick), bottom);
      pen.fillText(short(tick), this.x(tick), this.height - 5);
    }
  }

  curve(pen, color, points, y) {
    pen.strokeStyle = color;
    pen.lineWidth = 1.4;
    pen.beginPath();
    let isDown = false;
    for (const [at, value] of points) {
      if (!Number.isFinite(value)) isDown = false;
      else if (isDown) pen.lineTo(this.x(at), y(value));
      else pen.moveTo(this.x(at), y(value));
      isDown = Number.isFinite(value);
    }
    pen.stroke();
  }

  /** Horizontal place of a value [pixels]. */
  x(value) {
    const [first, last] = this.span;
    return LEFT + ((value - first) / (last - first || 1)) * (this.right - LEFT);
  }

  /** The value at a place of the page. */
  valueAt(clientX) {
    const [first, last] = this.span;
    const left = this.canvas.getBoundingClientRect().left;
    const share = (clientX - left - LEFT) / (this.right - LEFT);
    return first + Math.min(Math.max(share, 0), 1) * (last - first);
  }
}

function line(pen, color, x0, y0, x1, y1) {
  pen.strokeStyle = color;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

/** Least and greatest value of all curves, apart by more than rounding. */
function extremes(curves) {
  let [low, high] = [Infinity, -Infinity];
  for (const { points } of curves) {
    for (const [, value] of points) {
      if (!Number.isFinite(value)) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  if (low > high) [low, high] = [0, 1];
  const least = Math.max(1e-3, 1e-3 * Math.abs(high));
  if (high - low < least) [low, high] = [low - least, high + least];
  const margin = 0.06 * (high - low);
  return [low - margin, high + margin];
}
