"use strict";
const caption = document.getElementById("caption");
const buttons = [...document.querySelectorAll("button[data-colouring]")];

async function unpacked(id) {
  const text = atob(document.getElementById(id).textContent);
  const bytes = Uint8Array.from(text, (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

/* Each shade has a band of its own, so that no colour is ever mixed. */
function bands(shades) {
  return shades.flatMap((shade, i) => [[i / shades.length, shade.colour], [(i + 1) / shades.length, shade.colour]]);
}

async function start() {
  const scene = JSON.parse(document.getElementById("scene").textContent);
  const program = document.createElement("script");
  program.textContent = new TextDecoder().decode(await unpacked("plotly"));
  document.head.append(program);
  const packed = await unpacked("surface");
  const corners = new Uint32Array(packed, 0, 3 * scene.n_triangles);
  const steps = new Uint16Array(packed, corners.byteLength, 3 * scene.n_vertices);
  const shades = new Uint8Array(packed, corners.byteLength + steps.byteLength);
  const column = (values, n, at) => Array.from({ length: n }, (_, i) => values[3 * i + at]);
  const along = (at) => column(steps, scene.n_vertices, at).map((step) => scene.origin[at] + scene.step * step);
  const shadesOf = (number) => shades.subarray(number * scene.n_triangles, (number + 1) * scene.n_triangles);
  const plot = document.getElementById("plot");
  /* Without the least sizes of normals, which leave dark flecks where triangles are small. */
  const mesh = {
    type: "mesh3d", x: along(0), y: along(1), z: along(2),
    i: column(corners, scene.n_triangles, 0), j: column(corners, scene.n_triangles, 1),
    k: column(corners, scene.n_triangles, 2), intensity: Array.from(shadesOf(0)), intensitymode: "cell",
    colorscale: bands(scene.colourings[0].shades), cmin: -0.5, cmax: scene.colourings[0].shades.length - 0.5,
    showscale: false, hoverinfo: "skip", flatshading: true,
    lighting: {
      ambient: 0.86, diffuse: 0.3, specular: 0.02, roughness: 0.9, fresnel: 0, facenormalsepsilon: 0,
      vertexnormalsepsilon: 0,
    },
    lightposition: { x: 20000, y: -30000, z: 60000 },
  };
  /* The fields of view of some cameras as one line, with a gap after each. */
  const borders = (fields, at) => fields.flatMap((corners) => [...corners, corners[0]].map((corner) => corner[at]).concat(null));
  const lines = {
    type: "scatter3d", mode: "lines", x: [], y: [], z: [], line: { color: "#b5179e", width: 3 }, hoverinfo: "skip",
    showlegend: false,
  };
  const axis = (name, at) => ({
    ...(scene.frame ? { range: scene.frame[at] } : {}), nticks: 6, title: { text: name + " [mm]" },
    showspikes: false, showbackground: false, gridcolor: "#dfe3e7", zeroline: false,
  });
  /* Narrow pages need more room for the axes' names. Seen from above, the surface hides most of the z axis. */
  const distance = plot.clientWidth < 500 ? 2.1 : 1.95;
  await Plotly.newPlot(plot, [mesh, lines], {
    margin: { l: 0, r: 0, t: 0, b: 0 }, paper_bgcolor: "rgba(0,0,0,0)",
    scene: {
      aspectmode: "data", xaxis: axis("x", 0), yaxis: axis("y", 1), zaxis: { ...axis("z", 2), visible: false },
      dragmode: "orbit",
      camera: { eye: { x: 0, y: -0.27 * distance, z: 0.96 * distance }, center: { x: 0, y: 0, z: 0 }, up: { x: 0, y: 0, z: 1 } },
    },
  }, { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["resetCameraLastSave3d", "hoverClosest3d"] });

  const turned = (change) => {
    if (!("scene.camera" in change)) return;
    plot.removeListener("plotly_relayout", turned);
    Plotly.relayout(plot, { "scene.zaxis.visible": true });
  };
  plot.on("plotly_relayout", turned);

  async function show(number) {
    const colouring = scene.colourings[number];
    buttons.forEach((button, i) => button.setAttribute("aria-pressed", String(i === number)));
    caption.textContent = colouring.caption;
    document.getElementById("legend").replaceChildren(...colouring.shades.map((shade) => {
      const item = document.createElement("li"), patch = document.createElement("i");
      patch.style.background = shade.colour;
      item.append(patch, shade.words);
      return item;
    }));
    await Plotly.restyle(plot, {
      intensity: [Array.from(shadesOf(number))], colorscale: [bands(colouring.shades)], cmin: -0.5,
      cmax: colouring.shades.length - 0.5,
    }, [0]);
    await Plotly.restyle(plot, {
      x: [borders(colouring.fields, 0)], y: [borders(colouring.fields, 1)], z: [borders(colouring.fields, 2)],
    }, [1]);
    plot.dataset.shown = String(number);
  }

  buttons.forEach((button, number) => button.addEventListener("click", () => show(number)));
  await show(scene.proposed);
}

start().catch((fault) => {
  caption.textContent = "The picture cannot be drawn by this browser: " + fault.message;
  document.getElementById("plot").dataset.fault = fault.message;
});
