// Samples of one drive, the last two minutes of its telemetry or a capture: a ring of columns, thinned out for drawing
// without losing peaks.

const CAPACITY = 1 << 17;
const GAP_S = 0.05; // without a sample for so long, a line is interrupted

export class History {
  constructor(columns, { capacity = CAPACITY, gap = GAP_S } = {}) {
    this.names = columns;
    this.capacity = capacity; // a power of two
    this.gap = gap;
    this.time = new Float64Array(capacity);
    this.columns = Object.fromEntries(columns.map((name) => [name, new Float32Array(capacity)]));
    this.index = { time: columns.indexOf("t_ns"), sequence: columns.indexOf("sequence") };
    this.clear();
  }

  clear() {
    this.begin = 0; // absolute numbers of the oldest sample and of the next one
    this.end = 0;
    this.sequence = null;
    this.missed = 0; // samples that did not reach this page
    this.received = 0;
  }

  // A frozen copy, for a picture that stands still.
  copy() {
    const other = Object.create(History.prototype);
    Object.assign(other, this, { time: this.time.slice() });
    other.columns = Object.fromEntries(this.names.map((name) => [name, this.columns[name].slice()]));
    return other;
  }

  append({ rows, values }) {
    const times = values.subarray(this.index.time * rows, (this.index.time + 1) * rows);
    if (this.end > this.begin && times[0] * 1e-9 < this.lastTime()) this.clear(); // a drive with another clock
    const first = this.end;
    for (let row = 0; row < rows; row++) this.time[(first + row) & (this.capacity - 1)] = times[row] * 1e-9;
    this.names.forEach((name, column) => {
      const target = this.columns[name];
      for (let row = 0; row < rows; row++) target[(first + row) & (this.capacity - 1)] = values[column * rows + row];
    });
    this.count(values.subarray(this.index.sequence * rows, (this.index.sequence + 1) * rows));
    this.end += rows;
    this.received += rows;
    this.begin = Math.max(this.begin, this.end - this.capacity);
  }

  count(sequences) {
    for (const sequence of sequences) {
      if (this.sequence !== null && sequence > this.sequence) this.missed += sequence - this.sequence - 1;
      this.sequence = sequence;
    }
  }

  get isEmpty() {
    return this.end === this.begin;
  }

  timeAt(number) {
    return this.time[number & (this.capacity - 1)];
  }

  lastTime() {
    return this.timeAt(this.end - 1);
  }

  value(name, number) {
    return this.columns[name][number & (this.capacity - 1)];
  }

  last(name) {
    return this.isEmpty ? NaN : this.value(name, this.end - 1);
  }

  // The number of the first sample at or after the time.
  find(time) {
    let low = this.begin;
    let high = this.end;
    while (low < high) {
      const middle = Math.floor((low + high) / 2);
      if (this.timeAt(middle) < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // The sample nearest to the time; null outside of what is kept.
  nearest(time) {
    if (this.isEmpty || time < this.timeAt(this.begin) - this.gap || time > this.lastTime() + this.gap) return null;
    const after = Math.min(this.find(time), this.end - 1);
    const before = Math.max(after - 1, this.begin);
    return time - this.timeAt(before) < this.timeAt(after) - time ? before : after;
  }

  // Mean, smallest and largest value between two times.
  summary(name, from, to) {
    let [sum, count, low, high] = [0, 0, Infinity, -Infinity];
    for (let number = this.find(from), end = this.find(to); number < end; number++) {
      const value = this.value(name, number);
      sum += value;
      count += 1;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
    return { mean: sum / count, low, high, count };
  }

  // Columns for drawing: times relative to `origin`, then a column for each entry of `wanted` ({name, keep}). Where there
  // are more samples than places, each place has two points: the extremes in their order, or with keep "min" or "max"
  // that one twice.
  thinned(wanted, from, to, origin, places) {
    const begin = Math.max(this.find(from) - 1, this.begin);
    const end = Math.min(this.find(to) + 1, this.end);
    const rows = { x: [], ys: wanted.map(() => []) };
    const width = (to - from) / places;
    const isRaw = end - begin <= 2 * places;
    let last = null;
    for (let number = begin; number < end; ) {
      const time = this.timeAt(number);
      if (last !== null && time - last > Math.max(this.gap, 2 * width)) interrupt(rows, last - origin);
      const place = Math.floor(time / width);
      let stop = number + 1;
      while (!isRaw && stop < end && Math.floor(this.timeAt(stop) / width) === place) stop++;
      if (isRaw) {
        rows.x.push(time - origin);
        wanted.forEach(({ name }, column) => rows.ys[column].push(this.value(name, number)));
      } else {
        rows.x.push((place + 0.25) * width - origin, (place + 0.75) * width - origin);
        wanted.forEach(({ name, keep }, column) => rows.ys[column].push(...this.extremes(name, number, stop, keep)));
      }
      last = this.timeAt(stop - 1);
      number = stop;
    }
    return [rows.x, ...rows.ys];
  }

  extremes(name, begin, end, keep) {
    const column = this.columns[name];
    let low = begin;
    let high = begin;
    for (let number = begin + 1; number < end; number++) {
      const value = column[number & (this.capacity - 1)];
      if (value < column[low & (this.capacity - 1)]) low = number;
      if (value > column[high & (this.capacity - 1)]) high = number;
    }
    const [smallest, largest] = [this.value(name, low), this.value(name, high)];
    if (keep === "min") return [smallest, smallest];
    if (keep === "max") return [largest, largest];
    return low < high ? [smallest, largest] : [largest, smallest];
  }
}

function interrupt(rows, time) {
  rows.x.push(time + 1e-6);
  for (const column of rows.ys) column.push(null);
}
