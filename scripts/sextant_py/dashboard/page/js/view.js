// Which part of the time is shown: the newest seconds, or a part of a picture that stands still; and the two cursors.

export const WINDOWS_S = [0.2, 0.5, 1, 2, 5, 10, 30, 60];
const DEFAULT_S = 10;

export class View {
  constructor(changed) {
    this.changed = changed;
    this.seconds = DEFAULT_S;
    this.zoom = null; // [from, to], relative to the origin
    this.frozen = null; // the history of a picture that stands still
    this.hasCursors = false;
    this.trigger = null; // its time, where the picture has one
    this.cursors = [-0.75, -0.25]; // shares of the range that is shown, from its right end
  }

  get isPaused() {
    return this.frozen !== null;
  }

  pause(history) {
    this.frozen = history.copy();
    this.changed();
  }

  resume() {
    this.frozen = null;
    this.zoom = null;
    this.changed();
  }

  setWindow(seconds) {
    this.seconds = seconds;
    this.zoom = null;
    this.changed();
  }

  zoomTo(from, to, history) {
    if (!this.isPaused) this.frozen = history.copy();
    this.zoom = [from, to];
    this.changed();
  }

  unzoom() {
    this.zoom = null;
    this.changed();
  }

  // What is shown, in seconds before the newest sample (negative).
  range() {
    return this.zoom ?? [-this.seconds, 0];
  }

  cursorTimes() {
    const [from, to] = this.range();
    return this.cursors.map((share) => to + share * (to - from));
  }

  setCursor(index, time) {
    const [from, to] = this.range();
    this.cursors[index] = Math.min(Math.max((time - to) / (to - from), -1), 0);
    this.changed();
  }

  // Moves the cursor that is nearer to the time there.
  placeCursor(time) {
    const [a, b] = this.cursorTimes();
    this.setCursor(Math.abs(time - a) <= Math.abs(time - b) ? 0 : 1, time);
  }
}

// The whole of a capture, or a part of it; time zero is the trigger.
export class CaptureView extends View {
  constructor(changed) {
    super(changed);
    this.whole = [-1, 0];
    this.trigger = 0;
  }

  range() {
    return this.zoom ?? this.whole;
  }

  zoomTo(from, to) {
    this.zoom = [from, to];
    this.changed();
  }
}
