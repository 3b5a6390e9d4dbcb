// Strokes on one picture: a label for each pixel, and the way back. 0 is unpainted, 1 ground, 2 sky.
export const ERASE = 0, GROUND = 1, SKY = 2;

export class Painting {
  constructor(columns, rows, labels) {
    this.columns = columns;
    this.rows = rows;
    this.labels = labels ?? new Uint8Array(columns * rows);
    this.done = [];
    this.undone = [];
    this.before = null; // all labels as they were when the present stroke began
    this.box = null; // what the present stroke has touched: left, top, right, bottom, the last two outside
  }

  begin() {
    this.before = this.labels.slice();
    this.box = [this.columns, this.rows, 0, 0];
  }

  // All pixels whose centres are no further than the radius from the line; gives the box that was touched.
  line([x0, y0], [x1, y1], radius, label) {
    const left = Math.max(0, Math.floor(Math.min(x0, x1) - radius));
    const top = Math.max(0, Math.floor(Math.min(y0, y1) - radius));
    const right = Math.min(this.columns, Math.ceil(Math.max(x0, x1) + radius));
    const bottom = Math.min(this.rows, Math.ceil(Math.max(y0, y1) + radius));
    const dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy, limit = Math.max(radius, 0.5) ** 2;
    for (let row = top; row < bottom; row++) {
      for (let column = left; column < right; column++) {
        const x = column + 0.5 - x0, y = row + 0.5 - y0;
        const along = squared ? Math.min(1, Math.max(0, (x * dx + y * dy) / squared)) : 0;
        if ((x - along * dx) ** 2 + (y - along * dy) ** 2 <= limit) this.labels[row * this.columns + column] = label;
      }
    }
    if (right <= left || bottom <= top) return null;
    const box = this.box;
    box[0] = Math.min(box[0], left);
    box[1] = Math.min(box[1], top);
    box[2] = Math.max(box[2], right);
    box[3] = Math.max(box[3], bottom);
    return [left, top, right, bottom];
  }

  // Whether the stroke changed anything.
  finish() {
    const before = this.before, box = this.box;
    this.before = null;
    if (box[2] <= box[0] || box[3] <= box[1]) return false;
    const was = this.cut(before, box), is = this.cut(this.labels, box);
    if (was.every((label, i) => label === is[i])) return false;
    this.done.push({ box, was, is });
    this.undone = [];
    return true;
  }

  undo() {
    const stroke = this.done.pop();
    if (!stroke) return null;
    this.undone.push(stroke);
    this.paste(stroke.box, stroke.was);
    return stroke.box;
  }

  redo() {
    const stroke = this.undone.pop();
    if (!stroke) return null;
    this.done.push(stroke);
    this.paste(stroke.box, stroke.is);
    return stroke.box;
  }

  cut(labels, [left, top, right, bottom]) {
    const part = new Uint8Array((right - left) * (bottom - top));
    for (let row = top; row < bottom; row++) {
      const from = row * this.columns;
      part.set(labels.subarray(from + left, from + right), (row - top) * (right - left));
    }
    return part;
  }

  paste([left, top, right, bottom], part) {
    const width = right - left;
    for (let row = top; row < bottom; row++) {
      this.labels.set(part.subarray((row - top) * width, (row - top + 1) * width), row * this.columns + left);
    }
  }

  isEmpty() {
    return this.labels.every(label => label === 0);
  }
}

// A canvas with a colour for each label, given as [r, g, b, a] of labels 0, 1 and 2.
export class Layer {
  constructor(columns, rows, colours) {
    this.canvas = new OffscreenCanvas(columns, rows);
    this.context = this.canvas.getContext("2d");
    this.colours = new Uint32Array(new Uint8Array(colours.flat()).buffer);
  }

  show(labels, box = [0, 0, this.canvas.width, this.canvas.height]) {
    const [left, top, right, bottom] = box, columns = this.canvas.width;
    if (right <= left || bottom <= top) return;
    const image = new ImageData(right - left, bottom - top), pixels = new Uint32Array(image.data.buffer);
    for (let row = top, i = 0; row < bottom; row++) {
      for (let column = left; column < right; column++) pixels[i++] = this.colours[labels[row * columns + column]];
    }
    this.context.putImageData(image, left, top);
  }

  clear() {
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
  }
}

// A circle that is seen on dark and on bright.
export function ring(context, [x, y], radius, colour) {
  for (const [width, style] of [[3.5, "#000a"], [1.5, colour]]) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.lineWidth = width;
    context.strokeStyle = style;
    context.stroke();
  }
}
