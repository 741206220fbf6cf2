// The page: what the server sends, by drive, into the views; drawn at most once a frame of the screen.

import { CommandPanel } from "./command.js";
import { CursorPanel } from "./cursors.js";
import { EventList } from "./events.js";
import { FaultPanel } from "./faults.js";
import { element, number, quantity, setText } from "./format.js";
import { HealthView } from "./health.js";
import { History } from "./history.js";
import { Link } from "./link.js";
import { Notices } from "./notices.js";
import { Panel } from "./panel.js";
import { Plane, sectorOf, trailOf } from "./plane.js";
import { Recorder } from "./recorder.js";
import { ScopePanel } from "./scope.js";
import { StateView } from "./state.js";
import { DriveTabs } from "./tabs.js";
import { startTheme } from "./theme.js";
import { connectToolbar } from "./toolbar.js";
import { View } from "./view.js";

const DRAW_MS = 1000 / 30;
const byId = (id) => document.getElementById(id);

class Dashboard {
  constructor() {
    this.hello = null;
    this.status = { problems: [], drives: [] };
    this.histories = new Map();
    this.panels = [];
    this.isDirty = true;
    this.drawnAt = 0;
    this.view = new View(() => this.touch());
    this.link = new Link({
      opened: () => this.opened(),
      closed: () => this.disconnected(),
      message: (message) => this.take(message),
      frame: (frame) => this.takeFrame(frame),
      capture: (capture) => this.scope.takeCapture(capture),
    });
    this.tabs = new DriveTabs(byId("drives"), (drive) => this.watch(drive));
    this.notices = new Notices(byId("notices"));
    this.command = new CommandPanel(this.link);
    this.faults = new FaultPanel(this.link);
    this.plane = new Plane(byId("plane"));
    this.toolbar = connectToolbar(this.view, () => this.history);
    startTheme(byId("theme"), () => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(byId("plots"));
    requestAnimationFrame((now) => this.frame(now));
  }

  get history() {
    return this.histories.get(this.tabs.selected) ?? null;
  }

  get drive() {
    return this.status.drives.find(({ drive_id }) => drive_id === this.tabs.selected) ?? null;
  }

  touch() {
    this.isDirty = true;
  }

  opened() {
    if (this.tabs.selected !== null) this.watch(this.tabs.selected);
    this.scope?.reconnect();
  }

  disconnected() {
    this.command.lost();
    this.faults.show(false);
  }

  takeStanding(standing) {
    this.command.update(standing);
    this.faults.show(Boolean(standing.is_mine && standing.takes_faults));
  }

  watch(drive) {
    if (this.recorder?.isOn && this.recorder.drive !== drive) this.recorder.save();
    this.histories.get(drive)?.clear(); // the server sends what there is of it
    this.link.send({ type: "watch", drive });
    this.view.resume();
    this.scope?.changeDrive();
  }

  take(message) {
    const takers = {
      hello: () => this.greet(message),
      status: () => this.takeStatus(message),
      command: () => this.takeStanding(message),
      refused: () => this.command.refuse(message.text),
      faults: () => this.faults.describe(message.keys),
      fault_reply: () => this.faults.takeReply(message),
      scope: () => this.scope.takeReport(message),
      scope_refused: () => this.scope.refuse(message.text),
      locus: () => this.scope.takeLocus(message),
      capture: () => this.scope.describe(message),
    };
    takers[message.type]?.();
    this.touch();
  }

  greet(hello) {
    const isFirst = this.hello === null;
    this.hello = hello;
    setText(byId("where"), `DDS domain ${hello.domain}`);
    if (!isFirst) return;
    this.state = new StateView(hello.faults);
    this.health = new HealthView(hello.rejections);
    this.events = new EventList(byId("events"));
    this.panels = hello.panels.map((description) => new Panel(description, this.view, "time"));
    byId("plots").append(...this.panels.map((panel) => panel.node));
    this.cursors = new CursorPanel(byId("cursor-panel"), hello.panels, this.view);
    this.recorder = new Recorder(byId("record"), hello.columns);
    byId("record").addEventListener("click", () => {
      if (this.recorder.isOn) this.recorder.save();
      else if (this.tabs.selected !== null) this.recorder.start(this.tabs.selected);
    });
    this.scope = new ScopePanel(byId("scope"), hello.scope, this.link, () => this.touch());
  }

  takeStatus(status) {
    this.status = status;
    this.tabs.show(status.drives, (drive) => this.stateOf(drive));
  }

  takeFrame(frame) {
    if (!this.histories.has(frame.drive)) this.histories.set(frame.drive, new History(this.hello.columns));
    const history = this.histories.get(frame.drive);
    this.recorder.take(frame, history.isEmpty ? null : history.lastTime() * 1e9);
    history.append(frame);
    this.touch();
  }

  // By the newest telemetry where the page gets that of the drive, else by the newest DriveState.
  stateOf(drive) {
    const history = this.histories.get(drive?.drive_id);
    const isWatched = drive?.drive_id === this.tabs.selected;
    if (isWatched && history && !history.isEmpty) return this.hello.states[history.last("state")];
    return drive?.state?.state ?? null;
  }

  rebuild() {
    for (const panel of this.panels) if (panel.plot) panel.build();
    this.scope?.rebuild();
    this.touch();
  }

  resize() {
    for (const panel of this.panels) panel.resize();
    this.scope?.resize();
    this.touch();
  }

  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const isLost = this.link.lostFor() > 0;
    if ((!this.isDirty && !isLost) || now - this.drawnAt < DRAW_MS - 2) return;
    this.isDirty = false;
    this.drawnAt = now;
    this.notices.show(this.link, this.status, this.drive);
    if (this.hello) this.draw();
  }

  draw() {
    const { history, drive, view } = this;
    this.state.show(this.stateOf(drive), drive, history);
    this.health.show(drive?.statistics, drive, history);
    this.events.show(drive?.events ?? []);
    this.toolbar.show();
    this.scope.show();
    const shown = view.frozen ?? history;
    if (!shown || shown.isEmpty) return;
    const origin = shown.lastTime();
    for (const panel of this.panels) panel.draw(shown, origin);
    this.cursors.show(shown, origin);
    this.drawPlane(shown, origin);
  }

  drawPlane(shown, origin) {
    const time = origin + this.view.range()[1];
    const sample = shown.nearest(time);
    if (sample === null) return;
    const locus = this.view.isPaused ? null : this.scope.locus();
    const trail = locus?.trail ?? trailOf(shown, time);
    const { alpha, beta } = trail.at(-1) ?? { alpha: 0, beta: 0 };
    const reported = shown.value("sector", sample); // 0 where the controller uses none
    const sector = locus?.sector ?? (reported || sectorOf(alpha, beta));
    this.plane.draw({ trail, sector, vector: locus?.vector ?? null });
    const entries = [
      ["magnitude", `${quantity(Math.hypot(alpha, beta), "Wb")} Wb`],
      ["angle from phase a", `${number((Math.atan2(beta, alpha) * 180) / Math.PI, 1)}°`],
      [reported ? "sector" : "sector of the angle", sector ? String(sector) : "none"],
      ["voltage vector applied", locus ? locus.vectorText : "with the scope on"],
    ];
    const cells = entries.flatMap(([label, text]) => [element("dt", {}, label), element("dd", {}, text)]);
    byId("plane-values").replaceChildren(...cells);
  }
}

new Dashboard();
