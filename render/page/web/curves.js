"use strict";
// Curves of a run over its motion, each in a small diagram with a moving line at the current state.

const DIAGRAM = { width: 260, height: 84, left: 4, right: 4, top: 6, bottom: 6 };

const svgElement = (name, attributes) => {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};

/** A number with three digits. */
function numberText(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  const text = size >= 1e-3 && size < 1e5
    ? String(Number(value.toPrecision(3))) : value.toExponential(1);
  return text.replace(/-/g, "−");
}

/** One quantity: {name, unit, logarithmic, lines: [{label, values}, ...]}. */
class Diagram {
  constructor(curve, progress, onSeek) {
    this.curve = curve;
    this.progress = progress;
    this.element = document.createElement("figure");
    this.element.className = "curve";
    this.caption = document.createElement("figcaption");
    const name = document.createElement("span");
    name.textContent = curve.unit ? `${curve.name}, ${curve.unit}` : curve.name;
    if (curve.logarithmic) name.textContent += ", logarithmic";
    this.values = curve.lines.map((_, k) => {
      const value = document.createElement("output");
      value.className = `line-${k}`;
      return value;
    });
    this.caption.append(name, ...this.values);
    const frame = document.createElement("div");
    frame.className = "diagram";
    frame.append(this.draw(), ...this.endsOfRange());
    const across = document.createElement("p");
    across.className = "across";
    across.innerHTML = "<span>0%</span><span>share of the motion</span><span>100%</span>";
    this.element.append(this.caption, frame, across);
    this.picture.addEventListener("pointerdown", (event) => {
      const box = this.picture.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * DIAGRAM.width;
      onSeek(Math.max(0, Math.min(1, this.shareOf(x))));
    });
  }

  height(value) {
    return this.curve.logarithmic ? Math.log10(value) : value;
  }

  /** The range of the axis; a constant has a margin on both sides. */
  findRange() {
    const heights = this.curve.lines.flatMap(({ values }) =>
      values.filter((value) => value !== null && (!this.curve.logarithmic || value > 0))
        .map((value) => this.height(value)));
    this.low = Math.min(...heights);
    this.high = Math.max(...heights);
    const valueOf = (level) => (this.curve.logarithmic ? 10 ** level : level);
    this.top = valueOf(this.high);
    this.bottom = valueOf(this.low);
    const least = 1e-9 * Math.max(Math.abs(this.low), Math.abs(this.high), 1e-300);
    if (!(this.high - this.low > least)) {
      const room = 0.5 * Math.abs(this.low) || 1;
      this.low -= room;
      this.high += room;
    }
  }

  x(share) {
    return DIAGRAM.left + share * (DIAGRAM.width - DIAGRAM.left - DIAGRAM.right);
  }

  shareOf(x) {
    return (x - DIAGRAM.left) / (DIAGRAM.width - DIAGRAM.left - DIAGRAM.right);
  }

  y(value) {
    const share = (this.height(value) - this.low) / (this.high - this.low);
    return DIAGRAM.height - DIAGRAM.bottom - share * (DIAGRAM.height - DIAGRAM.top - DIAGRAM.bottom);
  }

  path(values) {
    let text = "", isDrawing = false;
    values.forEach((value, k) => {
      const isShown = value !== null && (!this.curve.logarithmic || value > 0);
      if (isShown) {
        text += `${isDrawing ? "L" : "M"}${this.x(this.progress[k]).toFixed(1)} ${this.y(value).toFixed(1)}`;
      }
      isDrawing = isShown;
    });
    return text;
  }

  /** The values at the upper and the lower border. */
  endsOfRange() {
    return [["high", this.top], ["low", this.bottom]].map(([className, value]) => {
      const end = document.createElement("span");
      end.className = className;
      end.textContent = numberText(value);
      return end;
    });
  }

  draw() {
    this.findRange();
    const { width, height } = DIAGRAM;
    this.picture = svgElement("svg", {
      viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none", "aria-hidden": "true",
    });
    this.curve.lines.forEach(({ values }, k) => {
      this.picture.append(svgElement("path", { class: `line line-${k}`, d: this.path(values) }));
    });
    this.marker = svgElement("line", { class: "marker", y1: 0, y2: height });
    this.picture.append(this.marker);
    return this.picture;
  }

  /** Moves the line to a fraction of the motion, and displays the values there. */
  show(sample, share, progress) {
    const x = this.x(progress).toFixed(2);
    this.marker.setAttribute("x1", x);
    this.marker.setAttribute("x2", x);
    this.curve.lines.forEach(({ label, values }, k) => {
      const from = values[sample], to = values[Math.min(sample + 1, values.length - 1)];
      const isBetween = share > 0 && from !== null && to !== null;
      const text = numberText(isBetween ? from + share * (to - from) : from);
      const isNamed = label.toLowerCase() !== this.curve.name.toLowerCase();
      this.values[k].textContent = isNamed ? `${label} ${text}` : text;
    });
  }
}
