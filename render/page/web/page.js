"use strict";
// Connects the parts of the page.

const TURN = Math.PI / 24; // per key press, radians
const NEARER = 1.15; // zoom factor per key press
const TAP = 6; // pixels; a shorter movement of a finger or mouse is a tap
const STILL_AFTER = 150; // milliseconds without a change before a fine picture is drawn
const byId = (id) => document.getElementById(id);

/** One run's section: its stage, its text and its curves. */
class Section {
  constructor(element, words, run, curves, onSeek) {
    this.element = element;
    this.run = run;
    this.canvas = element.querySelector("canvas");
    this.tip = document.createElement("div");
    this.tip.className = "tip";
    this.tip.hidden = true;
    element.querySelector(".frame").append(this.tip);
    this.diagrams = curves.map((curve) => new Diagram(curve, run.progress, onSeek));
    words.querySelector(".curves").append(...this.diagrams.map(({ element: figure }) => figure));
  }

  /** Replaces the picture by the moving model, or displays why this fails. */
  open() {
    try {
      this.canvas.hidden = false;
      this.stage = new Stage(this.canvas, this.run);
      this.element.querySelector(".still").hidden = true;
    } catch (error) {
      this.canvas.hidden = true;
      this.element.querySelector(".without").textContent =
        `This browser cannot draw in three dimensions (${error.message}), so here are three states as a picture.`;
    }
  }

  show({ sample, share, progress }) {
    if (this.stage) this.stage.setState(sample, share);
    this.describeChosen();
    for (const diagram of this.diagrams) diagram.show(sample, share, progress);
  }

  /** The text about the selected brick in the current state; empty if none is selected. */
  get words() {
    return this.stage && this.stage.chosen >= 0 ? this.stage.wordsOf(this.stage.chosen) : "";
  }

  /** Writes this text into the label if it is visible. */
  describeChosen() {
    if (!this.tip.hidden) this.tip.textContent = this.words;
  }

  /** Selects a brick, without a label. */
  choose(brick) {
    this.stage.choose(brick);
    this.tip.hidden = true;
  }

  /** Selects a brick and shows its label next to a point of the canvas; -1: none. */
  point(brick, x, y) {
    this.stage.choose(brick);
    this.tip.hidden = brick < 0;
    if (brick < 0) return;
    this.describeChosen();
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { offsetWidth, offsetHeight } = this.tip;
    this.tip.style.left = `${Math.max(4, Math.min(x + 14, width - offsetWidth - 4))}px`;
    this.tip.style.top = `${Math.max(4, Math.min(y + 14, height - offsetHeight - 4))}px`;
  }
}

class Page {
  constructor(data, runs) {
    this.data = data;
    this.player = new Player(runs, () => this.moved());
    const stages = document.querySelectorAll("section.stage");
    const words = document.querySelectorAll("section.words");
    this.sections = runs.map((run, k) =>
      new Section(stages[k], words[k], run, data.runs[k].curves, (share) => this.seekProgress(share)));
    for (const section of this.sections) section.open();
    this.stages = this.sections.map(({ stage }) => stage).filter(Boolean);
    this.colouring = new Colouring(this.stages);
    this.lastChange = 0;
    this.isAwake = false;
    this.setUpTheme();
    this.setUpTransport();
    if (this.stages.length > 0) this.setUpStages();
    window.addEventListener("hashchange", () => this.followLink());
    this.followLink();
    document.addEventListener("keydown", (event) => this.pressed(event));
    this.moved();
  }

  // ---- links and pictures

  /** A link to the moment and the views. */
  get link() {
    const { progress } = this.player.whereOf(this.player.runs[0]);
    return `#at=${progress.toFixed(5)}&view=${this.stages.map((stage) => stage.link).join(";")}`;
  }

  followLink() {
    const words = new URLSearchParams(location.hash.slice(1));
    const at = Number(words.get("at") || NaN);
    if (at >= 0) this.seekProgress(at);
    (words.get("view") || "").split(";").forEach((view, k) => {
      if (view && this.stages[k]) this.stages[k].takeLink(view);
    });
  }

  savePictures() {
    const { progress } = this.player.whereOf(this.player.runs[0]);
    this.stages.forEach((stage, k) => stage.picture((blob) => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      const number = this.stages.length > 1 ? `_${k + 1}` : "";
      link.download = `${stage.run.name}${number}_${(100 * progress).toFixed(1)}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    }));
  }

  // ---- light and dark

  setUpTheme() {
    const prefersDark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    this.setTheme(this.data.theme || (prefersDark ? "dark" : "light"));
    byId("theme").addEventListener("click", () => this.switchTheme());
  }

  switchTheme() {
    this.setTheme(this.theme === "dark" ? "light" : "dark");
  }

  setTheme(theme) {
    this.theme = theme;
    document.documentElement.dataset.theme = theme;
    byId("theme").textContent = theme === "dark" ? "Light" : "Dark";
    this.paint();
  }

  paint() {
    this.colouring.paint(this.data[this.theme]);
  }

  // ---- position in the motion

  setUpTransport() {
    byId("transport").hidden = false;
    byId("play").addEventListener("click", () => this.player.toggle());
    byId("slider").addEventListener("input", (event) => {
      const position = Number(event.target.value);  // before the player moves the slider itself
      this.player.pause();
      this.player.seek(position);
    });
    byId("pace").addEventListener("change", (event) =>
      this.player.setPace(event.target.value === "even"));
    byId("speed").addEventListener("change", (event) => {
      this.player.speed = Number(event.target.value);
    });
  }

  seekProgress(progress) {
    const { player } = this;
    player.pause();
    if (player.isEven) return player.seek(progress);
    const run = player.runs[0];
    const { sample, share } = findPlace(run.progress, progress);
    const next = Math.min(sample + 1, run.times.length - 1);
    const time = run.times[sample] + share * (run.times[next] - run.times[sample]);
    return player.seek(time / (player.endTime || 1));
  }

  moved() {
    const { player } = this;
    for (const section of this.sections) {
      section.show(player.whereOf(section.run));
      if (section.stage && this.colouring.measure) {
        this.colouring.colour(section.stage, this.data[this.theme]);
      }
    }
    const { time, progress } = player.whereOf(player.runs[0]);
    const share = (100 * progress).toFixed(1);
    byId("slider").value = player.position;
    byId("slider").setAttribute("aria-valuetext", `${share} per cent of the motion`);
    byId("where").textContent = `${share}% of the motion, ${time.toFixed(2)} s`;
    byId("play").textContent = player.isPlaying ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", player.isPlaying ? "Pause" : "Play");
    this.describeChosen();
    this.wake();
  }

  /** Describes the selected tile of the first run in its current state. */
  describeChosen() {
    // Otherwise a screen reader would read out every frame.
    byId('status').setAttribute('aria-live', this.player.isPlaying ? 'off' : 'polite');
    byId('status').textContent = this.sections[0].words;
  }

  // ---- the stages

  setUpStages() {
    byId("choices").hidden = false;
    byId("help").hidden = false;
    this.setUpViews();
    this.setUpColours();
    byId("marks").addEventListener("change", (event) => {
      for (const stage of this.stages) {
        stage.drawing.marks.visible = event.target.checked;
        stage.changed();
      }
    });
    byId("lines-choice").hidden = !this.stages.some(({ run }) => run.target);
    byId("lines").addEventListener("change", (event) => {
      for (const stage of this.stages) {
        stage.drawing.showLines(event.target.checked);
        stage.changed();
      }
    });
    byId("save").addEventListener("click", () => this.savePictures());
    for (const section of this.sections) this.setUpPointing(section);
    for (const stage of this.stages) stage.onChange = () => this.wake();
    new ResizeObserver(() => this.resized()).observe(byId("stages"));
    this.resized();
    this.showView(0);
  }

  setUpViews() {
    this.views = this.stages[0].run.views.map(({ name }, index) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.addEventListener("click", () => this.showView(index));
      return button;
    });
    byId("views").append(...this.views);
  }

  setUpColours() {
    const list = byId("colouring");
    list.append(...this.colouring.names.map((name) => new Option(name, name)));
    list.addEventListener("change", () => {
      this.colouring.choose(list.value);
      this.paint();
    });
  }

  showView(index) {
    if (!this.views || !this.views[index]) return;
    for (const stage of this.stages) stage.showView(index);
  }

  setUpPointing(section) {
    const { canvas, stage } = section;
    if (!stage) return;
    const at = (event) => {
      const box = canvas.getBoundingClientRect();
      const brick = stage.brickAt(event.clientX, event.clientY);
      section.point(brick, event.clientX - box.left, event.clientY - box.top);
      this.describeChosen();
    };
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0 && event.pointerType === "mouse") at(event);
    });
    // Not clicks: OrbitControls prevents them for touches.
    let down = null;
    canvas.addEventListener("pointerdown", (event) => { down = event.isPrimary ? event : null; });
    canvas.addEventListener("pointerup", (event) => {
      if (!down) return;
      const moved = Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY);
      down = null;
      if (moved < TAP) at(event);
    });
    canvas.addEventListener("pointerleave", (event) => {
      if (event.pointerType !== "mouse") return;
      section.point(-1);
      this.describeChosen();
    });
  }

  resized() {
    for (const stage of this.stages) stage.resize();
  }

  // ---- keys

  pressed(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target.matches("select, input[type=checkbox], button, summary") &&
        (event.key === " " || event.key === "Enter" || event.key.startsWith("Arrow"))) return;
    const action = this.actionOf(event.key);
    if (!action) return;
    event.preventDefault();
    action();
  }

  actionOf(key) {
    const { player, stages } = this;
    const move = (...by) => () => stages.forEach((stage) => stage.viewpoint.move(...by));
    const actions = {
      " ": () => player.toggle(),
      ArrowLeft: () => player.step(-1), ArrowRight: () => player.step(1),
      Home: () => player.seek(0), End: () => player.seek(1),
      a: move(-TURN, 0), d: move(TURN, 0), w: move(0, TURN), s: move(0, -TURN),
      "+": move(0, 0, NEARER), "=": move(0, 0, NEARER), "-": move(0, 0, 1 / NEARER),
      n: () => this.nextTile(1), p: () => this.nextTile(-1),
      t: () => this.switchTheme(),
    };
    if (/^[1-9]$/.test(key)) return () => this.showView(Number(key) - 1);
    return actions[key.length === 1 ? key.toLowerCase() : key];
  }

  nextTile(step) {
    const [stage] = this.stages;
    if (!stage) return;
    const { count } = stage.run.bricks;
    const next = stage.chosen < 0 ? (step > 0 ? 0 : count - 1) : (stage.chosen + step + count) % count;
    this.sections[0].choose(next);
    this.describeChosen();
  }

  // ---- pictures, drawn only when something changes

  wake() {
    this.lastChange = performance.now();
    if (this.isAwake) return;
    this.isAwake = true;
    requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    this.player.tick(now);
    const isStill = !this.player.isPlaying && performance.now() - this.lastChange > STILL_AFTER;
    for (const stage of this.stages) stage.draw(isStill);
    if (isStill) byId("link").href = this.link;
    this.isAwake = !isStill;
    if (this.isAwake) requestAnimationFrame((next) => this.tick(next));
  }
}

async function openPage() {
  const data = JSON.parse(byId("data").textContent);
  const runs = [];
  for (const run of data.runs) runs.push(await unpackRun(run));
  // For consoles and programs.
  window.kirireel = new Page(data, runs);
}

openPage().catch((error) => {
  for (const place of document.querySelectorAll(".without")) {
    place.textContent =
        `This browser cannot unpack the model (${error.message}); browsers since 2023 can.`;
  }
});
