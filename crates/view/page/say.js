// Words to whoever looks.

const $ = (id) => document.getElementById(id);

export function status(text, bad = false) {
  $("status").textContent = text;
  $("status").toggleAttribute("data-bad", bad);
}

// A message, which goes by itself unless it is bad.
export function say(text, bad = false) {
  $("message").hidden = !text;
  $("message").textContent = text;
  $("message").toggleAttribute("data-bad", bad);
  clearTimeout(say.timer);
  if (text && !bad) say.timer = setTimeout(() => say(""), 12000);
}
