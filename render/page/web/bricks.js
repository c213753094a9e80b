"use strict";
// Bricks as faces, for drawing and for finding the brick under a finger. A shader draws the inner
// half of a line on its face, by the distance from the face's sides. Rims are the outer halves.

const BOTTOM = 0, TOP = 1, SIDE = 2; // kinds of faces, in the order of their colours
const MOST_OUTLINE = 0.35; // width of the outline's ring, as a fraction of the face's shortest side

const vec = {
  add: (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [
    a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  scale: (a, factor) => [factor * a[0], factor * a[1], factor * a[2]],
  length: (a) => Math.hypot(a[0], a[1], a[2]),
  unit: (a) => vec.scale(a, 1 / (vec.length(a) || 1)),
};

/** v rotated by the unit quaternion whose x, y, z, w start at q[at]. */
function turned(v, q, at, sign = 1) {
  const axis = [sign * q[at], sign * q[at + 1], sign * q[at + 2]];
  const inner = vec.add(vec.cross(axis, v), v, q[at + 3]);
  return vec.add(v, vec.cross(axis, inner), 2);
}

/** The outward normal of an anticlockwise polygon, by Newell's method. */
function polygonNormal(corners) {
  let sum = [0, 0, 0];
  corners.forEach((corner, k) => {
    const next = corners[(k + 1) % corners.length];
    sum = vec.add(sum, vec.cross(vec.sub(corner, corners[0]), vec.sub(next, corners[0])));
  });
  return vec.unit(sum);
}

/** A polygon in brick axes with the data for drawing. */
class Face {
  constructor(corners, kind, triangles) {
    this.corners = corners;
    this.kind = kind;
    this.normal = polygonNormal(corners);
    this.triangles = triangles || corners.slice(2).map((_, k) => [0, k + 1, k + 2]);
    this.hasFewSides = !triangles && corners.length <= 4;
    this.across = this.directionsAcross();
    this.inwards = this.directionsInwards();
    this.mostOutline = this.widestOutline();
    this.cornerDistances = this.hasFewSides && corners.map((corner) => this.distances(corner));
  }

  /** Perpendicular to each side, inwards in the face's plane; unit length. */
  directionsAcross() {
    const { corners, normal } = this;
    return corners.map((corner, k) =>
      vec.unit(vec.cross(normal, vec.sub(corners[(k + 1) % corners.length], corner))));
  }

  /** The distances of a point of the face's plane from the lines of its sides. */
  distances(point) {
    return this.across.map((direction, k) => vec.dot(direction, vec.sub(point, this.corners[k])));
  }

  /** Displacements of the corners if all sides move inwards by 1 m. */
  directionsInwards() {
    const { corners, across } = this;
    const count = corners.length;
    return corners.map((_, k) => {
      const before = across[(k + count - 1) % count], after = across[k];
      return vec.scale(vec.add(before, after), 1 / (1 + vec.dot(before, after)));
    });
  }

  /** The largest width for which the shortest side keeps MOST_OUTLINE of the face, metres. */
  widestOutline() {
    const { corners, inwards } = this;
    let widest = Infinity;
    corners.forEach((corner, k) => {
      const next = (k + 1) % corners.length;
      const side = vec.sub(corners[next], corner);
      const shrinking = vec.dot(vec.unit(side), vec.sub(inwards[k], inwards[next]));
      if (shrinking > 0) widest = Math.min(widest, (MOST_OUTLINE * vec.length(side)) / shrinking);
    });
    return widest < Infinity ? widest : 0;
  }
}

const FAR = 1e9; // metres; sides at this distance have no outline

/**
 * Faces as arrays for shaders. `sides` has the distances of a corner from up to four sides of its
 * face. They are linear within the face, so shaders know the distance from each side.
 * Faces with more sides, or notches, have a ring of corners at the largest width of their
 * outline, and only the distance from the nearest side. `info`: brick, kind, widest outline.
 */
class FaceMesh {
  constructor(facesOfBricks) {
    let vertexCount = 0, indexCount = 0, faceCount = 0;
    for (const face of facesOfBricks.flat()) {
      const rings = face.hasFewSides ? 1 : 2;
      vertexCount += rings * face.corners.length;
      indexCount += 3 * face.triangles.length + (rings - 1) * 6 * face.corners.length;
      ++faceCount;
    }
    this.positions = new Float32Array(3 * vertexCount);
    this.normals = new Float32Array(3 * vertexCount);
    this.sides = new Float32Array(4 * vertexCount).fill(FAR);
    this.info = new Float32Array(3 * vertexCount);
    this.indices = new Uint32Array(indexCount);
    this.planes = new Float32Array(4 * faceCount); // normal, and its product with a corner
    this.firstIndices = new Uint32Array(faceCount + 1); // of each face
    this.firstFaces = new Uint32Array(facesOfBricks.length + 1); // of each brick
    this.faceEnd = this.vertexEnd = this.indexEnd = 0;
  }

  append(face, brick) {
    this.planes.set([...face.normal, vec.dot(face.normal, face.corners[0])], 4 * this.faceEnd);
    const first = this.vertexEnd;
    if (face.hasFewSides) {
      face.corners.forEach((corner, k) =>
        this.addVertex(corner, face, brick, face.cornerDistances[k]));
      this.addTriangles(face, first);
    } else {
      this.addRings(face, brick);
      this.addTriangles(face, first + face.corners.length);
    }
    this.firstIndices[++this.faceEnd] = this.indexEnd;
  }

  addVertex(position, face, brick, distances) {
    const at = this.vertexEnd++;
    this.positions.set(position, 3 * at);
    this.normals.set(face.normal, 3 * at);
    this.sides.set(distances, 4 * at);
    this.info.set([brick, face.kind, face.mostOutline], 3 * at);
  }

  addTriangles(face, first) {
    for (const corners of face.triangles) {
      for (const corner of corners) this.indices[this.indexEnd++] = first + corner;
    }
  }

  addRings(face, brick) {
    const count = face.corners.length;
    const outer = this.vertexEnd, inner = outer + count;
    for (const inset of [0, face.mostOutline]) {
      face.corners.forEach((corner, k) =>
        this.addVertex(vec.add(corner, face.inwards[k], inset), face, brick, [inset]));
    }
    for (let k = 0; k < count; ++k) {
      const next = (k + 1) % count;
      this.indices.set([outer + k, outer + next, inner + next, outer + k, inner + next, inner + k],
        this.indexEnd);
      this.indexEnd += 6;
    }
  }

  /**
   * Writes the indices of the faces that face the eye into `out`, and returns their number.
   * `from`: the eye, or the direction towards it in a parallel projection.
   */
  writeVisible(poses, from, isParallel, out) {
    const { planes, firstFaces, firstIndices, indices } = this;
    let end = 0;
    for (let brick = 0, at = 0; brick + 1 < firstFaces.length; ++brick, at += 8) {
      const px = isParallel ? from.x : from.x - poses[at];
      const py = isParallel ? from.y : from.y - poses[at + 1];
      const pz = isParallel ? from.z : from.z - poses[at + 2];
// In brick axes: rotated back by the quaternion.
      const x = -poses[at + 4], y = -poses[at + 5], z = -poses[at + 6], w = poses[at + 7];
      const tx = y * pz - z * py + w * px, ty = z * px - x * pz + w * py, tz = x * py - y * px + w * pz;
      const ex = px + 2 * (y * tz - z * ty), ey = py + 2 * (z * tx - x * tz), ez = pz + 2 * (x * ty - y * tx);
      for (let face = firstFaces[brick]; face < firstFaces[brick + 1]; ++face) {
        const p = 4 * face;
        const height = planes[p] * ex + planes[p + 1] * ey + planes[p + 2] * ez;
        if (height <= (isParallel ? 0 : planes[p + 3])) continue;
        for (let k = firstIndices[face]; k < firstIndices[face + 1]; ++k) out[end++] = indices[k];
      }
    }
    return end;
  }
}

/** All bricks of a run. */
class Bricks {
  static async unpack(packed) {
    const bottoms = await Polygons.unpack(packed);
    const rises = await unpackArray(packed.rises);
    return new Bricks(bottoms, rises, packed.triangles);
  }

  constructor(bottoms, rises, triangles) {
    this.count = bottoms.length;
    this.faces = [];
    this.radii = new Float64Array(this.count);
    const shapes = new Map(); // bricks of one shape share their faces
    for (let brick = 0; brick < this.count; ++brick) {
      const bottom = bottoms.polygon(brick);
      const rise = Array.from(rises.subarray(3 * brick, 3 * brick + 3));
      const key = `${bottom.join(" ")} ${rise.join(" ")}`;
      if (!shapes.has(key)) {
        const top = bottom.map((corner) => vec.add(corner, rise));
        shapes.set(key, {
          faces: Bricks.facesOf(bottom, top, triangles[brick]),
          radius: Math.max(...[...bottom, ...top].map(vec.length)),
        });
      }
      const { faces, radius } = shapes.get(key);
      this.faces.push(faces);
      this.radii[brick] = radius;
    }
  }

  static facesOf(bottom, top, triangles) {
    const last = bottom.length - 1;
    const below = triangles && triangles.map(([a, b, c]) => [last - c, last - b, last - a]);
    const faces = [
      new Face([...bottom].reverse(), BOTTOM, below),
      new Face(top, TOP, triangles),
    ];
    bottom.forEach((corner, k) => {
      const next = (k + 1) % bottom.length;
      faces.push(new Face([corner, bottom[next], top[next], top[k]], SIDE, null));
    });
    return faces;
  }

  /** All faces as triangles, with their planes, for the test whether a face faces away. */
  triangulate() {
    const mesh = new FaceMesh(this.faces);
    this.faces.forEach((faces, brick) => {
      mesh.firstFaces[brick + 1] = mesh.firstFaces[brick] + faces.length;
      for (const face of faces) mesh.append(face, brick);
    });
    return mesh;
  }

  /** A ribbon along each side of each face, to be widened outwards: its ends, position on it. */
  rims() {
    const positions = [], others = [], normals = [], spots = [], bricks = [];
    this.faces.forEach((faces, brick) => {
      for (const { corners, normal } of faces) {
        corners.forEach((from, k) => {
          const to = corners[(k + 1) % corners.length];
          for (const spot of QUAD) {
            positions.push(...(spot[0] < 0 ? from : to));
            others.push(...(spot[0] < 0 ? to : from));
            normals.push(...normal);
            spots.push(...spot);
            bricks.push(brick, 0, 0);
          }
        });
      }
    });
    return {
      position: [new Float32Array(positions), 3], other: [new Float32Array(others), 3],
      faceNormal: [new Float32Array(normals), 3], spot: [new Float32Array(spots), 2],
      info: [new Float32Array(bricks), 3],
    };
  }

  /** The brick that a ray (world axes, unit direction) hits first at these poses; -1 for none. */
  pick(origin, direction, poses) {
    let nearest = Infinity, found = -1;
    for (let brick = 0; brick < this.count; ++brick) {
      const at = 8 * brick;
      const away = [origin[0] - poses[at], origin[1] - poses[at + 1], origin[2] - poses[at + 2]];
      const along = vec.dot(away, direction);
      const squared = vec.dot(away, away) - along * along;
      if (squared > this.radii[brick] * this.radii[brick]) continue;
      const from = turned(away, poses, at + 4, -1), heading = turned(direction, poses, at + 4, -1);
      for (const face of this.faces[brick]) {
        const distance = distanceToFace(from, heading, face);
        // The first of several faces in one plane is visible, as in pictures.
        if (distance < nearest - 1e-6 * this.radii[brick]) {
          nearest = distance;
          found = brick;
        }
      }
    }
    return found;
  }
}

/** Distance at which a ray hits a face from outside, in lengths of its direction, or Infinity. */
function distanceToFace(origin, direction, face) {
  const facing = vec.dot(direction, face.normal);
  if (facing >= 0) return Infinity;
  const distance = vec.dot(vec.sub(face.corners[0], origin), face.normal) / facing;
  if (distance < 0) return Infinity;
  const point = vec.add(origin, direction, distance);
  const isInside = face.triangles.some((triangle) =>
    triangle.every((corner, k) => {
      const a = face.corners[corner], b = face.corners[triangle[(k + 1) % 3]];
      return vec.dot(vec.cross(vec.sub(b, a), vec.sub(point, a)), face.normal) >= 0;
    }));
  return isInside ? distance : Infinity;
}
