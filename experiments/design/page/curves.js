/* Area over the number of cameras, and over the error: each point is a layout that a click tries. */
import { element, svg } from "./parts.js";

const WIDTH = 460, HEIGHT = 250, LEFT = 52, RIGHT = 14, TOP = 12, BOTTOM = 40;
const NAMES = { "how many cameras": "cameras", "trade-off": "RMS error [mm]" };
const LINES = ["equidistant", "optimised"];

/* Round steps that divide a span into about that many. */
function steps(low, high, about) {
  const rough = (high - low) / about || 1, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= rough - 1e-12);
  const found = [];
  for (let at = Math.ceil(low / step - 1e-9) * step; at <= high + 1e-9; at += step) found.push(Number(at.toPrecision(10)));
  return found;
}

export class Curves {
  constructor(place, link) {
    this.place = place;
    this.link = link;
  }

  show(curves) {
    const drawn = Object.entries(curves).filter(([, curve]) => curve.points.length);
    this.place.replaceChildren(...drawn.map(([name, curve]) => this.figure(name, curve)));
  }

  figure(name, curve) {
    const points = curve.points, counts = name === "how many cameras";
    const xs = points.map((one) => one.at), ys = points.map((one) => 100 * one.fraction);
    const pad = counts ? 0.5 : 0.04 * (Math.max(...xs) - Math.min(...xs)) || 0.01;
    const low = [Math.min(...xs) - pad, Math.max(0, Math.min(...ys) - 1)], high = [Math.max(...xs) + pad, Math.min(100.5, Math.max(...ys) + 1)];
    const x = (at) => LEFT + ((at - low[0]) / (high[0] - low[0])) * (WIDTH - LEFT - RIGHT);
    const y = (at) => HEIGHT - BOTTOM - ((at - low[1]) / (high[1] - low[1])) * (HEIGHT - TOP - BOTTOM);
    const drawing = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": name });
    for (const at of steps(low[1], high[1], 5)) {
      drawing.append(svg("line", { x1: LEFT, x2: WIDTH - RIGHT, y1: y(at), y2: y(at), class: "grid" }), svg("text", { x: LEFT - 6, y: y(at) + 4, class: "left" }, String(at)));
    }
    const across = counts ? [...new Set(xs)] : steps(low[0], high[0], 6);
    for (const at of across) drawing.append(svg("text", { x: x(at), y: HEIGHT - BOTTOM + 16 }, String(at)));
    drawing.append(svg("text", { x: (LEFT + WIDTH - RIGHT) / 2, y: HEIGHT - 6 }, NAMES[name]));
    drawing.append(svg("text", { transform: `translate(12 ${(TOP + HEIGHT - BOTTOM) / 2}) rotate(-90)` }, "of the ring maximum [%]"));
    for (const line of LINES) {
      const own = points.filter((one) => one.line === line);
      const path = [...own].sort((one, other) => one.at - other.at).map((one) => `${x(one.at)},${y(100 * one.fraction)}`).join(" ");
      if (counts || line === "optimised") drawing.append(svg("polyline", { points: path, class: `line ${line}` }));
      own.forEach((one) => drawing.append(this.point(one, x(one.at), y(100 * one.fraction), counts)));
    }
    const legend = "● optimised   ○ equidistant. A click on a point tries its layout.";
    return element("figure", {}, drawing, element("figcaption", { className: "note" }, `${legend} ${curve.words}.`));
  }

  point(one, x, y, counts) {
    const at = counts ? `${one.at} cameras` : `${one.at.toFixed(4)} mm`;
    const words = `${one.line}: ${at}, ${(100 * one.fraction).toFixed(2)} %`;
    const mark = svg("circle", { cx: x, cy: y, r: 5, class: `point ${one.line}`, tabindex: 0, role: "button", "aria-label": words }, svg("title", {}, words));
    const go = () => this.link.send({ do: "place", angles: one.angles });
    mark.addEventListener("click", go);
    mark.addEventListener("keydown", (event) => {
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        go();
      }
    });
    return mark;
  }
}
