// A page of `meniscus view`: asks the server whether something else is to be shown, and shows it.
const at = (id) => document.getElementById(id);
/** Time between questions, ms. */
const PAUSE = 700;

/** An error where the user sees it: title, text and what helps; without a title it goes away. */
function trouble(title, text = "", help = "") {
  at("trouble").hidden = !title;
  at("trouble-title").textContent = title ?? "";
  at("trouble-text").textContent = text;
  at("trouble-help").textContent = help;
}

/** Where an error is, and what stands there. */
const place = ({ file, line, column, text }) => (line ? `${file}:${line}:${column}: ${text}` : "");

async function json(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Error(`${address}: ${answer.status}`);
  return answer.json();
}

function tell({ state, error, report }, shown) {
  if (error) trouble(error.message, place(error), error.help ?? "");
  else trouble(null);
  at("message").hidden = state !== "waiting" || shown;
  at("message").textContent = "Waiting for the first frame …";
  at("report-box").hidden = !report;
  at("report").textContent = report ?? "";
  document.body.dataset.live = state;
}

/** Follows the server: `show` is called with each new document's runs. */
export async function follow(show) {
  let version = null, shown = false;
  for (;;) {
    try {
      const state = await json("state");
      if (state.version !== version) {
        const all = await json("data");
        tell(all, shown);
        if (all.runs.length) {
          await show({ ...all.runs[0], preview: Boolean(all.report) }, all.runs[1] ?? null);
          shown = true;
        }
        version = all.version;
      }
    } catch (e) {
      version = null;
      trouble("The server of `meniscus view` does not answer.", String(e.message ?? e), "Start it again and reload this page.");
    }
    await new Promise((done) => { setTimeout(done, PAUSE); });
  }
}

/** What is known of a point of the contact line of a frame. */
export async function pointOfLine(number, point) {
  const { values, solids } = await json(`line/0/${number}/contact_line`);
  const of = (name) => values[name]?.[point];
  const force = ["fx", "fy", "fz"].map((name) => of(name) ?? 0);
  return { solid: solids[of("solid") ?? -1], angle: of("angle"), speed: of("speed"), force: Math.hypot(...force) };
}
