// Buttons and choices of the 3-D viewer. Build: see README.md.
export function makeButton(text, title, act) {
  const button = document.createElement("button");
  Object.assign(button, { type: "button", textContent: text, title });
  button.addEventListener("click", act);
  return button;
}

export function makeSelect(texts, title, act) {
  // One of several texts; `act` gets the place of the chosen one.
  const label = document.createElement("label");
  label.className = "select";
  const select = document.createElement("select");
  select.autocomplete = "off";
  select.append(...texts.map((text) => new Option(text)));
  select.addEventListener("change", () => act(select.selectedIndex));
  label.append(title, select);
  return label;
}
