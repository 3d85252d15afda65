/* What the page is made of, and how its parts hear of each other. All that is told comes from the server. */
import { connect } from "./link.js";
import { Ring } from "./ring.js";
import { Surface } from "./surface.js";
import { History } from "./history.js";
import { Curves } from "./curves.js";
import { Numbers } from "./numbers.js";
import { Request } from "./request.js";

const at = (id) => document.getElementById(id);
const link = connect(hear, gone);
const ring = new Ring(at("ring"), link, say);
const surface = new Surface(at("surface"), at("legend"), at("colouring"));
const numbers = new Numbers(link);
const request = new Request(at("settings"), at("arcs"), at("forbid"), link);
const history = new History(at("tried"), at("beside"), link);
const curves = new Curves(at("curves"), link);
let saying = 0, job = null, latest = null, begun = null;

function hear(message) {
  if (message instanceof ArrayBuffer) {
    surface.show(message);
    at("drawn").textContent = "";
    return;
  }
  if (message.kind === "hello") {
    at("name").textContent = `${message.name}, ${message.faces} faces`;
    document.title = `${message.name}: camring design`;
    request.describe(message.settings);
    at("maximum").title = `of what ${message.ring_cameras} equidistant cameras on this ring reconstruct`;
    at("optimise").title = `what camring optimise proposes for this number of cameras: the most accurate of the layouts that give up at most ${+(100 * message.give_up).toFixed(3)} % of the greatest area found`;
  } else if (message.kind === "state") {
    ring.show(message);
    numbers.show(message);
    request.show(message);
    surface.name(message.angles.length);
    if (!message.exact.is_whole) at("drawn").textContent = "computing the surface…";
    if (message.refused) say(message.refused);
    at("nothing").firstElementChild.textContent = message.nothing ?? "";
    at("nothing").hidden = !message.nothing;
    latest = message;
    tellResult();
  } else if (message.kind === "history") {
    history.show(message);
    at("undo").disabled = !message.can_undo;
    at("redo").disabled = !message.can_redo;
  } else if (message.kind === "job") {
    showJob(message.job);
  } else if (message.kind === "curves") {
    const before = at("curves").childElementCount;
    curves.show(message.curves);
    if (at("curves").childElementCount > before && job) at("curves").scrollIntoView({ block: "nearest" });
  } else if (message.kind === "said") {
    begun = null;
    (message.words === "stopped" ? tell : say)(message.words);
  }
}

function gone(isGone) {
  document.documentElement.dataset.link = isGone ? "gone" : "there";
  if (isGone) say("the server does not answer; start camring design again", true);
  else at("said").hidden = true;
}

function say(words, stays = false) {
  const said = at("said");
  at("told").hidden = true;
  said.textContent = words;
  said.hidden = false;
  clearTimeout(saying);
  if (!stays) saying = setTimeout(() => { said.hidden = true; }, 8000);
}

/* What went as it should. */
function tell(words) {
  at("said").hidden = true;
  at("told").textContent = words;
  at("told").hidden = false;
}

/* What a search has changed, once its numbers are known. */
function tellResult() {
  if (!begun || job || !latest.exact.is_whole) return;
  const { what, area, error } = begun, now = latest.exact;
  begun = null;
  if (what === "how many cameras" || what === "trade-off") {
    tell(`${what}: done, see the chart below; a click on a point tries its layout`);
    return;
  }
  const sign = (value, digits) => `${value < 0 ? "−" : "+"}${Math.abs(value).toFixed(digits)}`;
  const changes = [`exact area ${sign(now.area - area, 2)} mm²`];
  if (error && now.error) changes.push(`RMS error ${sign(now.error - error, 4)} mm (${sign(100 * (now.error / error - 1), 0)} %)`);
  tell(now.area === area && now.error === error ? `${what}: nothing better was found` : `${what}: ${changes.join(", ")}`);
}

function showJob(next) {
  if (next && !job && latest && !next.what.includes(".")) begun = { what: next.what, area: latest.exact.area, error: latest.exact.error };
  const isOver = job && !next;
  job = next;
  if (job) at("told").hidden = true;
  if (isOver && latest) tellResult();
  at("job").hidden = job === null;
  at("stop").disabled = job === null;
  for (const button of document.querySelectorAll("button.search, button.save")) button.disabled = job !== null;
  if (job === null) return;
  at("stage").textContent = `${job.what}: ${job.stage}${job.total > 1 ? `, ${job.done} of ${job.total}` : ""}`;
  const progress = at("progress");
  if (job.total > 1) {
    progress.max = job.total;
    progress.value = job.done;
  } else {
    progress.removeAttribute("value");
  }
}

async function save(name) {
  const answer = await fetch(`save/${name}`);
  if (!answer.ok) {
    say((await answer.text()).trim());
    return;
  }
  const anchor = document.createElement("a");
  anchor.href = URL.createObjectURL(await answer.blob());
  anchor.download = name;
  anchor.click();
  tell(`saved ${name}`);
  setTimeout(() => URL.revokeObjectURL(anchor.href), 60000);
}

const doing = {
  undo: "undo", redo: "redo", equidistant: "equidistant", improve: "improve", "one-more": "one more",
  optimise: "optimise", counts: "how many cameras", "trade-off": "trade-off", place: "place the ring", stop: "stop",
};
for (const [id, what] of Object.entries(doing)) at(id).addEventListener("click", () => link.send({ do: what }));
at("add").addEventListener("click", () => link.send({ do: "add", place: null }));
at("above").addEventListener("click", () => surface.fromAbove());
for (const button of document.querySelectorAll("button.save")) {
  button.addEventListener("click", () => save(button.dataset.file).catch(() => say("the server does not answer")));
}
at("open").addEventListener("change", async (event) => {
  const [file] = event.target.files;
  event.target.value = "";
  if (!file) return;
  if (file.size > 400000) say(`${file.name} is no layout file: it has ${file.size} bytes`);
  else link.send({ do: "open", text: await file.text() });
});
document.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.target.matches("input")) return;
  const key = event.key.toLowerCase();
  if (key === "z" || key === "y") {
    event.preventDefault();
    link.send({ do: key === "y" || event.shiftKey ? "redo" : "undo" });
  }
});
