"use strict";
// The voxels of one volume: decoded, and asked for value, label and place. Data: see README.md.

async function decodeMosaic(image, header) {
  // Tile by tile, since phones limit the size of a canvas.
  await image.decode();
  const [ni, nj, nk] = header.shape;
  const { columns, width, height } = header.tiles;
  const canvas = document.createElement("canvas");
  canvas.width = ni;
  canvas.height = nj;
  const context = canvas.getContext("2d", { willReadFrequently: true });
  const voxels = new Uint8Array(ni * nj * nk);
  for (let k = 0; k < nk; k += 1) {
    const x = (k % columns) * width;
    const y = Math.floor(k / columns) * height;
    context.drawImage(image, x, y, ni, nj, 0, 0, ni, nj);
    const { data } = context.getImageData(0, 0, ni, nj);
    for (let n = 0; n < ni * nj; n += 1) voxels[k * ni * nj + n] = data[4 * n];
  }
  return voxels;
}

function decodeLabels(voxels, step) {
  // Labels stand `step` greys apart, so that noise which a browser adds to a canvas against
  // fingerprinting does not turn one label into another.
  return voxels.map((grey) => Math.round(grey / step));
}

function valueOfGrey(header) {
  // The value that each grey stands for: the inverse of the curve that made the greys.
  const { knots, greys } = header;
  return Float64Array.from({ length: 256 }, (_, grey) => {
    let at = 1;
    while (at < greys.length - 1 && grey > greys[at]) at += 1;
    const share = (grey - greys[at - 1]) / (greys[at] - greys[at - 1]);
    return knots[at - 1] + share * (knots[at] - knots[at - 1]);
  });
}

function transformPoint(matrix, point) {
  return [0, 1, 2].map((r) => matrix[r][3] + point.reduce((sum, n, c) => sum + matrix[r][c] * n, 0));
}

function writePlace(point) {
  // As YAML and JSON take it; no "-0.0".
  return `[${point.map((mm) => (Math.round(mm * 10) / 10 + 0).toFixed(1)).join(", ")}]`;
}

function readPlace(text) {
  // Three numbers, however they are parted; else null.
  const numbers = text.match(/[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?/gi) ?? [];
  return numbers.length === 3 ? numbers.map(Number) : null;
}

class SliceVoxels {
  constructor(header) {
    this.header = header;
    this.shape = header.shape;
    this.strides = [1, header.shape[0], header.shape[0] * header.shape[1]];
    this.values = valueOfGrey(header);
  }

  async decode(grey, labels) {
    const { header } = this;
    this.greys = await decodeMosaic(grey, header);
    this.labels = labels
      ? decodeLabels(await decodeMosaic(labels, header), header.label_step)
      : new Uint8Array(this.greys.length);
  }

  offset(at) {
    return at.reduce((sum, n, axis) => sum + n * this.strides[axis], 0);
  }

  place(at) {
    return transformPoint(this.header.patient_from_index, at);
  }

  voxel(place) {
    // The voxel nearest to a place in the patient, or null outside the volume.
    const at = transformPoint(this.header.index_from_patient, place).map(Math.round);
    return at.every((n, axis) => n >= 0 && n < this.shape[axis]) ? at.map((n) => n + 0) : null;
  }

  describe(at) {
    // Value and label of a voxel, in words; a plain volume has but one value.
    const n = this.offset(at);
    const { labels, plain } = this.header;
    const label = labels[this.labels[n] - 1]?.name ?? "no label";
    const words = [];
    if (!plain) words.push(this.describeValue(this.values[this.greys[n]]));
    if (labels.length) words.push(label);
    return words.join(" · ");
  }

  describeValue(value) {
    const { unit } = this.header;
    const about = Math.abs(value) < 10 ? Number(value.toPrecision(2)) : Math.round(value);
    return unit === "intensity" ? `intensity about ${about}` : `about ${about} ${unit}`;
  }
}
