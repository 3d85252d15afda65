/* What the layout reconstructs. What is not known of the layout that is shown is said to be computed, and never old. */
import { DEGREES, element } from "./parts.js";

const at = (id) => document.getElementById(id);
const COMPUTING = "computing…";

function put(cell, value, digits, sign = false) {
  const isBusy = value === undefined;
  cell.setAttribute("aria-busy", String(isBusy));
  const shown = isBusy ? COMPUTING : value === null ? "–" : `${sign && value >= 0 ? "+" : ""}${value.toFixed(digits)}`;
  if (cell.textContent !== shown) cell.textContent = shown;
}

/* Not known while one of them is not, and none where there is none of one. */
function difference(one, other) {
  if (one === undefined || other === undefined) return undefined;
  return one === null || other === null ? null : one - other;
}

/* Percent of the ring maximum; not known while one of both is not. */
function percent(area, ring) {
  if (area === undefined || area === null) return area;
  return ring === null ? undefined : ring.area ? (100 * area) / ring.area : null;
}

export class Numbers {
  constructor(link) {
    this.link = link;
    this.rows = at("cameras").querySelector("tbody");
    this.wasWhole = true;
  }

  show(state) {
    const { exact, equidistant: even } = state, n = state.angles.length;
    /* Of what is refused nothing will come. */
    const missing = state.refused ? null : undefined;
    const area = exact.area ?? missing, error = exact.is_whole ? exact.error : missing;
    at("numbers").querySelector("th").textContent = `${n} camera${n === 1 ? "" : "s"}`;
    put(at("area"), area, 4);
    put(at("error"), error, 4);
    put(at("sampled"), state.sampled ?? undefined, 0);
    put(at("separation"), state.separation, 3);
    put(at("even-area"), even ? even.area : missing, 4);
    put(at("even-error"), even ? even.error : missing, 4);
    put(at("gain"), difference(area, even ? even.area : missing), 4, true);
    const fraction = percent(area, state.ring), evenFraction = percent(even ? even.area : missing, state.ring);
    put(at("fraction"), fraction, 2);
    put(at("even-fraction"), evenFraction, 2);
    put(at("fraction-gain"), difference(fraction, evenFraction), 2, true);
    put(at("worse"), difference(error, even ? even.error : missing), 4, true);
    for (const [id, isWorse] of [["gain", (value) => value < 0], ["fraction-gain", (value) => value < 0], ["worse", (value) => value > 0]]) {
      at(id).classList.toggle("worse", isWorse(Number(at(id).textContent)));
    }
    at("words").textContent = state.words + (state.even_breaks.length ? ` (the equidistant layout breaks the constraints: ${state.even_breaks[0]})` : "");
    at("error-words").textContent = state.error_words;
    if (exact.is_whole && !this.wasWhole) performance.mark("exact numbers shown");
    this.wasWhole = exact.is_whole;
    document.documentElement.dataset.ring = state.ring ? "known" : "computing";
    document.documentElement.dataset.numbers = exact.is_whole && even ? "known" : "computing";
    this.cameras(state);
  }

  cameras(state) {
    while (this.rows.rows.length > state.angles.length) this.rows.deleteRow(-1);
    while (this.rows.rows.length < state.angles.length) this.rows.append(this.row(this.rows.rows.length));
    state.angles.forEach((angle, number) => {
      const [, where, position, sees, fixed] = this.rows.rows[number].cells;
      const input = where.firstChild, box = fixed.firstChild;
      if (document.activeElement !== input) input.value = (angle * DEGREES).toFixed(3);
      input.disabled = state.fixed[number];
      position.textContent = state.positions[number].map((one) => one.toFixed(1)).join(", ");
      put(sees, state.exact.cameras ? state.exact.cameras[number] : state.refused ? null : undefined, 2);
      box.checked = state.fixed[number];
      this.rows.rows[number].cells[5].firstChild.disabled = state.fixed[number] || state.angles.length === 1;
    });
  }

  row(number) {
    const name = `camera ${number + 1}`;
    const angle = element("input", { type: "number", step: "any", "aria-label": `ring angle of ${name} in degrees` });
    angle.addEventListener("change", () => {
      if (!Number.isFinite(angle.valueAsNumber)) return;
      this.link.send({ do: "put", camera: number, angle: angle.valueAsNumber / DEGREES });
      angle.blur();
    });
    const fixed = element("input", { type: "checkbox", "aria-label": `${name} is fixed` });
    fixed.addEventListener("change", () => this.link.send({ do: "fix", camera: number, fixed: fixed.checked }));
    const remove = element("button", { type: "button", "aria-label": `remove ${name}`, title: `remove ${name}` }, "✕");
    remove.addEventListener("click", () => this.link.send({ do: "remove", camera: number }));
    return element(
      "tr", {}, element("th", {}, String(number + 1)), element("td", {}, angle), element("td"), element("td"),
      element("td", {}, fixed), element("td", {}, remove),
    );
  }
}
