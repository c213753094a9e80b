"use strict";
// The clock of a page: the position of all runs in their motion.

const PLAY_SECONDS = 8; // duration of the whole motion at an even pace, as in videos

/** The sample, and the fraction towards the next, at which an ascending list reaches a value. */
function findPlace(list, value) {
  let low = 0, high = list.length - 1;
  if (value >= list[high]) return { sample: high, share: 0 };
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle;
    else high = middle;
  }
  const step = list[high] - list[low];
  return { sample: low, share: step > 0 ? Math.max(0, (value - list[low]) / step) : 0 };
}

class Player {
  /** Calls onMove() when the position has changed, or playing has begun or ended. */
  constructor(runs, onMove) {
    this.runs = runs;
    this.onMove = onMove;
    this.position = 0; // 0 to 1
    this.isPlaying = false;
    this.isEven = true; // equal motion in equal time, else simulated time
    this.speed = 1;
    this.endTime = Math.max(...runs.map((run) => run.times[run.times.length - 1]));
  }

  get seconds() {
    return (this.isEven ? PLAY_SECONDS : this.endTime) / this.speed;
  }

  placeOf(run) {
    if (this.isEven) return findPlace(run.progress, this.position);
    return findPlace(run.times, this.position * this.endTime);
  }

  /** The position of a run: simulated seconds, and the fraction of its motion. */
  whereOf(run) {
    const { sample, share } = this.placeOf(run);
    const next = Math.min(sample + 1, run.times.length - 1);
    const between = (list) => list[sample] + share * (list[next] - list[sample]);
    return { sample, share, time: between(run.times), progress: between(run.progress) };
  }

  seek(position) {
    this.position = Math.max(0, Math.min(1, position));
    this.onMove();
  }

  /** Moves by this number of samples of the first run. */
  step(count) {
    const run = this.runs[0];
    const list = this.isEven ? run.progress : run.times;
    const { sample, share } = this.placeOf(run);
    const from = count < 0 && share > 0 ? sample + 1 : sample;
    const requested = Math.max(0, Math.min(list.length - 1, from + count));
    this.pause();
    this.seek(list[requested] / (this.isEven ? 1 : this.endTime || 1));
  }

  setPace(isEven) {
    const { time, progress } = this.whereOf(this.runs[0]);
    this.isEven = isEven;
    this.seek(isEven ? progress : time / (this.endTime || 1));
  }

  play() {
    if (this.position >= 1) this.position = 0;
    this.isPlaying = true;
    this.last = null;
    this.onMove();
  }

  pause() {
    this.isPlaying = false;
    this.onMove();
  }

  toggle() {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  /** Call it for each picture, with the time in milliseconds. */
  tick(now) {
    if (!this.isPlaying) return;
    if (this.last !== null) this.position += (now - this.last) / 1000 / this.seconds;
    this.last = now;
    if (this.position >= 1) {
      this.position = 1;
      this.isPlaying = false;
    }
    this.onMove();
  }
}
