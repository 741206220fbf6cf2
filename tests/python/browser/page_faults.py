"""What of a page cannot be read: what sticks out sideways, and texts that are too much like what is behind them."""

from playwright.sync_api import Page

LEAST_CONTRAST = 4.5  # of a text, by WCAG 2.2, level AA

# What is wider than the page, or scrolls sideways within it. Code and tables of the documentation may.
SIDEWAYS = """(allowed) => {
  const page = document.documentElement, found = [];
  if (page.scrollWidth > page.clientWidth) found.push(`the page: ${page.scrollWidth} of ${page.clientWidth}`);
  for (const one of document.querySelectorAll("body *")) {
    const style = getComputedStyle(one);
    if (one.clientWidth < 3 || one.scrollWidth <= one.clientWidth + 1 || !one.textContent.trim()) continue;
    if (/auto|scroll|hidden|clip/.test(style.overflowX) && !(allowed && one.matches(allowed)))
      found.push(`<${one.localName} class="${one.getAttribute("class")}">: ${one.scrollWidth} of ${one.clientWidth}`);
  }
  return found;
}"""

# Texts by their colour over the colours behind them. A control that is disabled needs no contrast.
PALE = """(least) => {
  const numbers = (colour) => (colour.match(/[\\d.]+/g) ?? [0, 0, 0, 0]).map(Number);
  const opacity = (colour) => colour[3] ?? 1;
  const over = (top, below) => [0, 1, 2].map((k) => top[k] * opacity(top) + below[k] * (1 - opacity(top)));
  const linear = (share) => (share <= 0.03928 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4);
  const luminance = ([r, g, b]) => 0.2126 * linear(r / 255) + 0.7152 * linear(g / 255) + 0.0722 * linear(b / 255);
  const ancestors = (one) => (one ? [one, ...ancestors(one.parentElement)] : []);
  const behind = (one) => ancestors(one).map((each) => numbers(getComputedStyle(each).backgroundColor))
    .reverse().reduce((below, top) => over(top, below), [255, 255, 255]);
  const found = [], walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim(), one = walker.currentNode.parentElement;
    if (!text || one.closest("script, style, option, [disabled]") || !one.checkVisibility({ visibilityProperty: true }))
      continue;
    const style = getComputedStyle(one), back = behind(one);
    const colour = numbers(one instanceof SVGElement ? style.fill : style.color);
    const share = ancestors(one).reduce((all, each) => all * Number(getComputedStyle(each).opacity), opacity(colour));
    const [high, low] = [over([...colour.slice(0, 3), share], back), back].map(luminance).sort((a, b) => b - a);
    const contrast = (high + 0.05) / (low + 0.05);
    if (contrast < least) found.push(`"${text.slice(0, 40)}": ${contrast.toFixed(2)}`);
  }
  return found;
}"""


def sideways(page: Page, allowed: str = "") -> list[str]:
    """allowed: a selector of what may scroll sideways within itself."""
    return page.evaluate(SIDEWAYS, allowed)


def pale(page: Page) -> list[str]:
    return page.evaluate(PALE, LEAST_CONTRAST)
