/* Small parts that several others draw with. */

export const DEGREES = 180 / Math.PI;
export const RADIUS = 100;

const SVG = "http://www.w3.org/2000/svg";

/* An SVG element with attributes and children; texts are shown as they are. */
export function svg(name, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key in made) made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/* Point of the drawing of a ring, whose y points down. */
export function onRing(angle, radius = RADIUS) {
  return [radius * Math.cos(angle), -radius * Math.sin(angle)];
}

/* Path along the ring, counter-clockwise from one angle to another. */
export function arc(start, end, radius = RADIUS) {
  const [x0, y0] = onRing(start, radius), [x1, y1] = onRing(end, radius);
  const turn = 2 * Math.PI, width = (((end - start) % turn) + turn) % turn;
  return `M ${x0} ${y0} A ${radius} ${radius} 0 ${width > Math.PI ? 1 : 0} 0 ${x1} ${y1}`;
}

export function patch(colour) {
  return svg("svg", { viewBox: "0 0 10 10", "aria-hidden": "true" }, svg("rect", { width: 10, height: 10, fill: colour, stroke: "#888" }));
}
