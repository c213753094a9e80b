"use strict";
// Draws a run with three.js by the rules of render/picture: each face has the one
// colour of faceColour(), outlines have the same width in print, lines and dots face the camera.

const POINT = 96 / 72; // of print, in CSS pixels
const TEXELS = 512; // bricks per row of the textures with data of each brick

const SHADER_PARTS = {
  /** Poses of bricks: two texels each, position and quaternion. */
  pose: `
    uniform highp sampler2D poses;
    vec3 turned(vec4 q, vec3 v) { return v + 2.0 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }
    vec4 poseTexel(float brick, int part) {
      int index = int(brick);
      return texelFetch(poses, ivec2(2 * (index % ${TEXELS}) + part, index / ${TEXELS}), 0);
    }
    vec3 placed(float brick, vec3 point) {
      return poseTexel(brick, 0).xyz + turned(poseTexel(brick, 1), point);
    }`,
  light: `
    uniform float ambient;
    uniform vec3 keyDirection, fillDirection;
    uniform float keyStrength, fillStrength;
    vec3 lit(vec3 base, vec3 worldNormal) {
      vec3 normal = mat3(viewMatrix) * worldNormal; // lights move with the camera
      float light = ambient + keyStrength * max(0.0, dot(normal, keyDirection))
                            + fillStrength * max(0.0, dot(normal, fillDirection));
      return min(vec3(1.0), base * light);
    }`,
  /** Towards the eye, not normalised. */
  eye: `
    uniform vec3 eye, backwards;
    uniform bool parallel;
    vec3 towardsEye(vec3 point) { return parallel ? backwards : eye - point; }`,
  flat: `
    uniform vec3 colour;
    void main() { gl_FragColor = vec4(colour, 1.0); }`,
};

const SHADERS = {
  bricks: {
    vertex: `
      ${SHADER_PARTS.pose} ${SHADER_PARTS.light}
      uniform sampler2D colours;
      uniform float chosen;
      uniform vec3 accent;
      attribute vec3 faceNormal;
      attribute vec3 info;
      attribute vec4 sides;
      varying vec3 face;
      varying vec4 distances;
      varying float most;
      void main() {
        int index = int(info.x);
        ivec2 texel = ivec2(3 * (index % ${TEXELS}) + int(info.y), index / ${TEXELS});
        vec3 base = texelFetch(colours, texel, 0).rgb;
        if (info.x == chosen) base = mix(base, accent, 0.6);
        face = lit(base, turned(poseTexel(info.x, 1), faceNormal));
        distances = sides;
        most = info.z;
        gl_Position = projectionMatrix * viewMatrix * vec4(placed(info.x, position), 1.0);
      }`,
    fragment: `
      uniform vec3 edge;
      uniform float outline; // half of a slit's width, pixels
      varying vec3 face;
      varying vec4 distances;
      varying float most;
      void main() {
        vec4 right = dFdx(distances), up = dFdy(distances);
        vec4 pixels = distances / max(sqrt(right * right + up * up), 1e-12);
        vec4 shares = clamp(pixels - outline + 0.5, 0.0, 1.0);
        float share = min(min(shares.x, shares.y), min(shares.z, shares.w));
        // Nothing to smooth inside the ring of a face.
        if (outline <= 0.0 || distances.x >= 0.9999 * most && distances.y > 1e8) share = 1.0;
        gl_FragColor = vec4(mix(edge, face, share), 1.0);
      }`,
  },
  /** The outer halves of lines, behind the faces that continue there. */
  rims: {
    vertex: `
      ${SHADER_PARTS.pose} ${SHADER_PARTS.eye}
      uniform float rim, retreat; // pixels, metres
      uniform vec2 screen;        // half of the picture's sides, pixels
      attribute vec3 other;
      attribute vec3 faceNormal;
      attribute vec2 spot;
      attribute vec3 info;
      vec4 seen(vec3 point) {
        vec3 back = normalize(towardsEye(point));
        return projectionMatrix * viewMatrix * vec4(point - retreat * back, 1.0);
      }
      void main() {
        vec3 here = placed(info.x, position), there = placed(info.x, other);
        vec3 normal = turned(poseTexel(info.x, 1), faceNormal);
        vec4 clip = seen(here), end = seen(there);
        vec2 along = (end.xy / end.w - clip.xy / clip.w) * screen;
        float isSeen = dot(normal, towardsEye(here)) > 0.0 && length(along) > 0.0 ? 1.0 : 0.0;
        along = spot.x < 0.0 ? normalize(along) : -normalize(along);
        vec2 outwards = vec2(along.y, -along.x);
        vec2 shift = spot.x * rim * along + (spot.y > 0.0 ? rim : 0.0) * outwards;
        clip.xy += isSeen * shift / screen * clip.w;
        gl_Position = isSeen > 0.0 ? clip : vec4(2.0, 2.0, 2.0, 1.0);
      }`,
    fragment: SHADER_PARTS.flat,
  },
  shadow: {
    vertex: `
      ${SHADER_PARTS.pose}
      uniform vec3 shadowSource;
      uniform float height;
      attribute vec3 info;
      void main() {
        vec3 point = placed(info.x, position);
        point -= (point.z - height) / shadowSource.z * shadowSource;
        gl_Position = projectionMatrix * viewMatrix * vec4(point, 1.0);
      }`,
    fragment: SHADER_PARTS.flat,
  },
  plate: {
    vertex: `
      void main() { gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0); }`,
    fragment: SHADER_PARTS.flat,
  },
  scenery: {
    vertex: `
      ${SHADER_PARTS.light} ${SHADER_PARTS.eye}
      uniform vec3 colour;
      attribute vec3 faceNormal;
      varying vec3 face;
      void main() {
        float side = dot(faceNormal, towardsEye(position)) > 0.0 ? 1.0 : -1.0;
        face = lit(colour, side * faceNormal);
        gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0);
      }`,
    fragment: `
      varying vec3 face;
      void main() { gl_FragColor = vec4(face, 1.0); }`,
  },
  marks: {
    vertex: `
      ${SHADER_PARTS.pose} ${SHADER_PARTS.eye}
      uniform vec3 upwards;
      uniform float radius, lift;
      attribute vec2 spot;
      attribute float brick;
      varying vec2 fromCentre;
      void main() {
        vec3 mark = placed(brick, position);
        vec3 back = normalize(towardsEye(mark));
        vec3 right = normalize(cross(upwards, back));
        vec3 up = cross(back, right);
        fromCentre = spot;
        vec3 point = mark + radius * (lift * back + spot.x * right + spot.y * up);
        gl_Position = projectionMatrix * viewMatrix * vec4(point, 1.0);
      }`,
    fragment: `
      uniform vec3 colour;
      varying vec2 fromCentre;
      void main() {
        if (dot(fromCentre, fromCentre) > 1.0) discard;
        gl_FragColor = vec4(colour, 1.0);
      }`,
  },
  lines: {
    vertex: `
      ${SHADER_PARTS.eye}
      uniform float width;
      attribute vec3 along;
      attribute vec3 middle;
      attribute vec2 spot;
      void main() {
        vec3 across = normalize(cross(normalize(towardsEye(middle)), along));
        vec3 point = position + 0.5 * width * (spot.x * along + spot.y * across);
        gl_Position = projectionMatrix * viewMatrix * vec4(point, 1.0);
      }`,
    fragment: SHADER_PARTS.flat,
  },
};

const QUAD = [[-1, -1], [1, -1], [1, 1], [-1, 1]];

/** A geometry of these attributes, {name: [array, numbers per vertex]}. */
function makeGeometry(attributes, indices) {
  const geometry = new THREE.BufferGeometry();
  for (const [name, [array, size]] of Object.entries(attributes)) {
    geometry.setAttribute(name, new THREE.BufferAttribute(array, size));
  }
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  return geometry;
}

/** Indices of `count` quads, four vertices each. */
function quadIndices(count) {
  const indices = new Uint32Array(6 * count);
  for (let k = 0; k < count; ++k) indices.set([0, 1, 2, 0, 2, 3].map((i) => 4 * k + i), 6 * k);
  return indices;
}

function markGeometry(joints) {
  const count = joints.bricks.length;
  const points = new Float32Array(12 * count), spots = new Float32Array(8 * count);
  const bricks = new Float32Array(4 * count);
  for (let k = 0; k < count; ++k) {
    QUAD.forEach((spot, corner) => {
      points.set(joints.points.subarray(3 * k, 3 * k + 3), 12 * k + 3 * corner);
      spots.set(spot, 8 * k + 2 * corner);
      bricks[4 * k + corner] = joints.bricks[k];
    });
  }
  return makeGeometry(
    { position: [points, 3], spot: [spots, 2], brick: [bricks, 1] }, quadIndices(count));
}

/** Ribbons along the sides of polygons. */
function lineGeometry(polygons) {
  const positions = [], alongs = [], middles = [], spots = [];
  for (let index = 0; index < polygons.length; ++index) {
    const corners = polygons.polygon(index);
    corners.forEach((from, k) => {
      const to = corners[(k + 1) % corners.length];
      const along = vec.unit(vec.sub(to, from));
      const middle = vec.scale(vec.add(from, to), 0.5);
      for (const spot of QUAD) {
        positions.push(...(spot[0] < 0 ? from : to));
        alongs.push(...along);
        middles.push(...middle);
        spots.push(...spot);
      }
    });
  }
  return makeGeometry({
    position: [new Float32Array(positions), 3],
    along: [new Float32Array(alongs), 3],
    middle: [new Float32Array(middles), 3],
    spot: [new Float32Array(spots), 2],
  }, quadIndices(spots.length / 8));
}

/** Flat polygons, convex, each in one piece. */
function sceneryGeometry(polygons) {
  const positions = [], normals = [], indices = [];
  for (let index = 0; index < polygons.length; ++index) {
    const corners = polygons.polygon(index);
    const first = positions.length / 3;
    const normal = polygonNormal(corners);
    for (const corner of corners) {
      positions.push(...corner);
      normals.push(...normal);
    }
    for (let k = 2; k < corners.length; ++k) indices.push(first, first + k - 1, first + k);
  }
  return makeGeometry({
    position: [new Float32Array(positions), 3],
    faceNormal: [new Float32Array(normals), 3],
  }, new Uint32Array(indices));
}

function plateGeometry({ centre, half_size: half, height }) {
  const positions = QUAD.flatMap(([x, y]) => [centre[0] + half * x, centre[1] + half * y, height]);
  return makeGeometry({ position: [new Float32Array(positions), 3] }, quadIndices(1));
}

const toColour = (bytes) => new THREE.Vector3(...bytes).divideScalar(255);

/** All objects of one run for three.js. */
class Drawing {
  constructor(run) {
    this.run = run;
    this.scene = new THREE.Scene();
    const rows = Math.ceil(run.bricks.count / TEXELS);
    this.poses = new Float32Array(8 * TEXELS * rows);
    this.colours = new Uint8Array(4 * 3 * TEXELS * rows).fill(255);
    this.poseTexture =
      new THREE.DataTexture(this.poses, 2 * TEXELS, rows, THREE.RGBAFormat, THREE.FloatType);
    this.colourTexture = new THREE.DataTexture(this.colours, 3 * TEXELS, rows, THREE.RGBAFormat);
    this.uniforms = this.makeUniforms();
    this.addMeshes();
  }

  /** Shared by all materials, except the colour of objects with one colour. */
  makeUniforms() {
    const vector = () => ({ value: new THREE.Vector3() });
    const number = (value = 0) => ({ value });
    return {
      poses: {value: this.poseTexture},
      colours: {value: this.colourTexture},
      ambient: number(),
      keyDirection: vector(),
      keyStrength: number(),
      fillDirection: vector(),
      fillStrength: number(),
      shadowSource: vector(),
      edge: vector(),
      outline: number(),
      chosen: number(-1),
      accent: vector(),
      eye: vector(),
      backwards: vector(),
      upwards: vector(),
      parallel: {value: false},
      radius: number(),
      lift: number(),
      width: number(),
      rim: number(),
      retreat: number(),
      screen: {value: new THREE.Vector2(1, 1)},
      height: number(this.run.plate ? this.run.plate.height : 0),
    };
  }

  addMeshes() {
    const { run } = this;
    const mesh = (this.faces = run.bricks.triangulate());
    const corners = { position: [mesh.positions, 3], info: [mesh.info, 3] };
    const bricks = makeGeometry(
      { ...corners, faceNormal: [mesh.normals, 3], sides: [mesh.sides, 4] }, mesh.indices.slice());
    bricks.index.setUsage(THREE.DynamicDrawUsage);
    const under = { depthTest: false, depthWrite: false };
    const both = { side: THREE.DoubleSide };
    // In painting order.
    if (run.plate && run.plate.visible) {
      this.plate = this.add("plate", plateGeometry(run.plate), under);
    }
    if (run.plate && run.plate.shadow) {
      this.shadow = this.add("shadow", makeGeometry(corners, mesh.indices), { ...under, ...both });
    }
    this.bricks = this.add("bricks", bricks);
    const rims = run.bricks.rims();
    this.rims = this.add("rims", makeGeometry(rims, quadIndices(rims.spot[0].length / 8)), both);
    if (run.obstacles.length > 0) {
      this.scenery = this.add("scenery", sceneryGeometry(run.obstacles), both);
    }
    this.marks = this.add("marks", markGeometry(run.joints), both);
    this.marks.visible = false;
  }

  add(kind, geometry, options = {}) {
    const material = new THREE.ShaderMaterial({
      vertexShader: SHADERS[kind].vertex,
      fragmentShader: SHADERS[kind].fragment,
      uniforms: { ...this.uniforms, colour: { value: new THREE.Vector3() } },
      depthFunc: THREE.LessDepth, // the first of faces in one plane is visible, as in pictures
      ...options,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
    return mesh;
  }

  /** The target's lines are made when first shown. */
  showLines(visible) {
    if (visible && !this.lines && this.run.target) {
      this.lines = this.add("lines", lineGeometry(this.run.target),
        { side: THREE.DoubleSide, depthTest: false, depthWrite: false });
      this.setStyle(this.style, this.lights);
    }
    if (this.lines) this.lines.visible = visible;
  }

  setStyle(style, lights) {
    this.style = style;
    this.lights = lights;
    const { uniforms } = this;
    uniforms.edge.value = toColour(style.edge);
    uniforms.accent.value = toColour(style.mark);
    uniforms.ambient.value = lights.ambient;
    uniforms.keyDirection.value.set(...lights.key.direction);
    uniforms.keyStrength.value = lights.key.strength;
    uniforms.fillDirection.value.set(...lights.fill.direction);
    uniforms.fillStrength.value = lights.fill.strength;
    uniforms.shadowSource.value.set(...style.shadow_source);
    uniforms.lift.value = style.mark_lift;
    const paint = (mesh, colour) => {
      if (mesh) mesh.material.uniforms.colour.value = toColour(colour);
    };
    paint(this.plate, style.ground);
    paint(this.shadow, style.shadow);
    paint(this.scenery, style.scenery);
    paint(this.rims, style.edge);
    paint(this.marks, style.mark);
    paint(this.lines, style.overlay);
  }

  /** The colours of a brick's bottom, top and sides, bytes. */
  setColours(brick, shades) {
    shades.forEach((shade, kind) => this.colours.set(shade, 4 * (3 * brick + kind)));
  }

  /** `size`: of the picture in CSS pixels, and the number of drawn pixels for each. */
  setCamera(camera, viewpoint, size) {
    const { uniforms, style } = this;
    const height = viewpoint.heightAtCentre();
    const point = POINT * size.ratio; // in drawn pixels
    uniforms.outline.value = 0.5 * style.slit_width * point;
    uniforms.rim.value = style.silhouette_width * point - uniforms.outline.value;
    uniforms.retreat.value = (style.silhouette_width * POINT * height) / size.height;
    uniforms.screen.value.set(size.width, size.height).multiplyScalar(0.5 * size.ratio);
    this.rims.visible = style.slit_width > 0;
    uniforms.width.value =
      Math.max(style.overlay_width, style.thinnest_overlay / size.height) * height;
    uniforms.radius.value = 0.5 * style.mark_size * height;
    uniforms.eye.value.copy(camera.position);
    uniforms.parallel.value = camera.isOrthographicCamera === true;
    camera.getWorldDirection(uniforms.backwards.value).negate();
    uniforms.upwards.value.set(0, 1, 0).applyQuaternion(camera.quaternion);
    if (this.shadow) this.shadow.visible = this.seesPlate(uniforms);
    this.leaveOutHiddenFaces();
  }

  /** Skips faces that face away, about half of all: transforming them costs as much as others. */
  leaveOutHiddenFaces() {
    const { eye, backwards, parallel } = this.uniforms;
    const { geometry } = this.bricks;
    const from = parallel.value ? backwards.value : eye.value;
    const count = this.faces.writeVisible(this.poses, from, parallel.value, geometry.index.array);
    geometry.setDrawRange(0, count);
    geometry.index.updateRange = { offset: 0, count };
    geometry.index.needsUpdate = true;
  }

  seesPlate({ eye, backwards, parallel, height }) {
    return parallel.value ? backwards.value.z > 0 : eye.value.z > height.value;
  }
}
