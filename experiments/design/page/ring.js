/* The ring from above. Cameras go where the server lets them, so that nothing shown breaks a constraint. */
import { DEGREES, RADIUS, arc, onRing, svg } from "./parts.js";

const STEP = 1 / DEGREES, SMALL = 0.1 / DEGREES;

export class Ring {
  constructor(drawing, link, say) {
    this.drawing = drawing;
    this.link = link;
    this.say = say;
    this.held = null;
    this.state = null;
    this.back = drawing.appendChild(svg("g"));
    this.cameras = [];
    drawing.addEventListener("pointermove", (event) => this.moved(event));
    for (const name of ["pointerup", "pointercancel"]) drawing.addEventListener(name, () => this.release());
    drawing.addEventListener("dblclick", (event) => {
      if (event.target.closest(".track")) link.send({ do: "add", place: this.angleAt(event) });
    });
  }

  angleAt(event) {
    const box = this.drawing.getBoundingClientRect(), view = this.drawing.viewBox.baseVal;
    const scale = Math.max(view.width / box.width, view.height / box.height);
    const x = (event.clientX - box.left - box.width / 2) * scale, y = (event.clientY - box.top - box.height / 2) * scale;
    return Math.atan2(-y, x);
  }

  moved(event) {
    if (this.held !== null) this.link.move({ do: "drag", camera: this.held, angle: this.angleAt(event) });
  }

  release() {
    if (this.held === null) return;
    this.cameras[this.held]?.classList.remove("held");
    this.held = null;
    performance.mark("the hand rests");
    this.link.send({ do: "drop" });
  }

  pressed(event, number) {
    event.preventDefault();
    this.cameras[number].focus();
    if (this.state.fixed[number]) {
      this.say(`camera ${number + 1} is fixed; press F, or untick it in the table, to let it go`);
      return;
    }
    this.held = number;
    this.cameras[number].classList.add("held");
    this.drawing.setPointerCapture(event.pointerId);
    this.link.send({ do: "drag", camera: number, angle: this.state.angles[number] });
  }

  key(event, number) {
    const turns = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 };
    if (event.key in turns) {
      const step = turns[event.key] * (event.shiftKey ? SMALL : STEP);
      this.link.send({ do: "nudge", camera: number, by: step });
    } else if (event.key === "Delete" || event.key === "Backspace") {
      this.link.send({ do: "remove", camera: number });
    } else if (event.key.toLowerCase() === "f" && !event.ctrlKey && !event.metaKey) {
      this.link.send({ do: "fix", camera: number, fixed: !this.state.fixed[number] });
    } else {
      return;
    }
    event.preventDefault();
  }

  keyUp(event) {
    if (event.key.startsWith("Arrow")) {
      performance.mark("the hand rests");
      this.link.send({ do: "drop" });
    }
  }

  show(state) {
    this.state = state;
    const back = [svg("circle", { r: RADIUS, class: "circle" })];
    back.push(...state.forbidden.map(([start, end]) => svg("path", { d: arc(start, end), class: "forbidden" })));
    if (state.gap > 0) {
      /* Half a separation to either side of each camera: no two of these may overlap. */
      back.push(...state.angles.map((angle) => svg("path", { d: arc(angle - state.gap / 2, angle + state.gap / 2), class: "room" })));
    }
    back.push(...this.chords(state));
    back.push(...state.even.map((angle) => {
      const [x, y] = onRing(angle);
      return svg("circle", { cx: x, cy: y, r: 6, class: "even" });
    }));
    back.push(svg("circle", { r: RADIUS, class: "track" }));
    this.back.replaceChildren(...back);
    while (this.cameras.length > state.angles.length) this.cameras.pop().remove();
    while (this.cameras.length < state.angles.length) this.cameras.push(this.made(this.cameras.length));
    state.angles.forEach((angle, number) => this.place(number, angle, state.fixed[number]));
  }

  chords(state) {
    const order = state.angles.map((_, i) => i).sort((i, j) => state.angles[i] - state.angles[j]);
    const pairs = order.map((i, k) => [state.angles[i], state.angles[order[(k + 1) % order.length]]]);
    if (order.length < 3) pairs.length = order.length - 1;
    return pairs.flatMap(([from, to]) => {
      const [x1, y1] = onRing(from), [x2, y2] = onRing(to), turn = 2 * Math.PI;
      const half = ((((to - from) % turn) + turn) % turn) / 2, diameter = state.settings.diameter;
      const [x, y] = onRing(from + half, Math.max(RADIUS * Math.cos(half) - (half > 0.45 ? 14 : 32), 12));
      const line = svg("line", { x1, y1, x2, y2, class: "chord" });
      if (order.length > 12) return [line];
      return [line, svg("text", { x, y: y + 4, class: "separation" }, `${(diameter * Math.sin(half)).toFixed(1)} mm`)];
    });
  }

  made(number) {
    const camera = svg("g", { class: "camera", tabindex: 0, role: "slider", "aria-valuemin": 0, "aria-valuemax": 360 });
    camera.append(svg("circle", { r: 20, class: "touch" }), svg("g", { class: "shape" }), svg("text", { class: "number", y: 4 }, String(number + 1)), svg("text", { class: "angle" }));
    camera.addEventListener("pointerdown", (event) => this.pressed(event, number));
    camera.addEventListener("keydown", (event) => this.key(event, number));
    camera.addEventListener("keyup", (event) => this.keyUp(event));
    return this.drawing.appendChild(camera);
  }

  place(number, angle, isFixed) {
    const camera = this.cameras[number], [x, y] = onRing(angle), [ax, ay] = onRing(angle, 0.26 * RADIUS);
    camera.setAttribute("transform", `translate(${x} ${y})`);
    camera.classList.toggle("fixed", isFixed);
    camera.setAttribute("aria-label", `camera ${number + 1}${isFixed ? ", fixed" : ""}`);
    camera.setAttribute("aria-valuenow", (angle * DEGREES).toFixed(3));
    camera.setAttribute("aria-valuetext", `${(angle * DEGREES).toFixed(3)} degrees`);
    const mark = isFixed ? svg("rect", { x: -9, y: -9, width: 18, height: 18, class: "mark" }) : svg("circle", { r: 11, class: "mark" });
    camera.querySelector(".shape").replaceChildren(mark);
    const label = camera.querySelector(".angle");
    label.setAttribute("x", 1.25 * ax);
    label.setAttribute("y", ay + 4);
    label.textContent = `${(angle * DEGREES).toFixed(1)}°`;
  }
}
