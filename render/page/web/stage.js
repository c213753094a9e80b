"use strict";
// One run on one canvas: its camera, its drawing, and the brick under a finger.

const TILT = 1e-6; // radians; an orbit cannot look straight down, so it stops this much before
const STILL_SCALE = 2; // samples per pixel and direction when nothing moves
const MOST_PIXELS = 12e6; // samples of a still picture
const MOST_FINE = 4000; // bricks; software rendering takes too long to smooth pictures with more

/** The camera of a stage, moved by hand through OrbitControls. */
class Viewpoint {
  constructor(canvas, onChange) {
    this.cameras = {
      parallel: new THREE.OrthographicCamera(-1, 1, 1, -1, 0, 1),
      perspective: new THREE.PerspectiveCamera(20, 1, 0.1, 100),
    };
    for (const camera of Object.values(this.cameras)) camera.up.set(0, 0, 1);
    this.camera = this.cameras.perspective;
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener("change", onChange);
    this.aspect = 1;
    this.ball = new THREE.Sphere(new THREE.Vector3(), 1);
  }

  /** Takes one of a view's fits, see page.h; farther away on a canvas narrower than its picture. */
  show(fit) {
    const centre = new THREE.Vector3(...fit.centre), eye = new THREE.Vector3(...fit.eye);
    const away = eye.distanceTo(centre);
    eye.addScaledVector(new THREE.Vector3(...fit.up), -TILT * away);
    this.camera = fit.orthographic ? this.cameras.parallel : this.cameras.perspective;
    this.takeLens(fit);
    this.camera.position.copy(eye);
    this.camera.zoom = 1;
    this.controls.object = this.camera;
    this.controls.target.copy(centre);
    this.controls.update();
    this.exact = { fit, eye: this.camera.position.clone(), target: centre };
  }

  /** Height of the visible region. */
  takeLens(fit) {
    const narrow = Math.max(1, fit.aspect / this.aspect);
    this.viewHeight = narrow * fit.view_height;
    this.cameras.perspective.fov =
      THREE.Math.radToDeg(2 * Math.atan(narrow * Math.tan(0.5 * fit.field_of_view)));
  }

  /** Takes the fit of the same view for a new shape of the canvas, so everything stays visible. */
  refit(fit) {
    if (this.isUnmoved) return this.show(fit);
    const { camera, controls, exact } = this;
    const away = ({ eye, centre }) => new THREE.Vector3(...eye).distanceTo(new THREE.Vector3(...centre));
    this.takeLens(fit);
    if (camera.isPerspectiveCamera) {
      camera.position.sub(controls.target).multiplyScalar(away(fit) / away(exact.fit))
        .add(controls.target);
    }
    this.exact = { ...exact, fit };
    controls.update();
  }

  /** Whether the user has not moved the camera since it took a view. */
  get isUnmoved() {
    const { exact, camera, controls } = this;
    return Boolean(exact) && camera.zoom === 1 && camera.position.equals(exact.eye) &&
      controls.target.equals(exact.target);
  }

  /** Rotates, in radians, and zooms by a factor. */
  move(azimuth, elevation, nearer = 1) {
    const { camera, controls } = this;
    const offset = camera.position.clone().sub(controls.target);
    const radius = offset.length();
    const around = Math.atan2(offset.y, offset.x) + azimuth;
    const above = Math.asin(offset.z / radius) + elevation;
    const limit = Math.PI / 2 - TILT;
    const bounded = Math.max(-limit, Math.min(limit, above));
    const distance = camera.isOrthographicCamera ? radius : radius / nearer;
    if (camera.isOrthographicCamera) camera.zoom *= nearer;
    camera.position.set(
      distance * Math.cos(bounded) * Math.cos(around),
      distance * Math.cos(bounded) * Math.sin(around),
      distance * Math.sin(bounded)).add(controls.target);
    camera.updateProjectionMatrix();
    controls.update();
  }

  /** Moves eye and target to these places. */
  moveTo([x, y, z, targetX, targetY, targetZ, zoom]) {
    const { camera, controls } = this;
    camera.position.set(x, y, z);
    camera.zoom = zoom;
    camera.updateProjectionMatrix();
    controls.target.set(targetX, targetY, targetZ);
    controls.update();
  }

  /** Height of the picture at the centre, metres, as heightAtCentre() in camera.cpp. */
  heightAtCentre() {
    const { camera } = this;
    if (camera.isOrthographicCamera) return this.viewHeight / camera.zoom;
    const distance = camera.position.distanceTo(this.controls.target);
    return 2 * Math.tan(0.5 * THREE.Math.degToRad(camera.fov)) * distance;
  }

  /**
   * Sets up the lens, the camera that draws, with the whole ball between its near and far planes.
   * It has the exact direction of the view until the user moves it. A flat sheet seen from straight
   * above then has one depth, as in pictures.
   */
  project() {
    const { ball } = this;
    const camera = (this.lens = this.camera.clone());
    if (this.isUnmoved) {
      const { fit, target } = this.exact;
      camera.position.set(...fit.eye);
      camera.up.set(...fit.up);
      camera.lookAt(target);
    }
    const distance = camera.position.distanceTo(ball.center);
    camera.far = distance + ball.radius;
    if (camera.isOrthographicCamera) {
      camera.top = 0.5 * this.viewHeight;
      camera.bottom = -camera.top;
      camera.right = camera.top * this.aspect;
      camera.left = -camera.right;
      camera.near = distance - ball.radius;
    } else {
      camera.aspect = this.aspect;
      camera.near = Math.max(0.002 * distance, distance - ball.radius);
    }
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  /** The ray through a point of the picture, each from -1 to 1. */
  ray(x, y) {
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(x, y), this.lens);
    return caster.ray;
  }
}

/** Unpacks a run's data for stage and curves. */
async function unpackRun(data) {
  const bricks = await Bricks.unpack(data.bricks);
  const { states } = data;
  return {
    name: data.name,
    unit: data.unit,
    views: data.views,
    plate: data.plate,
    bricks,
    times: states.times,
    progress: states.progress,
    poses: await Poses.unpack(states.poses, bricks.count),
    gaps: await Magnitudes.unpack(states.gaps),
    errors: states.errors && (await Magnitudes.unpack(states.errors)),
    target: data.target && (await Polygons.unpack(data.target)),
    obstacles: await Polygons.unpack(data.obstacles),
    joints: {
      bricks: await unpackArray(data.joints.bricks),
      points: await unpackArray(data.joints.points),
    },
  };
}

/** Shows a run on a canvas. Throws if the browser cannot draw in 3-D. */
class Stage {
  constructor(canvas, run) {
    const context = canvas.getContext("webgl2", {
      antialias: run.bricks.count <= MOST_FINE, alpha: false,
    });
    if (!context) throw new Error("no WebGL 2");
    this.canvas = canvas;
    this.run = run;
    this.renderer = new THREE.WebGLRenderer({ canvas, context });
    this.renderer.sortObjects = false;
    this.drawing = new Drawing(run);
    this.viewpoint = new Viewpoint(canvas, () => this.changed());
    this.place = { sample: 0, share: 0 };
    this.isStale = true;
    this.isFine = false;
    this.onChange = () => {};
    this.setState(0, 0);
    this.start = this.drawing.poses.slice();
    this.viewpoint.ball = this.ballOfRun();
    canvas.addEventListener("webglcontextrestored", () => this.changed());
  }

  /** A ball around everything visible in any sample. */
  ballOfRun() {
    const box = new THREE.Box3();
    const out = new Float32Array(8 * this.run.bricks.count);
    const count = this.run.times.length;
    const stride = Math.max(1, Math.floor(count / 20));
    for (let sample = 0; sample < count; sample += stride) {
      this.run.poses.write(sample, 0, out);
      for (let k = 0; k < out.length; k += 8) {
        box.expandByPoint(new THREE.Vector3(out[k], out[k + 1], out[k + 2]));
      }
    }
    box.expandByScalar(2 * Math.max(...this.run.bricks.radii.slice(0, 1000)));
    for (let k = 0; k < this.run.obstacles.corners.length; k += 3) {
      box.expandByPoint(new THREE.Vector3(...this.run.obstacles.corners.subarray(k, k + 3)));
    }
    const ball = box.getBoundingSphere(new THREE.Sphere());
    if (this.run.plate) ball.radius += 1.5 * this.run.plate.half_size;
    return ball;
  }

  changed() {
    this.isStale = true;
    this.isFine = false;
    this.onChange();
  }

  setStyle(style, lights) {
    this.renderer.setClearColor(new THREE.Color(...toColour(style.background).toArray()), 1);
    this.drawing.setStyle(style, lights);
    this.changed();
  }

  /** shadesOf(brick): its colours on the bottom, the top and the sides. */
  setColours(shadesOf) {
    for (let brick = 0; brick < this.run.bricks.count; ++brick) {
      this.drawing.setColours(brick, shadesOf(brick));
    }
    this.drawing.colourTexture.needsUpdate = true;
    this.changed();
  }

  /** Moves to a fraction between a sample and the next. */
  setState(sample, share) {
    this.place = { sample, share };
    this.run.poses.write(sample, share, this.drawing.poses);
    this.drawing.poseTexture.needsUpdate = true;
    this.changed();
  }

  choose(brick) {
    if (this.drawing.uniforms.chosen.value === brick) return;
    this.drawing.uniforms.chosen.value = brick;
    this.changed();
  }

  get chosen() {
    return this.drawing.uniforms.chosen.value;
  }

  showView(index) {
    this.view = this.run.views[index];
    this.viewpoint.show(this.fitOfView());
    this.changed();
  }

  /** The widest picture that fits the canvas. */
  fitOfView() {
    const { fits } = this.view;
    const held = fits.filter((fit) => fit.aspect <= this.viewpoint.aspect * 1.001);
    return held.length > 0 ? held[held.length - 1] : fits[0];
  }

  /** The view for a link: its number, and if the camera was moved also eye, target and zoom. */
  get link() {
    const { camera, controls, isUnmoved } = this.viewpoint;
    const place = [...camera.position.toArray(), ...controls.target.toArray(), camera.zoom];
    const numbers = [this.run.views.indexOf(this.view), ...(isUnmoved ? [] : place)];
    return numbers.map((number) => Number(number.toPrecision(7))).join(",");
  }

  /** Takes a view from a link. Ignores what is not one. */
  takeLink(text) {
    const [index, ...place] = text.split(",").map(Number);
    if (!this.run.views[index]) return;
    this.showView(index);
    if (place.length === 7 && place.every(Number.isFinite)) this.viewpoint.moveTo(place);
  }

  /** The present picture as a PNG file, as fine as a still one. */
  picture(onBlob) {
    // Browsers empty the canvas after each frame.
    this.isStale = true;
    this.isFine = false;
    this.draw(true);
    this.canvas.toBlob(onBlob, "image/png");
  }

  resize() {
    this.viewpoint.aspect = this.canvas.clientWidth / Math.max(1, this.canvas.clientHeight);
    if (this.view) this.viewpoint.refit(this.fitOfView());
    this.changed();
  }

  /** Draws if something has changed; `fine` is smoother and takes longer. */
  draw(fine) {
    const wantsFine = fine && !this.isFine && this.run.bricks.count <= MOST_FINE;
    if (!this.isStale && !wantsFine) return false;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return false;
    const ratio = window.devicePixelRatio || 1;
    const finest = Math.sqrt(MOST_PIXELS / (width * height));
    this.renderer.setPixelRatio(Math.min(ratio * (wantsFine ? STILL_SCALE : 1), finest));
    this.renderer.setSize(width, height, false);
    this.viewpoint.project();
    this.drawing.setCamera(
      this.viewpoint.lens, this.viewpoint, { width, height, ratio: this.renderer.getPixelRatio() });
    this.renderer.render(this.drawing.scene, this.viewpoint.lens);
    this.isStale = false;
    this.isFine = wantsFine;
    return true;
  }

  /** The brick at a point of the page, in its pixels; -1 for none. */
  brickAt(pageX, pageY) {
    const box = this.canvas.getBoundingClientRect();
    const x = (2 * (pageX - box.left)) / box.width - 1;
    const y = 1 - (2 * (pageY - box.top)) / box.height;
    const { origin, direction } = this.viewpoint.ray(x, y);
    return this.run.bricks.pick(origin.toArray(), direction.toArray(), this.drawing.poses);
  }

  /** Text about a brick. */
  wordsOf(brick) {
    const words = [`Tile ${brick}`];
    const { errors, gaps, unit } = this.run;
    if (errors) words.push(`${lengthText(this.measured(errors, brick), unit)} from its target`);
    words.push(`joint gap ${lengthText(this.measured(gaps, brick), unit)}`);
    return words.join(", ");
  }

  /** A brick's measured value in the nearest sample. */
  measured(magnitudes, brick) {
    const { sample, share } = this.place;
    return magnitudes.at((share > 0.5 ? sample + 1 : sample) * this.run.bricks.count + brick);
  }
}

/** A length with two digits, in the unit {name, metres}. */
function lengthText(metres, unit) {
  const length = metres / unit.metres;
  const isPlain = length === 0 || (length >= 1e-3 && length < 1e4);
  const text = isPlain ? Number(length.toPrecision(2)) : length.toExponential(1);
  return `${text} ${unit.name}`.replace("-", "−");
}
