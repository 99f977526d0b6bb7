#include "hand_statics.h"

#include "common/measure.h"
#include "common/vector.h"
#include "static_system.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- What the answer says. ---- */

static double slip_margin(const static_contact *c)
{
    double reach2 = 0;
    const double mu[3] = {c->data->friction[0], c->data->friction[1], c->data->torsional_friction};
    for (int i = 1; i < c->law.rows; i++)
        if (mu[i - 1] > 0) reach2 += pow((double)c->r[i] / mu[i - 1], 2);
    return c->law.rows > 1 && mu[0] > 0 ? 1 - sqrt(reach2) / (double)c->r[0] : NAN;
}

static void add_point(hand_static_finger *f, const static_contact *c)
{
    static const double AT_LIMIT = 1e-9; /* of the friction limit */
    double margin = slip_margin(c);
    bool slips = !(margin > AT_LIMIT), yields = c->r[0] >= c->law.most;
    pinch_contact_state state = yields ? PINCH_CONTACT_YIELD : slips ? PINCH_CONTACT_SLIP : PINCH_CONTACT_STICK;
    if (f->points++ == 0)
        f->state = state, f->slip_margin = margin;
    else if (f->state != state)
        f->state = PINCH_CONTACT_STICK;
    f->slip_margin = fmin(f->slip_margin, margin);
    f->normal_force += (double)c->r[0];
    if (c->law.rows == 4) f->torsional_moment += (double)c->r[3];
    for (int i = 0; i < 3; i++) scene_add_scaled(f->force, c->sign * (double)c->r[i], c->axis[i]);
    for (int i = 1; i < 3; i++) scene_add_scaled(f->tangential_force, c->sign * (double)c->r[i], c->axis[i]);
}

static bool tell_fingers(const static_system *s, hand_statics *answer)
{
    const world *w = s->w;
    answer->fingers = calloc((size_t)w->finger_count + 1, sizeof *answer->fingers);
    if (!answer->fingers) return false;
    for (int k = 0; k < w->finger_count; k++) {
        hand_static_finger *f = &answer->fingers[answer->finger_count];
        bool touches = false;
        *f = (hand_static_finger){.name = w->fingers[k].finger->name, .state = PINCH_CONTACT_OPEN, .slip_margin = NAN};
        for (int i = 0; i < s->contact_count; i++) {
            if (s->contacts[i].finger != k) continue;
            touches = true;
            if (s->contacts[i].r[0] > 0) add_point(f, &s->contacts[i]);
        }
        answer->finger_count += touches;
    }
    return true;
}

static void add_row(const static_row *b, hand_static_joint *j, int coordinate)
{
    double force = b->a[coordinate] * (double)b->y;
    bool drives = b->kind == STATIC_MOTOR || b->kind == STATIC_TENDON;
    if (b->a[coordinate] == 0) return;
    *(drives ? &j->torque : &j->passive_torque) += force;
    if (drives && (b->y >= b->high || b->y <= b->low)) j->saturated = true;
    bool stop = b->kind == STATIC_PASSIVE && b->rigid && (isinf(b->low) || isinf(b->high));
    if (stop && b->y != 0) j->at_limit = true;
}

static bool tell_joints(const static_system *s, const long double *z, hand_statics *answer)
{
    const world *w = s->w;
    answer->joints = calloc((size_t)s->coordinates + 1, sizeof *answer->joints);
    if (!answer->joints) return false;
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *from = &w->hands[k].joints[i];
            hand_static_joint *j = &answer->joints[answer->joint_count++];
            int at = s->first_joint[k] + i;
            j->name = from->of->name;
            j->hand = w->hands[k].hand->name;
            j->position = from->position + (double)z[at];
            j->target = from->control->type == SCENE_POSITION_CONTROL ? from->target : NAN;
            j->weight_torque = s->weight[at];
            for (int c = 0; c < s->contact_count; c++)
                for (int r = 0; r < s->contacts[c].law.rows; r++)
                    j->contact_torque += s->contacts[c].g[r * s->coordinates + at] * (double)s->contacts[c].r[r];
            for (int b = 0; b < s->row_count; b++) add_row(&s->rows[b], j, at);
        }
    return true;
}

/* ---- The solve, in the midst of a step of the world. ---- */

typedef struct watching {
    hand_statics *answer;
    bool fine;
} watching;

/* An object that has a load and no contact: nothing can hold it, and no search is needed. -1: there is none. */
static int find_untouched(const static_system *s)
{
    for (int k = 0; k < s->w->object_count; k++) {
        bool loaded = false, touched = false;
        for (int i = 0; i < 6; i++) loaded = loaded || s->load[6 * k + i] != 0;
        for (int c = 0; c < s->contact_count; c++)
            for (int side = 0; side < 2; side++)
                touched = touched || s->contacts[c].body[side] == s->w->objects[k].body;
        if (loaded && !touched) return k;
    }
    return -1;
}

static bool refute(const static_system *s, int untouched, hand_statics *answer)
{
    const double *load = s->load + 6 * untouched;
    snprintf(answer->why, sizeof answer->why, "nothing touches %.200s", s->w->scene->objects[untouched].name);
    answer->status = HAND_STATICS_INFEASIBLE;
    answer->unknowns = s->unknowns;
    answer->residual = hypot(scene_norm(load), scene_norm(load + 3) / s->lever);
    return true;
}

static bool solve_system(static_system *s, hand_statics *answer)
{
    int untouched = find_untouched(s);
    if (untouched >= 0) return refute(s, untouched, answer);
    static_errors e;
    long double *z = calloc((size_t)s->unknowns + 1, sizeof *z);
    double start = clock_seconds();
    bool found = false;
    answer->unknowns = s->unknowns;
    answer->steps = z ? static_solve(s, z, &answer->residual, &found) : -1;
    bool fine = answer->steps >= 0;
    answer->status = HAND_STATICS_NOT_FOUND;
    answer->time = clock_seconds() - start;
    if (found) {
        answer->status = static_check(s, z, &e) ? HAND_STATICS_SOLVED : HAND_STATICS_UNVERIFIED;
        answer->force_error = e.force, answer->torque_error = e.torque;
        answer->joint_error = e.joint, answer->motor_error = e.motor;
        answer->cone = e.cone, answer->normal_law = e.normal, answer->slip_direction = e.slip_direction;
        answer->force_scale = e.scale;
        for (int i = 0; i < 3; i++) {
            answer->translation[i] = (double)z[i];
            answer->rotation[i] = (double)z[3 + i];
        }
        fine = tell_fingers(s, answer) && tell_joints(s, z, answer);
    }
    free(z);
    return fine;
}

static void watch(void *context, const world *w)
{
    watching *x = context;
    static_system s;
    x->fine = static_system_read(&s, w, x->answer->why);
    if (x->fine) {
        x->fine = solve_system(&s, x->answer);
    } else if (x->answer->why[0]) {
        x->answer->status = HAND_STATICS_UNSUPPORTED;
        x->fine = true;
    }
    static_system_free(&s);
}

bool hand_statics_solve(const scene *s, double time, hand_statics *answer)
{
    world_settings settings = world_default_settings(s);
    world *w;
    watching x = {.answer = answer, .fine = true};
    *answer = (hand_statics){.status = HAND_STATICS_FAILED};
    if (world_create(s, &settings, &w, answer->why) != WORLD_OK) return true;
    long steps = lround(time / s->step);
    world_status status = WORLD_OK;
    while (w->steps < steps && status == WORLD_OK) status = world_advance(w);
    w->observe = watch;
    w->observe_context = &x;
    if (status == WORLD_OK) status = world_advance(w);
    if (status == WORLD_DIVERGED) snprintf(answer->why, sizeof answer->why, "the run diverges");
    if (status == WORLD_OK && world_solve_status(w) != PINCH_SOLVE_CONVERGED && answer->status <= 1) {
        answer->status = HAND_STATICS_FAILED;
        snprintf(answer->why, sizeof answer->why, "a step of the run was not solved");
    }
    world_free(w);
    return x.fine && status != WORLD_NO_MEMORY;
}

void hand_statics_free(hand_statics *answer)
{
    free(answer->fingers);
    free(answer->joints);
    memset(answer, 0, sizeof *answer);
}
