"use strict";
// Bricks as faces: for drawing, and for finding the one under a finger. The outlines are those of
// render/picture/sketch.cpp: each side of a face moves inwards by half of the line's width.

const BOTTOM = 0, TOP = 1, SIDE = 2; // kinds of faces, as their colours are listed

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

/** v turned by the unit quaternion whose x, y, z, w stand at q[at]. */
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

/** A polygon in brick axes with all that its drawing needs. */
class Face {
  constructor(corners, kind, triangles, mostShare) {
    this.corners = corners;
    this.kind = kind;
    this.normal = polygonNormal(corners);
    this.triangles = triangles || corners.slice(2).map((_, k) => [0, k + 1, k + 2]);
    this.inwards = this.directionsInwards();
    this.mostOutline = this.widestOutline(mostShare);
  }

  /** How the corners move when all sides move in by 1 m. */
  directionsInwards() {
    const { corners, normal } = this;
    const count = corners.length;
    const across = corners.map((corner, k) =>
      vec.unit(vec.cross(normal, vec.sub(corners[(k + 1) % count], corner))));
    return corners.map((_, k) => {
      const before = across[(k + count - 1) % count], after = across[k];
      return vec.scale(vec.add(before, after), 1 / (1 + vec.dot(before, after)));
    });
  }

  /** The width at which the shortest side keeps its share of the face, metres. */
  widestOutline(mostShare) {
    const { corners, inwards } = this;
    let widest = Infinity;
    corners.forEach((corner, k) => {
      const next = (k + 1) % corners.length;
      const side = vec.sub(corners[next], corner);
      const shrinking = vec.dot(vec.unit(side), vec.sub(inwards[k], inwards[next]));
      if (shrinking > 0) widest = Math.min(widest, (mostShare * vec.length(side)) / shrinking);
    });
    return widest < Infinity ? widest : 0;
  }
}

/** All bricks of a run. */
class Bricks {
  static async unpack(packed, mostShare) {
    const bottoms = await Polygons.unpack(packed);
    const rises = await unpackArray(packed.rises);
    return new Bricks(bottoms, rises, packed.triangles, mostShare);
  }

  constructor(bottoms, rises, triangles, mostShare) {
    this.count = bottoms.length;
    this.faces = [];
    this.radii = new Float64Array(this.count);
    for (let brick = 0; brick < this.count; ++brick) {
      const bottom = bottoms.polygon(brick);
      const rise = Array.from(rises.subarray(3 * brick, 3 * brick + 3));
      const top = bottom.map((corner) => vec.add(corner, rise));
      this.faces.push(Bricks.facesOf(bottom, top, triangles[brick], mostShare));
      this.radii[brick] = Math.max(...[...bottom, ...top].map(vec.length));
    }
  }

  static facesOf(bottom, top, triangles, mostShare) {
    const last = bottom.length - 1;
    const below = triangles && triangles.map(([a, b, c]) => [last - c, last - b, last - a]);
    const faces = [
      new Face([...bottom].reverse(), BOTTOM, below, mostShare),
      new Face(top, TOP, triangles, mostShare),
    ];
    bottom.forEach((corner, k) => {
      const next = (k + 1) % bottom.length;
      faces.push(new Face([corner, bottom[next], top[next], top[k]], SIDE, null, mostShare));
    });
    return faces;
  }

  /**
   * The faces as triangles: within each face a ring of corners as far inside as its outline may
   * come. `info` has the brick, the kind, how far inside a corner lies and how far it may, metres.
   */
  triangulate() {
    let vertexCount = 0, indexCount = 0;
    for (const faces of this.faces) {
      for (const face of faces) {
        vertexCount += 2 * face.corners.length;
        indexCount += 3 * face.triangles.length + 6 * face.corners.length;
      }
    }
    const mesh = {
      positions: new Float32Array(3 * vertexCount),
      normals: new Float32Array(3 * vertexCount),
      info: new Float32Array(4 * vertexCount),
      indices: new Uint32Array(indexCount),
      vertexEnd: 0,
      indexEnd: 0,
    };
    this.faces.forEach((faces, brick) => faces.forEach((face) => Bricks.append(mesh, face, brick)));
    return mesh;
  }

  static append(mesh, face, brick) {
    const count = face.corners.length;
    const outer = mesh.vertexEnd, inner = outer + count;
    for (const inset of [0, face.mostOutline]) {
      face.corners.forEach((corner, k) => {
        const at = mesh.vertexEnd++;
        mesh.positions.set(vec.add(corner, face.inwards[k], inset), 3 * at);
        mesh.normals.set(face.normal, 3 * at);
        mesh.info.set([brick, face.kind, inset, face.mostOutline], 4 * at);
      });
    }
    const triangle = (a, b, c) => {
      mesh.indices.set([a, b, c], mesh.indexEnd);
      mesh.indexEnd += 3;
    };
    for (const [a, b, c] of face.triangles) triangle(inner + a, inner + b, inner + c);
    for (let k = 0; k < count; ++k) {
      const next = (k + 1) % count;
      triangle(outer + k, outer + next, inner + next);
      triangle(outer + k, inner + next, inner + k);
    }
  }

  /** The brick that a ray (world axes, unit direction) meets first at these poses; -1 for none. */
  pick(origin, direction, poses) {
    let nearest = Infinity, found = -1;
    for (let brick = 0; brick < this.count; ++brick) {
      const at = 8 * brick;
      const away = [origin[0] - poses[at], origin[1] - poses[at + 1], origin[2] - poses[at + 2]];
      const along = vec.dot(away, direction);
      const squared = vec.dot(away, away) - along * along;
      if (squared > this.radii[brick] * this.radii[brick]) continue;
      const from = turned(away, poses, at + 4, -1), way = turned(direction, poses, at + 4, -1);
      for (const face of this.faces[brick]) {
        const distance = distanceToFace(from, way, face);
        if (distance < nearest) {
          nearest = distance;
          found = brick;
        }
      }
    }
    return found;
  }
}

/** Where a ray meets a face that looks at it, in lengths of its direction; Infinity for nowhere. */
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
