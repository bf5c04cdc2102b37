// What keys do.

export function listen(acts) {
  const turns = { ArrowLeft: [-12, 0], ArrowRight: [12, 0], ArrowUp: [0, -12], ArrowDown: [0, 12] };
  document.addEventListener("keydown", (event) => {
    const { target, key } = event;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    // Fields and lists have keys of their own, and buttons the space bar.
    const isField = target.matches("input, select, textarea") || target.closest("dialog");
    if (isField && key !== "Escape") return;
    if (target.matches("button, summary") && (key === " " || key === "Enter")) return;
    if (turns[key]) {
      if (target !== document.body && target.tagName !== "CANVAS") return;
      acts.turn(...turns[key], event.shiftKey);
      event.preventDefault();
      return;
    }
    const act = acts[key === " " ? "space" : key.toLowerCase()];
    if (act) {
      act();
      event.preventDefault();
    }
  });
}
