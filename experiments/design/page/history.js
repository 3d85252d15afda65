/* The layouts that were tried, with their numbers; two of them beside each other. */
import { DEGREES, RADIUS, element, onRing, svg } from "./parts.js";

const number = (value, digits, sign = false) =>
  value === null || value === undefined ? "–" : `${sign && value >= 0 ? "+" : ""}${value.toFixed(digits)}`;

export class History {
  constructor(rows, beside, link) {
    this.rows = rows;
    this.beside = beside;
    this.link = link;
    this.chosen = [];
  }

  show(message) {
    this.tried = message.tried;
    const known = new Set(message.tried.map((one) => one.number));
    this.chosen = this.chosen.filter((one) => known.has(one));
    this.rows.replaceChildren(...[...message.tried].reverse().map((one) => this.row(one, one.number === message.at)));
    this.compare();
  }

  row(one, isShown) {
    const go = element("button", { type: "button" }, String(one.number));
    go.addEventListener("click", () => this.link.send({ do: "go", number: one.number }));
    const box = element("input", { type: "checkbox", checked: this.chosen.includes(one.number), "aria-label": `layout ${one.number} beside another` });
    box.addEventListener("change", () => {
      this.chosen = this.chosen.filter((other) => other !== one.number);
      if (box.checked) this.chosen = [...this.chosen, one.number].slice(-2);
      this.show({ tried: this.tried, at: this.at });
    });
    if (isShown) this.at = one.number;
    const over = one.area === null ? null : one.area - one.even_area;
    const row = element(
      "tr", {}, element("th", {}, go), element("td", {}, one.why), element("td", {}, String(one.angles.length)),
      element("td", {}, number(one.area, 4)), element("td", {}, number(over, 4, true)), element("td", {}, number(one.error, 4)),
      element("td", {}, box),
    );
    row.setAttribute("aria-current", String(isShown));
    return row;
  }

  compare() {
    const pair = this.chosen.map((chosen) => this.tried.find((one) => one.number === chosen));
    this.beside.replaceChildren(...(pair.length < 2 ? [] : pair.map((one) => this.figure(one))));
  }

  figure(one) {
    const drawing = svg("svg", { viewBox: "-120 -120 240 240", role: "img", "aria-label": `layout ${one.number} from above` }, svg("circle", { r: RADIUS, class: "circle" }));
    one.angles.forEach((angle, index) => {
      const [x, y] = onRing(angle);
      const shape = one.fixed[index] ? svg("rect", { x: x - 9, y: y - 9, width: 18, height: 18, class: "camera" }) : svg("circle", { cx: x, cy: y, r: 11, class: "camera" });
      drawing.append(shape, svg("text", { x, y: y + 4 }, String(index + 1)));
    });
    const lines = [
      `layout ${one.number}: ${one.why}`,
      `${number(one.area, 4)} mm² exact area, ${number(one.area === null ? null : one.area - one.even_area, 4, true)} mm² over equidistant`,
      `${number(one.error, 4)} mm RMS error, equidistant ${number(one.even_error, 4)} mm`,
      `ring of ${one.diameter} mm; ${one.words}`,
      one.angles.map((angle) => `${(angle * DEGREES).toFixed(1)}°`).join(", "),
    ];
    return element("figure", {}, drawing, element("figcaption", {}, ...lines.map((line) => element("p", {}, line))));
  }
}
