/* Ring, limits and constraints: a slider and a number for each. */
import { DEGREES, element } from "./parts.js";

export class Request {
  constructor(place, arcs, form, link) {
    this.place = place;
    this.arcs = arcs;
    this.link = link;
    this.rows = new Map();
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const [from, to] = ["from", "to"].map((id) => form.querySelector(`#${id}`).valueAsNumber / DEGREES);
      link.send({ do: "forbid", start: from, end: to });
      form.reset();
    });
  }

  describe(settings) {
    this.rows.clear();
    this.place.replaceChildren(...settings.map((setting) => this.row(setting)));
  }

  row(setting) {
    const shown = `${setting.label}${setting.unit ? ` in ${setting.unit}` : ""}`;
    const slider = element("input", { type: "range", min: setting.least, max: setting.most, step: setting.step, "aria-label": shown });
    const number = element("input", { type: "number", step: "any", "aria-label": `${shown}, as a number` });
    const box = setting.optional ? element("input", { type: "checkbox", "aria-label": `limit ${setting.label}` }) : null;
    const turn = (value) => ({ do: "turn", name: setting.name, value });
    slider.addEventListener("input", () => this.link.move(turn(slider.valueAsNumber)));
    slider.addEventListener("change", () => this.link.send({ do: "drop" }));
    number.addEventListener("change", () => {
      if (Number.isFinite(number.valueAsNumber)) {
        this.link.send(turn(number.valueAsNumber));
        this.link.send({ do: "drop" });
      }
      number.blur();
    });
    box?.addEventListener("change", () => {
      this.link.send(turn(box.checked ? setting.likely ?? slider.valueAsNumber : null));
      this.link.send({ do: "drop" });
    });
    if (box && setting.needs) box.disabled = true;
    this.rows.set(setting.name, { slider, number, box });
    const name = element("label", { className: "name", title: setting.needs }, ...(box ? [box] : []), setting.label);
    const value = element("span", {}, number, element("span", { className: "unit" }, setting.unit));
    return element("div", { className: "setting" }, name, slider, value);
  }

  show(state) {
    for (const [name, { slider, number, box }] of this.rows) {
      const value = state.settings[name], isThere = value !== null;
      if (isThere && !slider.matches(":active")) slider.value = value;
      if (document.activeElement !== number) number.value = isThere ? String(value) : "";
      if (box) {
        box.checked = isThere;
        slider.disabled = number.disabled = !isThere;
      }
    }
    const words = state.forbidden.map(([start, end]) => `${(start * DEGREES).toFixed(1)}° to ${(end * DEGREES).toFixed(1)}°`);
    if (words.join() === this.shownArcs) return;
    this.shownArcs = words.join();
    this.arcs.replaceChildren(...words.map((text, arc) => {
      const open = element("button", { type: "button" }, "Open it again");
      open.addEventListener("click", () => this.link.send({ do: "allow", arc }));
      return element("li", {}, `${text} `, open);
    }));
  }
}
