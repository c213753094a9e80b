"use strict";
// Colours by the measures of each brick, as in render/picture/state_painter.cpp.

/** {name, unit, valueOf(stage, brick), mostOf(run)} of each measure. Without a unit: lengths, metres. */
const MEASURES = {
  displacement: {
    name: "displacement",
    valueOf: (stage, brick) => displacement(stage.start, stage.drawing.poses, brick),
    mostOf: (run) => largestOfRun(run, displacement),
  },
  rotation: {
    name: "rotation", unit: "degrees",
    valueOf: (stage, brick) => rotation(stage.start, stage.drawing.poses, brick),
    mostOf: (run) => largestOfRun(run, rotation),
  },
  error: {
    name: "distance from the target",
    valueOf: (stage, brick) => stage.measured(stage.run.errors, brick),
    mostOf: (run) => run.errors.most,
  },
  gap: {
    name: "joint gap",
    valueOf: (stage, brick) => stage.measured(stage.run.gaps, brick),
    mostOf: (run) => run.gaps.most,
  },
};

/** Distance of a brick from its start, metres. */
function displacement(from, to, brick) {
  const at = 8 * brick;
  return Math.hypot(to[at] - from[at], to[at + 1] - from[at + 1], to[at + 2] - from[at + 2]);
}

/** Rotation angle of a brick from its start, degrees. */
function rotation(from, to, brick) {
  const at = 8 * brick + 4;
  let cosine = 0;
  for (let k = 0; k < 4; ++k) cosine += from[at + k] * to[at + k];
  return (360 / Math.PI) * Math.acos(Math.min(1, Math.abs(cosine)));
}

function largestOfRun(run, measure) {
  const start = new Float32Array(8 * run.bricks.count), poses = start.slice();
  run.poses.write(0, 0, start);
  let most = 0;
  for (let sample = 0; sample < run.times.length; ++sample) {
    run.poses.write(sample, 0, poses);
    for (let brick = 0; brick < run.bricks.count; ++brick) {
      most = Math.max(most, measure(start, poses, brick));
    }
  }
  return most;
}

/** Colours the bricks of all stages by one measure on one scale, or plainly. */
class Colouring {
  constructor(stages) {
    this.stages = stages;
    this.measure = null;
    this.boxes = stages.map((stage) => {
      const box = document.createElement("div");
      box.className = "scale";
      box.hidden = true;
      stage.canvas.after(box);
      return box;
    });
  }

  /** The names for the choice of colours: measures that every run has. */
  get names() {
    const hasErrors = this.stages.every(({ run }) => run.errors);
    return ["plain", ...Object.keys(MEASURES).filter((name) => name !== "error" || hasErrors)];
  }

  /** Selects a measure by name, or "plain". */
  choose(name) {
    this.measure = MEASURES[name] || null;
    for (const box of this.boxes) box.hidden = !this.measure;
    if (!this.measure) return;
    this.most = Math.max(...this.stages.map(({ run }) => this.measure.mostOf(run))) || 1;
    for (const box of this.boxes) {
      box.innerHTML = `<span></span><span class="bar"></span><span class="ends"><span>0</span><span></span></span>`;
      const unit = this.measure.unit ? { name: this.measure.unit, metres: 1 } : this.stages[0].run.unit;
      box.firstChild.textContent = `${this.measure.name}, ${unit.name}`;
      box.querySelector(".ends").lastChild.textContent = numberText(this.most / unit.metres);
    }
  }

  /** Colours the bricks by their stages' current states. */
  paint(style) {
    const stops = style.map.map(([, top]) => `rgb(${top.join(",")})`).join(",");
    for (const bar of this.boxes.map((box) => box.querySelector(".bar")).filter(Boolean)) {
      bar.style.background = `linear-gradient(to right, ${stops})`;
    }
    for (const stage of this.stages) {
      if (this.measure) {
        stage.setStyle({ ...style, edge: style.measure_edge }, style.measure_lights);
      } else {
        stage.setStyle(style, style.lights);
      }
      this.colour(stage, style);
    }
  }

  /** The same if only the state of a stage has changed. */
  colour(stage, style) {
    if (!this.measure) {
      stage.setColours(() => style.brick);
      return;
    }
    const last = style.map.length - 1;
    stage.setColours((brick) => {
      const share = this.measure.valueOf(stage, brick) / this.most;
      return style.map[Math.round(last * Math.max(0, Math.min(1, share)))];
    });
  }
}
