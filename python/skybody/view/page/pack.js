// Arrays of the page: 16-bit numbers between each column's extremes (skybody/view/pack.py).

const MISSING = 65535; // stands for NaN

/** Reads the arrays of a page. */
export class Unpacker {
  /** @param {ArrayBuffer} buffer all arrays, uncompressed */
  constructor(buffer) {
    this.bytes = new Uint8Array(buffer);
  }

  /**
   * An array by its description.
   * @returns {Float32Array} rows x columns, row after row
   */
  table({ at, rows, columns, low, step }) {
    const values = new Float32Array(rows * columns);
    const high = at + rows * columns; // where the high bytes begin
    for (let c = 0; c < columns; ++c) {
      let word = 0;
      for (let r = 0; r < rows; ++r) {
        const k = c * rows + r;
        word = (word + this.bytes[at + k] + 256 * this.bytes[high + k]) & 0xffff;
        values[r * columns + c] = word === MISSING ? NaN : low[c] + step[c] * word;
      }
    }
    return values;
  }
}
