/* A film as the page holds it: one block of numbers, and a description of where what lies in it. */
"use strict";

const STATES = ["open", "stick", "slip", "yield"];

async function inflate(text) {
    const packed = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Response(stream).arrayBuffer();
}

class Film {
    static async open(description) {
        return new Film(description, await inflate(description.data));
    }

    constructor(description, bytes) {
        Object.assign(this, description);
        this.data = null;
        this.bytes = bytes;
        this.time = this.floats(this.time_at, this.frames);
        this.poses = this.bodies.map((b) => (b.track_at === null ? null : this.floats(b.track_at, 7 * this.frames)));
        this.series = this.fingers.map((f) => this.floats(f.series_at, 6 * this.frames));
        this.firsts = new Uint32Array(bytes, this.contacts.first_at, this.frames + 1);
        this.points = this.floats(this.contacts.at, 14 * this.firsts[this.frames]);
        this.end = this.time[this.frames - 1];
    }

    floats(at, count) {
        return new Float32Array(this.bytes, at, count);
    }

    /* The last frame that is not after t. */
    frameAt(t) {
        let low = 0, high = this.frames - 1;
        while (low < high) {
            const middle = (low + high + 1) >> 1;
            if (this.time[middle] <= t) low = middle;
            else high = middle - 1;
        }
        return low;
    }

    /* Where t lies between its frame and the next, 0 to 1. */
    partAt(frame, t) {
        if (frame + 1 >= this.frames) return 0;
        return Math.min(1, Math.max(0, (t - this.time[frame]) / (this.time[frame + 1] - this.time[frame])));
    }

    /* Position (x, y, z) and quaternion (w, x, y, z) of a body. */
    pose(body, frame) {
        const track = this.poses[body];
        return track ? track.subarray(7 * frame, 7 * frame + 7) : this.bodies[body].place;
    }

    /* What a finger does in a frame. Numbers that do not exist are NaN. */
    finger(index, frame) {
        const s = this.series[index].subarray(6 * frame, 6 * frame + 6);
        return { normal: s[0], tangential: s[1], margin: s[2], slip: s[3], size: s[4], state: STATES[s[5]] };
    }

    contactCount(frame) {
        return this.firsts[frame + 1] - this.firsts[frame];
    }

    contact(frame, k) {
        const p = this.points.subarray(14 * (this.firsts[frame] + k), 14 * (this.firsts[frame] + k) + 14);
        return { pair: p[0], place: p[1], state: STATES[p[2]], position: p.subarray(3, 6), normal: p.subarray(6, 9),
            force: p.subarray(9, 12), margin: p[12], friction: p[13] };
    }

    /* A point of the same pair and place in another frame. */
    sameContact(contact, frame) {
        for (let k = 0; k < this.contactCount(frame); k++) {
            const other = this.contact(frame, k);
            if (other.pair === contact.pair && other.place === contact.place) return other;
        }
        return null;
    }

    bodyCalled(kind) {
        return this.bodies.findIndex((b) => b.kind === kind);
    }

    /* How far a body has moved (m) and turned (rad) from its first frame. */
    motion(body, frame) {
        const a = this.pose(body, 0), b = this.pose(body, frame);
        const along = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6];
        const w = [a[3] * b[4] - a[4] * b[3] - a[5] * b[6] + a[6] * b[5],
            a[3] * b[5] - a[5] * b[3] - a[6] * b[4] + a[4] * b[6],
            a[3] * b[6] - a[6] * b[3] - a[4] * b[5] + a[5] * b[4]];
        return { moved: Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]),
            turned: 2 * Math.atan2(Math.hypot(...w), Math.abs(along)) };
    }
}
