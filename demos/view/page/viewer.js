/* The viewer: picture, time, switches, numbers and charts of one run, with another as a ghost. */
"use strict";

function make(tag, attributes = {}, ...children) {
    const element = document.createElement(tag);
    for (const key in attributes) {
        if (key.startsWith("on")) element.addEventListener(key.slice(2), attributes[key]);
        else if (attributes[key] !== null) element.setAttribute(key, attributes[key]);
    }
    element.append(...children);
    return element;
}

const SWITCHES = [["forces", "Forces", "f"], ["cones", "Friction cones", "c"], ["points", "Contact points", "p"],
    ["ghost", "quickstep’s run", "g"], ["follow", "Follow the object", "o"]];
const SPEEDS = [0.01, 0.05, 0.1, 0.25, 0.5, 1, 2, 4];
const KEYS = [["Space", "play, pause"], ["← →", "one picture back, on (with Shift: ten)"], ["Home End", "to the start, to the end"],
    ["< >", "slower, faster"], ["F C P G O", "forces, cones, contact points, ghost, follow"], ["R", "the first view"],
    ["arrows + −", "turn and zoom, when the picture has the focus"]];

class Viewer {
    /* Fills `parent`, which is emptied. Both descriptions are those of films; the ghost's may be null. */
    static async open(parent, description, ghost) {
        const [film, other] = await Promise.all([Film.open(description), ghost ? Film.open(ghost) : null]);
        return new Viewer(parent, film, other);
    }

    constructor(parent, film, ghost) {
        Object.assign(this, { film, ghost, time: 0, speed: 1, playing: false, parent });
        parent.textContent = "";
        parent.classList.add("viewer");
        this.canvas = make("canvas", { tabindex: "0", role: "img", "aria-label":
            `The scene in 3-D with its contact forces and friction cones. Arrow keys turn it, plus and minus zoom.` });
        const left = make("div", { class: "left" }, make("div", { class: "stage" }, this.canvas, this.legend()),
            this.transport(), this.switches());
        const right = make("div", { class: "right" }, this.readout(), (this.plots = make("div", { class: "charts" }, ...(ghost ? [make("p", { class: "note" },
                `Solid lines are Pinch’s, dashed ones ${ghost.solver}’s. `, make("span", { class: "screen" },
                    "Press or drag in a chart to set the time."))] : []))));
        parent.append(left, right);
        this.charts = new Charts(this.plots, film, ghost, (t) => this.seek(t));
        this.makeStage();
        this.listen();
        if (this.carried()) this.show("follow", true);
        this.seek(0.5 * film.end); /* something is to be seen; playing begins at the start */
        this.fresh = true;
        if (ghost && this.apart() > 0.02 * film.radius) this.show("ghost", true);
    }

    /* How far the two runs' objects are apart at the end, m. */
    apart() {
        const object = this.film.bodyCalled("object");
        const a = this.film.pose(object, this.film.frames - 1), b = this.ghost.pose(object, this.ghost.frames - 1);
        return Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    }

    /* Would the object leave the first view? How much room there is around it depends on its fingers. */
    carried() {
        const object = this.film.bodyCalled("object");
        for (let k = 0; this.stage && k < this.film.frames; k++)
            if (this.film.motion(object, k).moved > this.stage.room) return true;
        return false;
    }

    makeStage() {
        if (document.createElement("canvas").getContext("webgl")) {
            this.stage = new Stage(this.canvas, this.film, this.ghost);
        } else {
            this.canvas.parentElement.replaceChildren(make("p", { class: "sorry" }, "This browser has no WebGL: "
                + "the picture is missing. Charts and numbers are complete."));
        }
    }

    legend() {
        const swatch = (name, text) => make("span", {}, make("i", { style: `background:var(--${name})` }), text);
        return make("p", { class: "legend" }, swatch("pinch", "force by Pinch"),
            ...(this.ghost ? [swatch(this.ghost.solver, `${this.ghost.solver}’s run and forces`)] : []),
            swatch("stick", "sticks"), swatch("near", "near its limit"), swatch("slip", "slips"),
            ...(this.film.yields ? [swatch("yield", "yields")] : []));
    }

    transport() {
        this.playButton = make("button", { type: "button", class: "play", onclick: () => this.toggle() }, "Play");
        this.slider = make("input", { type: "range", min: "0", max: String(this.film.end), step: "any", value: "0",
            "aria-label": "Time", oninput: () => this.seek(Number(this.slider.value)) });
        this.clock = make("output", { class: "clock" });
        this.pace = make("select", { "aria-label": "Speed", onchange: () => (this.speed = Number(this.pace.value)) },
            ...SPEEDS.map((s) => make("option", { value: String(s), ...(s === 1 ? { selected: "" } : {}) }, `${s} ×`)));
        return make("div", { class: "transport" }, this.playButton, this.slider, this.clock, this.pace);
    }

    switches() {
        this.boxes = {};
        const row = make("div", { class: "switches" });
        for (const [name, text, key] of SWITCHES) {
            if (name === "ghost" && !this.ghost) continue;
            const box = make("input", { type: "checkbox", "aria-keyshortcuts": key, onchange: () => this.show(name, box.checked) });
            box.checked = name === "forces" || name === "cones";
            this.boxes[name] = box;
            row.append(make("label", {}, box, " ", name === "ghost" ? `${this.ghost.solver}’s run` : text));
        }
        const keys = make("dl", {}, ...KEYS.flatMap(([key, what]) => [make("dt", {}, key), make("dd", {}, what)]));
        row.append(make("button", { type: "button", onclick: () => this.stage && this.stage.reset() }, "Reset view"),
            make("details", { class: "keys" }, make("summary", {}, "Keys"), keys));
        return row;
    }

    readout() {
        const heads = ["finger", "state", "normal N", "tangential N", "margin", "slip µm"];
        this.moment = make("span");
        this.cells = this.film.fingers.map(() => heads.slice(1).map(() => make("td")));
        const body = this.film.fingers.map((f, i) => make("tr", {}, make("th", { scope: "row" },
            make("i", { style: `background:var(${SERIES[i % SERIES.length]})` }), f.name), ...this.cells[i]));
        return make("div", { class: "wide" }, make("table", { class: "readout" },
            make("caption", {}, "The fingers at ", this.moment, " (margin: the part of its friction that a finger has left)"),
            make("thead", {}, make("tr", {}, ...heads.map((h) => make("th", { scope: "col" }, h)))),
            make("tbody", {}, ...body)));
    }

    show(name, on) {
        this.boxes[name].checked = on;
        if (!this.stage) return;
        this.stage.shown[name] = on;
        this.stage.update(this.time);
    }

    /* The numbers are those of the run at the last frame, and not interpolated. */
    seek(t) {
        this.fresh = false;
        this.time = Math.min(this.film.end, Math.max(0, t));
        const frame = this.film.frameAt(this.time);
        this.slider.value = String(this.time);
        this.clock.textContent = `${this.time.toFixed(3)} s`;
        this.slider.setAttribute("aria-valuetext", `${this.time.toFixed(3)} seconds`);
        if (this.stage) this.stage.update(this.time);
        this.charts.update(this.time);
        if (frame === this.shownFrame) return;
        this.shownFrame = frame;
        this.moment.textContent = `${this.film.time[frame].toFixed(3)} s`;
        this.film.fingers.forEach((_, i) => {
            const f = this.film.finger(i, frame), cells = this.cells[i];
            const texts = [f.state, number(f.normal), number(f.tangential), number(f.margin, 4), number(1e6 * f.slip, 4)];
            texts.forEach((text, k) => (cells[k].textContent = text));
            cells[0].className = `state ${f.state}`;
            cells[1].dataset.value = String(f.normal);
        });
    }

    toggle(on = !this.playing) {
        if (on === this.playing) return;
        this.playing = on;
        this.playButton.textContent = on ? "Pause" : "Play";
        if (!on) {
            if (this.stage) this.stage.setQuality(1);
            return;
        }
        if (this.fresh || this.time >= this.film.end) this.seek(0);
        let before = performance.now(), spent = 0, pictures = 0;
        const tick = (now) => {
            if (!this.playing) return;
            /* Time is the clock's: a slow renderer leaves pictures out. After a long pause of the browser the run goes on
             * where it was, and does not jump. */
            const passed = Math.min(1, Math.max(0, now - before) / 1000);
            before = now;
            spent += passed;
            if (++pictures === 12) {
                if (this.stage && spent > 12 / 45) this.stage.setQuality(0.8 * this.stage.quality);
                spent = pictures = 0;
            }
            this.seek(this.time + this.speed * passed);
            if (this.time >= this.film.end) this.toggle(false);
            else requestAnimationFrame(tick);
        };
        requestAnimationFrame(tick);
    }

    step(frames) {
        this.toggle(false);
        const k = Math.min(this.film.frames - 1, Math.max(0, this.film.frameAt(this.time) + frames));
        this.seek(this.film.time[k]);
    }

    faster(by) {
        const k = Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(this.speed) + by));
        this.speed = SPEEDS[k];
        this.pace.value = String(this.speed);
    }

    pictureKey(event) {
        const turns = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
        if (!this.stage) return false;
        if (turns[event.key]) this.stage.orbit(...turns[event.key]);
        else if (event.key === "+" || event.key === "=") this.stage.zoom(0.9);
        else if (event.key === "-") this.stage.zoom(1 / 0.9);
        else return false;
        return true;
    }

    key(event) {
        const many = event.shiftKey ? 10 : 1, letter = event.key.toLowerCase();
        const named = SWITCHES.find(([name, , key]) => key === letter && this.boxes[name]);
        if (named) this.show(named[0], !this.boxes[named[0]].checked);
        else if (event.key === " ") this.toggle();
        else if (event.key === "ArrowLeft") this.step(-many);
        else if (event.key === "ArrowRight") this.step(many);
        else if (event.key === "Home") this.seek(0);
        else if (event.key === "End") this.seek(this.film.end);
        else if (event.key === "<" || event.key === ",") this.faster(-1);
        else if (event.key === ">" || event.key === ".") this.faster(1);
        else if (letter === "r" && this.stage) this.stage.reset();
        else return false;
        return true;
    }

    /* Keys are the viewer's unless they belong to what has the focus. */
    listen() {
        const owns = (target, key) => /^(SELECT|TEXTAREA)$/.test(target.tagName)
            || (key === " " && /^(BUTTON|SUMMARY|A|INPUT)$/.test(target.tagName) && target !== this.slider);
        this.onKey = (event) => {
            if (event.ctrlKey || event.altKey || event.metaKey || owns(event.target, event.key)) return;
            if ((event.target === this.canvas && this.pictureKey(event)) || this.key(event)) event.preventDefault();
        };
        this.onColours = () => {
            if (this.stage) this.stage.recolour();
            this.charts.recolour();
        };
        /* On paper the picture is drawn at once, in the colours of paper. */
        this.onPrint = () => {
            this.onColours();
            if (this.stage) this.stage.draw();
        };
        /* Browsers print canvases as they were, and not as they would be drawn for the page. */
        this.onPaper = (event) => this.charts.keepSize(event.type === "beforeprint");
        this.dark = matchMedia("(prefers-color-scheme: dark)");
        this.paper = matchMedia("print");
        document.addEventListener("keydown", this.onKey);
        this.dark.addEventListener("change", this.onColours);
        this.paper.addEventListener("change", this.onPrint);
        addEventListener("beforeprint", this.onPaper);
        addEventListener("afterprint", this.onPaper);
        this.watcher = new ResizeObserver(() => {
            this.charts.resize();
            this.charts.update(this.time);
        });
        this.watcher.observe(this.plots);
    }

    close() {
        this.toggle(false);
        document.removeEventListener("keydown", this.onKey);
        this.dark.removeEventListener("change", this.onColours);
        this.paper.removeEventListener("change", this.onPrint);
        removeEventListener("beforeprint", this.onPaper);
        removeEventListener("afterprint", this.onPaper);
        this.watcher.disconnect();
        if (this.stage) this.stage.close();
        this.charts.close();
    }
}
