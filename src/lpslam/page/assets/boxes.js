/* Boxes on the canvas, found by where they are: none of ten thousand signs is compared with all others. */
const CELL = 48;  // pixels to a side

const overlaps = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];

class Boxes {
  cells = new Map();
  all = [];

  /* `item.box`: left, top, right, bottom. What is wider than any canvas costs no more than a canvas. */
  add(item) {
    this.all.push(item);
    this.walk(item.box, key => {
      const here = this.cells.get(key);
      if (here) here.push(item); else this.cells.set(key, [item]);
    });
  }

  /* Whether a box lies on one of these. */
  meets(box) {
    return this.walk(box, key => {
      const here = this.cells.get(key);
      return here !== undefined && here.some(item => overlaps(item.box, box));
    });
  }

  walk([left, top, right, bottom], each) {
    const last = Math.min(Math.floor(right / CELL), 200), lowest = Math.min(Math.floor(bottom / CELL), 200);
    for (let x = Math.max(Math.floor(left / CELL), -10); x <= last; x++) for (let y = Math.max(Math.floor(top / CELL), -10); y <= lowest; y++) if (each(x * 1024 + y)) return true;
    return false;
  }

  /* The box nearest to a point, ring by ring of cells: null where there is none that `isMeant` within ten rings. */
  nearest(x, y, isMeant) {
    const column = Math.floor(x / CELL), row = Math.floor(y / CELL);
    let best = null, least = Infinity;
    for (let ring = 0; ring <= 10 && least > ((ring - 1) * CELL) ** 2; ring++) {
      for (let dx = -ring; dx <= ring; dx++) for (let dy = -ring; dy <= ring; dy += Math.abs(dx) === ring || !ring ? 1 : 2 * ring) {
        for (const item of this.cells.get((column + dx) * 1024 + row + dy) || []) {
          const across = clamped(x, item.box[0], item.box[2]) - x, down = clamped(y, item.box[1], item.box[3]) - y, apart = across * across + down * down;
          if (apart < least && isMeant(item)) [best, least] = [item, apart];
        }
      }
    }
    return best;
  }
}
