"use strict";
// Unpacks what render/page/page.cpp packs.

const ARRAY_TYPES = { f32: Float32Array, f64: Float64Array, i32: Int32Array, u16: Uint16Array, u8: Uint8Array };

/** Decodes base 64. */
function bytesOfText(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < bytes.length; ++k) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

/** Decompresses zlib. */
async function inflate(bytes) {
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

/** Decodes {type, count, data} into a typed array. */
async function unpackArray({ type, count, data }) {
  const planes = await inflate(bytesOfText(data));
  const Type = ARRAY_TYPES[type];
  const width = Type.BYTES_PER_ELEMENT;
  if (width === 1) return planes;
  const bytes = new Uint8Array(planes.length);
  for (let plane = 0; plane < width; ++plane) {
    const begin = plane * count;
    for (let k = 0; k < count; ++k) bytes[k * width + plane] = planes[begin + k];
  }
  return new Type(bytes.buffer);
}

/** Decodes entries from their zigzag second differences along the samples. */
function sumDifferences(differences, stride) {
  const entries = new Int32Array(differences.length);
  for (let k = 0; k < entries.length; ++k) {
    const last = k >= stride ? entries[k - stride] : 0;
    const lastButOne = k >= 2 * stride ? entries[k - 2 * stride] : 0;
    entries[k] = ((differences[k] >>> 1) ^ -(differences[k] & 1)) + 2 * last - lastButOne;
  }
  return entries;
}

/** The poses of all bricks in all samples of a run. */
class Poses {
  static async unpack(packed, brickCount) {
    const stored = await unpackArray(packed.entries);
    const entries = packed.exact ? stored : sumDifferences(stored, 7 * brickCount);
    return new Poses(packed, entries, brickCount);
  }

  constructor(packed, entries, brickCount) {
    this.entries = entries; // samples x (x, y, z, qw, qx, qy, qz) x bricks
    this.brickCount = brickCount;
    this.origin = packed.origin;
    this.positionStep = packed.position_step;
    this.rotationStep = packed.rotation_step;
  }

  /**
   * Writes the poses at a fraction between a sample and the next into `out`, 8 numbers per brick:
   * x, y, z, 0, then the unit quaternion's x, y, z, w. Positions are interpolated linearly,
   * rotations by the normalised mean of the quaternions, which are near each other.
   */
  write(sample, share, out) {
    const { entries, brickCount } = this;
    const first = 7 * brickCount * sample;
    const next = share > 0 ? first + 7 * brickCount : first;
    const part = (index, brick) => {
      const from = entries[first + index * brickCount + brick];
      return from + share * (entries[next + index * brickCount + brick] - from);
    };
    for (let brick = 0, at = 0; brick < brickCount; ++brick, at += 8) {
      for (let axis = 0; axis < 3; ++axis) {
        out[at + axis] = this.origin[axis] + this.positionStep * part(axis, brick);
      }
      const w = part(3, brick), x = part(4, brick), y = part(5, brick), z = part(6, brick);
      const norm = 1 / Math.sqrt(w * w + x * x + y * y + z * z);
      out[at + 4] = norm * x;
      out[at + 5] = norm * y;
      out[at + 6] = norm * z;
      out[at + 7] = norm * w;
    }
  }
}

/** Values quantised in steps of equal ratios, one per brick and sample. */
class Magnitudes {
  static async unpack(packed) {
    return new Magnitudes(packed, await unpackArray(packed.codes));
  }

  constructor({ least, most }, codes) {
    this.codes = codes;
    this.values = Float64Array.from({ length: 256 }, (_, code) =>
      code === 0 ? 0 : least * Math.pow(most / least, (code - 1) / 254));
    this.most = most;
  }

  at(index) {
    return this.values[this.codes[index]];
  }
}

/** Polygons as lists of corners, 3 numbers each. */
class Polygons {
  static async unpack(packed) {
    return new Polygons(await unpackArray(packed.counts), await unpackArray(packed.corners));
  }

  constructor(counts, corners) {
    this.counts = counts;
    this.corners = corners;
    this.firsts = new Int32Array(counts.length + 1);
    for (let k = 0; k < counts.length; ++k) this.firsts[k + 1] = this.firsts[k] + counts[k];
  }

  get length() {
    return this.counts.length;
  }

  polygon(index) {
    const points = [];
    for (let k = this.firsts[index]; k < this.firsts[index + 1]; ++k) {
      points.push(Array.from(this.corners.subarray(3 * k, 3 * k + 3)));
    }
    return points;
  }
}
