/* The page of one run: five answers, and the viewer. */
"use strict";

const read = (id) => JSON.parse(document.getElementById(id).textContent);

function length(metres) {
    if (Math.abs(metres) < 1e-12) return "less than 1 pm";
    const [factor, unit] = lengthUnit(Math.abs(metres));
    return `${number(factor * metres, 3)} ${unit}`;
}

const eventOf = (run, type) => run.events.find((e) => e.type === type);

/* Each answer is a question, a short answer, a sentence that adds to it, and good, bad or neither. */
function holds(run) {
    const dropped = eventOf(run, "dropped"), crushed = eventOf(run, "crush"), moved = run.object.motion_in_hand;
    if (run.status !== "converged" && run.status !== "max_iterations")
        return ["No answer", `The run ended as ${run.status} at ${number(run.time_s, 4)} s.`, "bad"];
    if (dropped) return ["No", `The object is dropped at ${number(dropped.time, 4)} s.`, "bad"];
    const drift = moved.creep === null ? "" : ` From half time on it moves ${length(moved.creep * run.time_s / 2)} in the hand.`;
    if (crushed) return ["It is crushed", `${crushed.finger} exceeds ${number(crushed.limit, 4)} N at ${number(crushed.time, 4)} s.`, "bad"];
    if (!run.touched) return ["No", "No finger touches an object at the end.", "bad"];
    return ["Yes", `The object is held until the end, ${number(run.time_s, 4)} s.${drift}`, "good"];
}

function slipsFirst(film) {
    const first = film.fingers.filter((f) => f.first_slip !== null).sort((a, b) => a.first_slip - b.first_slip)[0];
    const closest = film.fingers.filter((f) => f.least_margin !== null).sort((a, b) => a.least_margin - b.least_margin)[0];
    if (first) return [first.name, `All of its contact slips for the first time at ${number(first.first_slip, 4)} s.`, ""];
    if (!closest) return ["None", "No finger has friction under load.", ""];
    return ["None", `${closest.name} comes nearest: its least margin, at ${number(closest.least_margin_time, 4)} s, is ${number(100 * closest.least_margin, 3)} % of the friction that it could bear.`, ""];
}

function largestForce(film) {
    const most = [...film.fingers].sort((a, b) => b.peak_force - a.peak_force)[0];
    if (!most || !(most.peak_force > 0)) return ["–", "No finger presses.", ""];
    return [`${number(most.peak_force, 4)} N`, `Normal force of ${most.name} at ${number(most.peak_force_time, 4)} s.`, ""];
}

function whereWrong(run, ghost) {
    if (!ghost) return ["Not run", "This page has no run of quickstep’s beside it.", ""];
    const dropped = eventOf(ghost, "dropped"), held = !eventOf(run, "dropped");
    if (dropped && held) return ["It drops the object", `At ${number(dropped.time, 4)} s, with 20 iterations.`, "bad"];
    if (!dropped && !held) return ["It does not drop the object", "Pinch’s run, with exact friction, does.", "bad"];
    if (!ghost.touched && held && run.touched)
        return ["It leaves the object", "No finger touches one at the end, with 20 iterations.", "bad"];
    const apart = Math.hypot(...run.object.position.map((x, i) => x - ghost.object.position[i]));
    const creep = ghost.object.motion_in_hand.creep, own = run.object.motion_in_hand.creep;
    const worst = run.fingers.map((f, i) => [f.name, Math.hypot(...f.force.map((x, k) => x - ghost.fingers[i].force[k]))])
        .sort((a, b) => b[1] - a[1])[0];
    const creeps = creep > 10 * own && creep > 1e-9 ? ` It creeps ${length(creep)}/s, Pinch’s run ${length(own)}/s.` : "";
    return [`${length(apart)} at the end`, `The object ends this far from where it ends in Pinch’s run; the force of ${worst[0]} differs by ${number(worst[1], 3)} N.${creeps}`, ""];
}

function cost(run, ghost) {
    const ratio = ghost ? ` quickstep’s step takes ${number(ghost.step_us, 3)} µs: Pinch’s costs ${number(run.step_us / ghost.step_us, 2)} times as much.` : "";
    const verified = run.verification.passed === null ? "" : run.verification.passed ? " Every step is verified." : " Not every step is verified.";
    return [`${number(run.step_us, 3)} µs a step`, `${run.steps} steps.${ratio}${verified}`, run.verification.passed === false ? "bad" : ""];
}

function answers(run, film, ghost) {
    const list = [["Does it hold?", holds(run)], ["Who slips first?", slipsFirst(film)],
        ["Largest force?", largestForce(film)], ["Where is quickstep wrong?", whereWrong(run, ghost)],
        ["What did it cost?", cost(run, ghost)]];
    return list.map(([question, [short, long, tone]]) => make("div", { class: `answer ${tone}` },
        make("h2", {}, question), make("p", { class: "short" }, short), make("p", {}, long)));
}

if (document.getElementById("film")) {
    const page = read("film");
    document.getElementById("answers").append(...answers(page.run, page.film, page.ghost_run));
    /* #t=1.5 in the page's address shows that moment, #picture=1.5 the 3-D picture alone. */
    const [, kind, moment] = /^#(t|picture)=([0-9.]+)$/.exec(location.hash) || [];
    document.body.classList.toggle("bare", kind === "picture");
    Viewer.open(document.getElementById("view"), page.film, page.ghost).then((viewer) => {
        window.viewer = viewer;
        if (moment) viewer.seek(Number(moment));
    });
}
