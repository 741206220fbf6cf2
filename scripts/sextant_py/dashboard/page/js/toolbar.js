// Pause, time window, zoom and cursors.

import { element, setText } from "./format.js";
import { WINDOWS_S } from "./view.js";

export function connectToolbar(view, history) {
  const [pause, unzoom, cursors, choice] = ["pause", "unzoom", "cursors", "window"].map((id) => document.getElementById(id));
  choice.append(...WINDOWS_S.map((seconds) => element("option", { value: seconds }, `${seconds} s`)));
  choice.value = view.seconds;
  pause.addEventListener("click", () => {
    if (view.isPaused) view.resume();
    else if (history()) view.pause(history());
  });
  choice.addEventListener("change", () => view.setWindow(Number(choice.value)));
  unzoom.addEventListener("click", () => view.unzoom());
  cursors.addEventListener("click", () => {
    view.hasCursors = !view.hasCursors;
    view.changed();
  });
  document.addEventListener("keydown", (event) => {
    const isTyping = event.target.closest?.("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey;
    if (event.key === "p" && !isTyping) pause.click();
  });
  return {
    show() {
      pause.setAttribute("aria-pressed", view.isPaused);
      setText(pause, view.isPaused ? "Resume" : "Pause");
      pause.title = "Key p";
      unzoom.disabled = view.zoom === null;
      cursors.setAttribute("aria-pressed", view.hasCursors);
    },
  };
}
