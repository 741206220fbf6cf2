// Light and dark: the system's choice, or the one made here, which the browser keeps.

const KEY = "sextant.theme";
const CHOICES = ["system", "light", "dark"];
const SIGNS = { system: "◐", light: "☀", dark: "☾" };
const system = matchMedia("(prefers-color-scheme: dark)");

function kept() {
  try {
    const value = localStorage.getItem(KEY);
    return CHOICES.includes(value) ? value : "system";
  } catch {
    return "system"; // storage that the browser refuses
  }
}

export function startTheme(button, changed) {
  let choice = kept();
  const apply = () => {
    const dark = choice === "dark" || (choice === "system" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    button.textContent = SIGNS[choice];
    const text = choice === "system" ? "as the system" : choice;
    button.setAttribute("aria-label", `Colours: ${text}`);
    button.title = `Colours: ${text}`;
    changed();
  };
  button.addEventListener("click", () => {
    choice = CHOICES[(CHOICES.indexOf(choice) + 1) % CHOICES.length];
    try {
      localStorage.setItem(KEY, choice);
    } catch {
      // it holds until the page is closed
    }
    apply();
  });
  system.addEventListener("change", apply);
  apply();
}
