// The motion of a flight: rows of poses, rotor speeds, goals and values, in order of time.

const POSE = 7; // position x y z [m], quaternion w x y z

/** Rows of numbers of equal width that can grow; the oldest ones go when it is full. */
class Rows {
  constructor(width, capacity) {
    this.width = width;
    this.values = new Float32Array(width * capacity);
  }

  set(row, numbers) {
    this.values.set(numbers, row * this.width);
  }

  drop(count) {
    this.values.copyWithin(0, count * this.width);
  }
}

/** A flight's rows. */
export class Track {
  /**
   * @param {{bodies: number, rotors: number, goals: string[],
   *          series: {name: string, unit: string}[]}} sizes
   * @param {number} capacity most rows
   */
  constructor(sizes, capacity) {
    this.capacity = capacity;
    this.rows = 0;
    this.bodies = sizes.bodies;
    this.goalNames = sizes.goals;
    this.series = sizes.series;
    this.time = new Float64Array(capacity);
    this.poses = new Rows(POSE * sizes.bodies, capacity);
    this.rotors = new Rows(sizes.rotors, capacity); // [rad/s]
    this.angles = new Rows(sizes.rotors, capacity); // turned since the first row [rad]
    this.goals = new Rows(4 * sizes.goals.length, capacity);
    this.values = new Rows(sizes.series.length, capacity);
    this.touching = new Uint8Array(capacity);
  }

  /** A track of a page's data. */
  static of(data, bodies, unpacker) {
    const read = (spec) => (spec === null ? new Float32Array(0) : unpacker.table(spec));
    const time = read(data.time);
    const names = Object.keys(data.goals);
    const sizes = {
      bodies,
      rotors: data.rotor_speed === null ? 0 : data.rotor_speed.columns,
      goals: names,
      series: data.series.map(({ name, unit }) => ({ name, unit })),
    };
    const track = new Track(sizes, time.length);
    const poses = read(data.poses);
    const rotors = read(data.rotor_speed);
    const touching = read(data.touching);
    const goals = names.map((name) => read(data.goals[name]));
    const series = data.series.map((one) => read(one.values));
    const part = (all, width, row) => all.subarray(row * width, (row + 1) * width);
    for (let row = 0; row < time.length; ++row) {
      track.append({
        time: time[row],
        poses: part(poses, POSE * bodies, row),
        rotors: part(rotors, sizes.rotors, row),
        goals: goals.flatMap((goal) => [...part(goal, 4, row)]),
        values: series.map((values) => values[row]),
        touching: touching[row] > 0.5,
      });
    }
    return track;
  }

  /** Adds a row after the last one. */
  append({ time, poses, rotors, goals, values, touching }) {
    if (this.rows === this.capacity) this.dropOldest(Math.ceil(this.capacity / 4));
    const row = this.rows;
    this.time[row] = time;
    this.poses.set(row, poses);
    this.rotors.set(row, rotors);
    this.goals.set(row, goals);
    this.values.set(row, values);
    this.touching[row] = touching ? 1 : 0;
    const span = row > 0 ? time - this.time[row - 1] : 0;
    for (let k = 0; k < this.rotors.width; ++k) {
      const at = row * this.rotors.width + k;
      const turned = row > 0 ? this.angles.values[at - this.rotors.width] : k;
      this.angles.values[at] = turned + span * this.rotors.values[at];
    }
    this.rows = row + 1;
  }

  /** Begins anew. */
  clear() {
    this.rows = 0;
  }

  get duration() {
    return this.rows > 0 ? this.time[this.rows - 1] : 0;
  }

  /** The row before a time and the share of the way to the next one. */
  at(time) {
    let low = 0;
    let high = Math.max(this.rows - 1, 0);
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time[middle] <= time) low = middle;
      else high = middle;
    }
    const span = this.time[high] - this.time[low];
    const share = span > 0 ? Math.min(Math.max((time - this.time[low]) / span, 0), 1) : 0;
    return { row: low, next: high, share };
  }

  /** Writes a body's pose at a place of at() into a vector and a quaternion of three.js. */
  pose(body, { row, next, share }, position, turn) {
    const a = row * this.poses.width + POSE * body;
    const b = next * this.poses.width + POSE * body;
    const p = this.poses.values;
    const mix = (k) => p[a + k] + share * (p[b + k] - p[a + k]);
    position.set(mix(0), mix(1), mix(2));
    turn.set(mix(4), mix(5), mix(6), mix(3)).normalize();
  }

  /** A rotor's angle [rad] and speed [rad/s]. */
  rotor(k, { row, next, share }) {
    const width = this.rotors.width;
    const mix = ({ values }) =>
      values[row * width + k] + share * (values[next * width + k] - values[row * width + k]);
    return { angle: mix(this.angles), speed: mix(this.rotors) };
  }

  /** A goal's position, or null if the flight has none at this time. */
  goal(k, { row, next, share }) {
    const at = share < 1 ? row : next;
    const place = this.goals.values.subarray(at * this.goals.width + 4 * k);
    return Number.isFinite(place[0]) ? place : null;
  }

  /** A value of the series at a time. */
  value(k, { row, next, share }) {
    return this.values.values[(share < 1 ? row : next) * this.values.width + k];
  }

  /** Whether something touches something at this time. */
  touches({ row, next, share }) {
    return this.touching[share < 1 ? row : next] === 1;
  }

  dropOldest(count) {
    this.time.copyWithin(0, count);
    this.touching.copyWithin(0, count);
    for (const rows of [this.poses, this.rotors, this.angles, this.goals, this.values]) {
      rows.drop(count);
    }
    this.rows -= count;
  }
}
