/* The comparison report. All that it says is made from the document's numbers. */
"use strict";

const report = JSON.parse(document.getElementById("report").textContent);
const EXACT = 1e-9, CLOSE = 0.01;
const held = (run) => !run.metrics.dropped;
const pinchOf = (scene) => scene.runs[0];
/* The runs that are shown without asking: Pinch's, quickstep's with the fewest iterations, worldstep's. */
const quickOf = (scene) => scene.runs.find((r) => r.contact_solver === "quickstep");
const worldOf = (scene) => scene.runs.find((r) => r.contact_solver === "worldstep");
const mainRuns = (scene) => [pinchOf(scene), quickOf(scene), worldOf(scene)].filter(Boolean);
const percent = (x) => (x === null ? "–" : x === 0 ? "0 %" : `${number(100 * x, 2)}\u00a0%`);
const runName = (run) => (run.contact_solver === "pinch" ? "Pinch" : run.contact_solver === "quickstep"
    ? `quickstep (${run.quickstep_iterations})` : run.run);
/* Is there a step whose forces were compared with the exact solution? None is of scenes with hands, whose joints the
 * exact solution does not know, and none without samples. */
const isCompared = (scene) => pinchOf(scene).metrics.force_error_max !== null;
const dropTime = (run) => (run.events.find((e) => e.type === "dropped") || {}).time;

/* What the list of scenes says of a verdict. */
const WORDS = { dropped: "dropped", exact: "exact", close: "within 1\u00a0%", off: "off > 1\u00a0%",
    unknown: "held, not compared", law: "held" };

/* How a run did: whether the object stayed, and how well the solver solved the law that it has. What ODE's law lacks of
 * the scene's is not counted here: it is no error of the solver. Only worldstep, which solves ODE's law directly, has
 * nothing to be compared with; of other runs without an error nothing is known but that they hold. */
function verdict(run) {
    if (!held(run)) return ["dropped", "✕", "the object was dropped"];
    if (run.contact_solver === "worldstep") return ["law", "", "held; ODE’s friction law solved directly"];
    if (run.own_error === null) return ["unknown", "?", "held; its forces were not compared"];
    if (run.own_error <= EXACT) return ["exact", "", `held; its friction law solved to ${number(run.own_error, 2)}`];
    if (run.own_error <= CLOSE) return ["close", "", `held; its friction law solved to ${percent(run.own_error)}`];
    return ["off", "~", `held; its friction law missed by up to ${percent(run.own_error)}`];
}

function lead(scenes) {
    const count = (runs) => `${runs.filter(held).length}${runs.length === scenes.length ? "" : ` of ${runs.length}`}`;
    const others = [quickOf, worldOf].map((of) => scenes.map(of).filter(Boolean)).filter((runs) => runs.length)
        .map((runs) => `${runs[0].run === "worldstep" ? "worldstep" : `quickstep with ${runs[0].quickstep_iterations} iterations`} in ${count(runs)}`);
    return `${[`Pinch holds the object in ${scenes.filter((s) => held(pinchOf(s))).length} of ${scenes.length} scenes`, ...others].join(", ")}.`;
}

function map(scenes) {
    const rows = scenes.length ? mainRuns(scenes[0]) : [], box = make("nav", { class: "map", "aria-label": "All scenes by solver",
        style: `grid-template-columns: auto repeat(${scenes.length}, minmax(0, 1fr))` });
    rows.forEach((_, k) => {
        box.append(make("span", { class: "who" }, runName(mainRuns(scenes[0])[k])));
        scenes.forEach((scene, i) => {
            const [name, sign, text] = verdict(mainRuns(scene)[k]);
            const link = make("a", { href: `#${i + 1}`, class: name, title: `${scene.name}: ${text}`,
                "aria-label": `${scene.name}, ${runName(mainRuns(scene)[k])}: ${text}` }, sign);
            link.dataset.scene = i;
            box.append(link);
        });
    });
    const used = new Set(["shown", ...scenes.flatMap((s) => mainRuns(s).map((run) => verdict(run)[0]))]);
    const key = make("p", { class: "key" }, ...[["exact", "", "held, its friction law solved exactly"],
        ["close", "", "held, its friction law solved to 1 %"], ["off", "~", "held, solved worse than to 1 %"],
        ["dropped", "✕", "dropped"], ["unknown", "?", "held; its forces were not compared"],
        ["law", "", "held; worldstep solves ODE’s friction law directly"], ["shown", "", "shown below"]]
        .filter(([name]) => used.has(name)).map(([name, sign, text]) => make("span", {}, make("b", { class: name }, sign), text)));
    return [box, key];
}

/* ---- The five answers: for all scenes, and for one. ---- */

function answerCards(list) {
    return list.map(([question, short, long, tone]) => make("div", { class: `answer ${tone || ""}` },
        make("h2", {}, question), make("p", { class: "short" }, short), make("p", { class: "long" }, ...[long].flat())));
}

/* How the forces of Pinch compare with the exact solution of the same contacts, in the scenes that were compared. */
function exactness(scenes) {
    const compared = scenes.filter(isCompared), rest = scenes.filter((s) => !isCompared(s));
    const worst = Math.max(...compared.map((s) => pinchOf(s).metrics.force_error_max));
    const where = rest.length ? `Forces were compared in ${compared.length} of ${scenes.length} scenes. There, ` : "";
    const said = !compared.length ? ["No force was compared with the exact solution."]
        : [where, worst <= EXACT ? "Pinch’s forces equal the exact solution’s to rounding."
            : `Pinch’s forces differ from the exact solution’s by up to ${percent(worst)}.`,
        ...(rest.length ? [" No step was compared in ", ...sceneLinks(rest), "."] : [])];
    return [...said, scenes.every((s) => pinchOf(s).metrics.verified) ? "" : " Not every step is verified."];
}

/* The most names that a card lists: those of the shipped scenes that differ, in four lines of a telephone. */
const NAMES = 8;

const fingersOf = (scene) => (scene.films ? scene.films[0].fingers : []);
const firstSlip = (scene) => fingersOf(scene).filter((f) => f.first_slip !== null).sort((a, b) => a.first_slip - b.first_slip)[0];

/* What the cards of all scenes say of one scene, and of a list of them: links that show the scene below. */
const sceneLink = (scene) => make("a", { href: `#${report.scenes.indexOf(scene) + 1}` }, scene.name);
const sceneLinks = (list) => [...list.slice(0, NAMES).flatMap((s, k) => (k ? [", ", sceneLink(s)] : [sceneLink(s)])),
    list.length > NAMES ? ` and ${list.length - NAMES} more` : ""];
const fingerName = (finger) => make("b", {}, `‘${finger.name}’`);

function holdAnswer(scenes) {
    const lost = scenes.filter((s) => !held(pinchOf(s)));
    return ["Does it hold?", `${scenes.length - lost.length} of ${scenes.length} with Pinch`,
        [...(lost.length ? ["It drops ", ...sceneLinks(lost), ". "] : ["Every object is held to the end. "]), ...exactness(scenes)],
        lost.length ? "bad" : "good"];
}

function slipAnswer(scenes) {
    const question = "Who slips first with Pinch?", slips = scenes.map((s) => [s, firstSlip(s)]).filter(([, f]) => f);
    if (!slips.length) return [question, "None", "No finger slips as a whole."];
    const [scene, finger] = slips.reduce((a, b) => (b[1].first_slip < a[1].first_slip ? b : a)), elsewhere = slips.filter(([s]) => s !== scene);
    const list = elsewhere.slice(0, NAMES).flatMap(([s, f], k) => [k ? "; " : " The first elsewhere: ", fingerName(f), " in ", sceneLink(s)]);
    const more = elsewhere.length > NAMES ? [`; and ${elsewhere.length - NAMES} more`] : [];
    return [question, `Finger ‘${finger.name}’`, ["In ", sceneLink(scene), ` at ${number(finger.first_slip, 2)} s; no finger slips earlier.`,
        ...list, ...more, list.length ? "." : ""]];
}

function forceAnswer(scenes) {
    const question = "Largest force with Pinch?", peaks = scenes.flatMap((scene) => fingersOf(scene).map((finger) => ({ scene, finger })));
    if (!peaks.length) return [question, "–", ""];
    const { scene, finger } = peaks.reduce((a, b) => (b.finger.peak_force > a.finger.peak_force ? b : a));
    return [question, `${number(finger.peak_force, 4)} N`, ["The normal force of finger ", fingerName(finger), " in ", sceneLink(scene),
        ` at ${number(finger.peak_force_time, 3)} s.`]];
}

function quickAnswer(scenes) {
    const lost = scenes.filter((s) => !held(quickOf(s))), kept = scenes.filter((s) => held(quickOf(s)));
    const unknown = kept.filter((s) => quickOf(s).own_error === null), off = kept.filter((s) => quickOf(s).own_error > CLOSE);
    const known = scenes.length - unknown.length, close = kept.length - unknown.length - off.length;
    const short = lost.length ? `Drops ${lost.length}${off.length ? `, errs in ${off.length} more` : ""}`
        : off.length ? `Errs in ${off.length} of ${known}${unknown.length ? " compared" : ""}`
            : !close ? "Not compared" : unknown.length ? `In none of ${known} compared` : "Nowhere by 1 %";
    return ["Where is quickstep wrong?", short, [...(lost.length ? ["It drops the object in ", ...sceneLinks(lost), ". "] : []),
        ...(off.length ? ["It holds, with forces that miss ODE’s friction law by more than 1 %, in ", ...sceneLinks(off), ". "]
            : close ? [`Where it holds${unknown.length ? " and was compared" : ""}, its forces meet ODE’s friction law to 1 %. `] : []),
        ...(unknown.length ? ["It holds, and its forces were not compared with ODE’s friction law, in ", ...sceneLinks(unknown), "."] : [])],
    lost.length ? "bad" : ""];
}

function costAnswer(scenes) {
    const question = "What did it cost?", ratio = (s) => pinchOf(s).metrics.cost / quickOf(s).metrics.cost;
    const timed = scenes.filter((s) => Number.isFinite(ratio(s))).sort((a, b) => ratio(a) - ratio(b));
    if (!timed.length) return [question, "–", ""];
    const times = (s) => `${number(ratio(s), 2)} ×`, least = timed[0], most = timed[timed.length - 1];
    return [question, `${times(timed[Math.floor(timed.length / 2)])} quickstep’s time`, ["For a step of Pinch in the median scene. The least is ",
        `${times(least)} in `, sceneLink(least), `, the most ${times(most)} in `, sceneLink(most), "."]];
}

function allAnswers(scenes) {
    const quick = scenes.filter(quickOf);
    return [holdAnswer(scenes), slipAnswer(scenes), forceAnswer(scenes), ...(quick.length ? [quickAnswer(quick), costAnswer(quick)] : [])];
}

function inUnit(metres) {
    const [factor, unit] = lengthUnit(Math.abs(metres));
    return Math.abs(metres) < 1e-12 ? "less than 1 pm" : `${number(factor * metres, 3)} ${unit}`;
}

function sceneAnswers(scene) {
    const pinch = pinchOf(scene), quick = quickOf(scene), fingers = fingersOf(scene);
    const slip = firstSlip(scene);
    const near = fingers.filter((f) => f.least_margin !== null).sort((a, b) => a.least_margin - b.least_margin)[0];
    const peak = [...fingers].sort((a, b) => b.peak_force - a.peak_force)[0];
    const list = [held(pinch) ? ["Does it hold?", "Yes", [
        pinch.metrics.creep_in_hand === null ? "" : `In the second half of the run it creeps ${inUnit(pinch.metrics.creep_in_hand)}/s. `,
        isCompared(scene) ? "" : "No step’s forces were compared with the exact solution."], "good"]
        : ["Does it hold?", "No", `Dropped at ${number(dropTime(pinch), 3)} s.`, "bad"],
    slip ? ["Who slips first?", `Finger ‘${slip.name}’`, `All of its contact slips for the first time in Pinch’s run at ${number(slip.first_slip, 3)} s.`]
        : ["Who slips first?", "None", near ? `Finger ‘${near.name}’ comes nearest in Pinch’s run: its least margin is ${percent(near.least_margin)} of the friction that it could bear.` : ""],
    ["Largest force?", peak && peak.peak_force ? `${number(peak.peak_force, 4)} N` : "–", peak && peak.peak_force ? `The normal force of finger ‘${peak.name}’ in Pinch’s run at ${number(peak.peak_force_time, 3)} s.` : ""]];
    if (!quick) return list;
    const creep = quick.metrics.creep_in_hand, lost = !held(quick) && held(pinch);
    list.push(["Where is quickstep wrong?", lost ? "It drops the object" : `${inUnit(quick.metrics.divergence_end)} off at the end`,
        `${lost ? `At ${number(dropTime(quick), 3)} s. ` : `The object ends so far from where Pinch’s run has it. ${creep > 1e-9 && creep > 10 * pinch.metrics.creep_in_hand ? `It creeps ${inUnit(creep)}/s. ` : ""}`}`
        + (quick.own_error === null ? "Its forces were not compared with ODE’s friction law."
            : `Its forces miss ODE’s friction law by up to ${percent(quick.own_error)}`
                + (quick.model_difference === null ? "." : `; ODE’s law differs from the scene’s by up to ${percent(quick.model_difference)}.`)),
        lost ? "bad" : ""]);
    list.push(["What did it cost?", `${number(pinch.metrics.cost, 3)} µs a step`,
        `This is Pinch’s; quickstep’s takes ${number(quick.metrics.cost, 3)} µs. Pinch costs ${number(pinch.metrics.cost / quick.metrics.cost, 2)} times as much.`]);
    return list;
}

/* ---- Tables. ---- */

const FRONT = ["creep_in_hand", "slip_margin", "grip_force", "cost"];

function show(metric, value) {
    if (value === null || value === undefined) return "–";
    if (value === true || value === false) return value ? "yes" : "no";
    if (metric.unit === "m" || metric.unit === "m/s") return `${inUnit(value)}${metric.unit.slice(1)}`;
    return `${number(value, 3)}${metric.unit === "1" || !metric.unit ? "" : ` ${metric.unit.replace("us", "µs")}`}`;
}

function table(scene, runs, rows, caption) {
    const colour = (run) => `var(--${run.contact_solver})`;
    const head = make("tr", {}, make("th", { scope: "col" }, ""),
        ...runs.map((r) => make("th", { scope: "col" }, make("i", { style: `background:${colour(r)}` }), runName(r))));
    const body = rows.map(([label, about, cell]) => make("tr", {}, make("th", { scope: "row", title: about }, label),
        ...runs.map((run) => {
            const [text, value, key] = cell(run), td = make("td", { "data-scene": scene.name, "data-run": run.run,
                "data-metric": key, "data-value": value === null || value === undefined ? "" : String(Number(value)) }, text);
            return td;
        })));
    return make("div", { class: "wide" }, make("table", { class: "numbers" }, make("caption", {}, caption),
        make("thead", {}, head), make("tbody", {}, ...body)));
}

const metricRow = (metric) => [metric.label, metric.about, (run) => [show(metric, run.metrics[metric.key]), run.metrics[metric.key], metric.key]];
const errorRows = [
    ["error under its own law", "largest over the sampled steps, of the largest force: for Pinch against the exact answer, for "
        + "quickstep against worldstep’s direct solution of the same contacts",
        (run) => [run.own_error === null ? "–" : run.own_error <= EXACT ? `exact, ${number(run.own_error, 2)}` : percent(run.own_error), run.own_error, "own_error"]],
    ["difference of the law", "how far ODE’s law (rigid sideways, no torsion, a box for the friction cone), solved directly, is "
        + "from the scene’s law: a matter of the model, and no error of the solver",
        (run) => [run.contact_solver === "pinch" ? "none" : percent(run.model_difference), run.model_difference, "model_difference"]],
];

function tables(scene) {
    const box = make("div"), all = make("input", { type: "checkbox" });
    const fill = () => {
        const runs = all.checked ? scene.runs : mainRuns(scene);
        const front = FRONT.map((key) => report.metrics.find((m) => m.key === key)).filter(Boolean);
        box.replaceChildren(
            table(scene, runs, [...errorRows, ...front.map(metricRow)], "What matters most"),
            make("details", box.open ? { open: "" } : {}, make("summary", {}, `All ${report.metrics.length} metrics`),
                table(scene, runs, report.metrics.map(metricRow), "Point at a name for what it means")));
        const details = box.querySelector("details");
        details.addEventListener("toggle", () => (box.open = details.open));
    };
    all.addEventListener("change", fill);
    fill();
    const more = scene.runs.length > mainRuns(scene).length ? [make("label", { class: "screen" }, all, ` Show all ${scene.runs.length} runs`)] : [];
    const lacks = [...new Set(scene.runs.flatMap((r) => r.not_expressed))];
    const missing = lacks.length ? [make("details", {}, make("summary", {}, "What ODE’s law lacks of this scene"),
        make("ul", {}, ...lacks.map((text) => make("li", {}, text))))] : [];
    return [make("h3", {}, "Numbers"), ...more, box, ...missing];
}

/* ---- One scene at a time. ---- */

let current = null, opened = 0;

/* Plays Pinch's film beside another one, from `time` on where that is given. What is opened later wins. */
async function play(place, films, beside, time) {
    const mine = ++opened, view = make("section");
    if (window.viewer instanceof Viewer) window.viewer.close();
    window.viewer = null;
    place.replaceChildren(view);
    const viewer = await Viewer.open(view, films[0], films[beside] || null);
    if (mine !== opened) {
        viewer.close();
        return;
    }
    if (time !== null) viewer.seek(time);
    window.viewer = viewer;
}

/* Which run is shown beside Pinch's. */
function chooser(place, films) {
    if (films.length < 3) return [];
    const select = make("select", { id: "beside", onchange: () =>
        play(place, films, Number(select.value), window.viewer ? window.viewer.time : null) },
    ...films.slice(1).map((f, k) => make("option", { value: String(k + 1) }, f.solver)));
    return [make("p", { class: "beside" }, make("label", { for: "beside" }, "Beside Pinch’s run:"), select)];
}

async function choose(index, focus) {
    const scene = report.scenes[index];
    if (!scene || current === index) return;
    current = index;
    for (const item of document.querySelectorAll("[data-scene]"))
        if (item.matches("a, button")) item.toggleAttribute("aria-current", Number(item.dataset.scene) === index);
    const place = document.getElementById("scene"), view = make("div"), films = scene.films || [];
    place.replaceChildren(make("h2", { tabindex: "-1" }, scene.name),
        make("p", { class: "note" }, `${number(scene.time_s, 3)} s in ${scene.steps} steps of ${number(1e3 * scene.step_s, 2)} ms.`
            + ` ODE’s solvers get ${scene.contacts === "pinch" ? "the points of Pinch’s manifolds" : "their collider’s contact points"}.`),
        make("div", { class: "answers" }, ...answerCards(sceneAnswers(scene))), ...chooser(view, films), view,
        ...tables(scene));
    if (focus) place.firstChild.focus({ preventScroll: false });
    if (films.length) await play(view, films, 1, null);
}

function list(scenes) {
    return scenes.map((scene, i) => {
        const picture = make("span", { class: "thumb" });
        picture.innerHTML = scene.thumb || "";
        const quick = quickOf(scene), said = held(pinchOf(scene)) ? "held" : "dropped";
        const button = make("button", { type: "button", onclick: () => (location.hash = `#${i + 1}`) }, picture,
            make("span", {}, scene.name, make("small", {}, `Pinch: ${said}`), ...(quick ? [make("small", {}, `quickstep: ${WORDS[verdict(quick)[0]]}`)] : [])));
        button.dataset.scene = i;
        return button;
    });
}

function moves(check) {
    if (!check) return [];
    if (!check.moved.length) return [make("p", { class: "note" }, `Against ${check.baseline}: nothing moved.`)];
    const rows = check.moved.map((m) => make("tr", {}, ...["scene", "run", "metric", "from", "to", "limit"].map((k) =>
        make("td", {}, typeof m[k] === "number" ? number(m[k], 4) : String(m[k] ?? "–")))));
    return [make("details", { open: "" }, make("summary", {}, `Against ${check.baseline}: ${check.moved.length} metrics moved`),
        make("div", { class: "wide" }, make("table", {}, make("thead", {}, make("tr", {}, ...["scene", "run", "metric", "from", "to", "limit"]
            .map((h) => make("th", { scope: "col" }, h)))), make("tbody", {}, ...rows))))];
}

function start() {
    const scenes = report.scenes, main = document.getElementById("report-page");
    if (!scenes.length) {
        main.append(make("p", {}, "No scene has a result."));
        return;
    }
    main.append(make("p", { class: "lead" }, lead(scenes)), ...map(scenes), ...moves(report.check),
        make("section", { class: "all" }, make("h2", {}, "In all scenes"), make("div", { class: "answers" }, ...answerCards(allAnswers(scenes)))),
        make("div", { class: "scenes" }, make("nav", { class: "list", "aria-label": "Scenes" }, ...list(scenes)),
            make("article", { class: "scene", id: "scene" })));
    const wanted = () => Math.min(scenes.length, Math.max(1, Number(location.hash.slice(1)) || 1)) - 1;
    addEventListener("hashchange", () => choose(wanted(), true));
    choose(wanted(), false);
}

start();
